"""Keep some outputs of a kernel: what only the others need is dead code."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.model.errors import EmitError

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.codegen.kernel import Kernel


def select_outputs(kernel: Kernel, names: Collection[str]) -> Kernel:
    """Return the kernel of the named outputs only, in the kernel's order.

    The inputs stay as they are, those that are no longer read too, so that the signature does not
    depend on what cancels.

    Raises
    ------
    EmitError
        A name is not an output of the kernel.
    """
    known = [quantity.name for quantity in kernel.outputs]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise EmitError(
            f"kernel {kernel.name} has no output {', '.join(unknown)}; it has {', '.join(known)}"
        )
    kept = [k for k, name in enumerate(known) if name in names]
    return drop_dead(
        replace(
            kernel,
            outputs=tuple(kernel.outputs[k] for k in kept),
            results=tuple(kernel.results[k] for k in kept),
        )
    )
