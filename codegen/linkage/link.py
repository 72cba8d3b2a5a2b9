"""The rows of the frozen link element, each alone: ε1 needs no angle, ε2 and ε3 one end each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from kousoku.model.kernel import Kernel, Package


@dataclass(frozen=True, slots=True)
class LinkRow:
    """One of ε1, ε2, ε3 of Yamada and Tatsumi (1981), (5) to (7).

    Parameters
    ----------
    deformation : Kernel
        ``epsilon`` () [m] and its row of ``D`` (6,), (15), at ``x`` in frame O, ``length``,
        ``offset``.
    rate : Kernel
        Its element of ``D_dot_x_dot`` () [m/s²], at ``x``, ``length`` and ``x_dot``.
    """

    deformation: Kernel
    rate: Kernel


def rows_of(link: Package) -> tuple[LinkRow, LinkRow, LinkRow]:
    """Three rows of the frozen kind ``link``."""
    kernels = {kernel.name: kernel for kernel in link.kernels}
    first, second, third = (
        LinkRow(
            _only(kernels["deformation"], {"epsilon": (row, 1), "D": (6 * row, 6)}),
            _only(kernels["rate"], {"D_dot_x_dot": (row, 1)}),
        )
        for row in range(3)
    )
    return first, second, third


def _only(kernel: Kernel, wanted: dict[str, tuple[int, int]]) -> Kernel:
    """Keep some consecutive elements of some outputs."""
    outputs, results = [], []
    for quantity, result in zip(kernel.outputs, kernel.results, strict=True):
        if quantity.name in wanted:
            start, count = wanted[quantity.name]
            shape = (count,) if count > 1 else ()
            outputs.append(Quantity(quantity.name, shape, quantity.unit, quantity.meaning))
            results.append(result[start : start + count])
    return drop_dead(replace(kernel, outputs=tuple(outputs), results=tuple(results)))
