"""The two mechanisms of Yamada and Tatsumi (1981), their assembly from links, and their freedom."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

import sympy
from sympy.polys.matrices import DomainMatrix

from kousoku.ledger.proof import GENERAL
from kousoku.ledger.registry import Names
from kousoku.model.errors import LedgerError
from kousoku.symbolic.sympy_types import as_scalar

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.symbolic.sympy_types import Scalar

NAMES = Names(GENERAL)


#: What a matrix is made of: formulas, or numbers.
Cell = TypeVar("Cell")


@dataclass(frozen=True, slots=True)
class ExampleMechanism:
    """Links between nodes, joined by hinges.

    Parameters
    ----------
    nodes : int
        How many.
    links : tuple of (int, int)
        The first and the second node of each link, counted from 1 as in the figures.
    lengths : tuple of int [cm]
        Of each link.
    known : Mapping
        The displacements that are known, by name, and their values as the paper writes them.
    """

    nodes: int
    links: tuple[tuple[int, int], ...]
    lengths: tuple[int, ...]
    known: Mapping[str, str]

    @property
    def names(self) -> list[str]:
        """The displacements of the nodes, then the rotations of the links at their ends."""
        places = [f"{letter}_{node}" for node in range(1, self.nodes + 1) for letter in "uv"]
        count = range(1, len(self.links) + 1)
        return places + [f"ψ_{link}{end}" for link in count for end in (1, 2)]

    @property
    def unknown(self) -> list[int]:
        """Where the unknown displacements stand among the names."""
        return [k for k, name in enumerate(self.names) if name not in self.known]

    @property
    def prescribed(self) -> list[int]:
        """Where the known displacements stand among the names."""
        return [k for k, name in enumerate(self.names) if name in self.known]

    def ends(self, link: int) -> list[int]:
        """Places of u1 v1 ψ1 u2 v2 ψ2 of a link among the names."""
        first, second = self.links[link - 1]
        turn = 2 * (self.nodes + link - 1)
        return [2 * first - 2, 2 * first - 1, turn, 2 * second - 2, 2 * second - 1, turn + 1]

    def assembled(self, element: Callable[[int], Sequence[Sequence[Cell]]]) -> list[list[Cell]]:
        """Rows of all links, (17), from the three rows of each, (16)."""
        rows = []
        for link in range(1, len(self.links) + 1):
            for row in element(link):
                whole: list[Any] = [0] * len(self.names)
                for place, cell in zip(self.ends(link), row, strict=True):
                    whole[place] += cell
                rows.append(whole)
        return rows


#: Crank and connecting rod; node 3 slides on the x axis, so that v3 is known.
PISTON_CRANK = ExampleMechanism(
    3,
    ((1, 2), (2, 3)),
    (1, 2),
    MappingProxyType({"u_1": "0", "v_1": "0", "v_3": "0", "ψ_11": "Δα"}),
)
#: A closed loop; the fourth link is the frame, which does not turn at node 1.
LEVER_CRANK = ExampleMechanism(
    4,
    ((1, 2), (2, 3), (3, 4), (4, 1)),
    (30, 60, 80, 100),
    MappingProxyType({"u_1": "0", "v_1": "0", "ψ_11": "Δα", "ψ_42": "0"}),
)


# -- one degree of freedom -----------------------------------------------------------------------


def determinant(mechanism: ExampleMechanism) -> Scalar:
    """Determinant of the columns of the unknowns, with sines and cosines as letters."""
    letters = {k: sympy.symbols(f"c{k} s{k} l{k}") for k in range(1, len(mechanism.links) + 1)}

    def element(link: int) -> list[list[Scalar]]:
        c, s, l0 = letters[link]
        return [[-c, -s, 0, c, s, 0], [-s, c, l0, s, -c, 0], [s, -c, 0, -s, c, -l0]]

    rows = mechanism.assembled(element)
    square = sympy.Matrix([[row[k] for k in mechanism.unknown] for row in rows])
    if square.rows != square.cols:
        raise LedgerError(f"{square.rows} equations for {square.cols} unknowns")
    matrix = DomainMatrix.from_Matrix(square).to_field()
    return as_scalar(matrix.domain.to_sympy(matrix.det()))


@NAMES.proof()
def pistons_freedom() -> dict[str, bool]:
    """Look at the determinant of the piston crank, and at the rod's angle."""
    c1, s1, l1, c2, l2 = sympy.symbols("c1 s1 l1 c2 l2")
    crank, rod = PISTON_CRANK.lengths
    apart = determinant(PISTON_CRANK) - l1 * l2**2 * c2 * (c1**2 + s1**2)
    return {
        "6 equations, 6 unknowns, determinant l1 l2² cos β2": sympy.cancel(apart) == 0,
        f"cos β2 is never 0, as l1 = {crank} < l2 = {rod}": crank < rod,
        "one known displacement, of the crank, is not 0": _moved(PISTON_CRANK) == ["ψ_11"],
    }


@NAMES.proof()
def levers_freedom() -> dict[str, bool]:
    """Look at the determinant of the lever crank, and at where coupler and lever are in line."""
    c1, s1, l1, c2, s2, l2 = sympy.symbols("c1 s1 l1 c2 s2 l2")
    c3, s3, l3, c4, s4, l4 = sympy.symbols("c3 s3 l3 c4 s4 l4")
    want = -l1 * l2**2 * l3**2 * l4 * (s2 * c3 - c2 * s3)
    apart = determinant(LEVER_CRANK) - want * (c1**2 + s1**2) * (c4**2 + s4**2)
    a, b, c, d = LEVER_CRANK.lengths
    counted = "12 equations, 12 unknowns, determinant −l1 l2² l3² l4 sin(β2 − β3)"
    return {
        counted: sympy.cancel(apart) == 0,
        f"sin(β2 − β3) is never 0: O2 and O4 are {d - a} to {d + a} apart, "
        f"in line {abs(b - c)} or {b + c}": abs(b - c) < d - a and d + a < b + c,
        "one known displacement, of the crank, is not 0": _moved(LEVER_CRANK) == ["ψ_11"],
    }


def _moved(mechanism: ExampleMechanism) -> list[str]:
    return [name for name, value in mechanism.known.items() if value != "0"]
