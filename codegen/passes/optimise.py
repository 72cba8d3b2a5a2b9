"""The passes that every kernel of a kind goes through before it is emitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.passes.factor import factor
from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.codegen.passes.trace import run_passes

if TYPE_CHECKING:
    from kousoku.codegen.passes.trace import PassTrace
    from kousoku.model.operations.kernel import Kernel

#: In the order in which they run. None uses that Euler parameters have norm one.
PASSES = (drop_dead, factor)


def optimise(kernel: Kernel) -> tuple[Kernel, PassTrace]:
    """Kernel of the same results with fewer operations, and the trace of its passes."""
    return run_passes(kernel, PASSES)
