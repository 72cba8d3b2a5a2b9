"""The motion of a linkage in 50 digits: where references are taken."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.linkage.exact import Exact
from kousoku.model.linkage.input_motion import turns_of
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.directions import HALF_TURN
from kousoku.runtime.kinematics.rows import OF_NODES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.linkage.layout import WorkspaceLayout
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.planar import Input

#: Steps over the way of the inputs.
STEPS = 10
#: How often a step may be halved before it is said to meet a dead centre.
HALVINGS = 8
#: A correction this small, relative to the largest length, is the last.
DONE = CONTEXT.mpf(10) ** -40
MOST_CORRECTIONS = 60


@dataclass(frozen=True, slots=True)
class LinkagePosition:
    """A position of the linkage with its motion.

    Parameters
    ----------
    part : Fraction
        How much of the way of the inputs is done.
    motion : dict of str to list
        The inputs of the kernels, in 50 digits.
    """

    part: Fraction
    motion: dict[str, list[High]]


def span_of(given: Input) -> Fraction:
    """Way of an input until the last division."""
    if given.to is not None:
        return Fraction(given.to) - Fraction(given.start)
    return 2 * HALF_TURN * Fraction(turns_of(given) or 0)


def places(layout: WorkspaceLayout) -> list[LinkagePosition]:
    """Linkage at every step of its way, up to a dead centre; empty if it never fits."""
    start = [HIGH.number(layout.assembly.coordinates[u].start) for u in layout.unknowns]
    found: list[LinkagePosition] = []
    try:
        here = _placed(layout, Fraction(0), start)
        first_sides = _sides(layout, here)
        while _sides(layout, here) == first_sides:  # else past a dead centre, on another branch
            part = Fraction(len(found), STEPS)
            for order, name in ((1, "x_dot"), (2, "x_ddot")):
                here[name] = _derivatives(layout, here, order)
            found.append(LinkagePosition(part, here))
            if part == 1:
                break
            here = _advanced(layout, here, part, part + Fraction(1, STEPS), HALVINGS)
    except (ArithmeticError, ValueError):
        pass  # the way ends here
    return found


def solution(layout: WorkspaceLayout, found: Sequence[LinkagePosition]) -> dict[str, object]:
    """Solution that the solver of the scene must give, as data.

    Motions of the nodes at some of :data:`STEPS` divisions, rounded to doubles. Where a block has
    more than two unknowns only the first position is sure to be on the branch of the scene.
    """
    kept = found if max(len(block.unknowns) for block in layout.blocks) <= 2 else found[:1]
    nodes = [_exact(layout, place.motion).nodes() for place in kept]
    return {
        "divisions": STEPS,
        "rows": [int(place.part * STEPS) for place in kept],
        **{name: [[float(x) for x in row[name]] for row in nodes] for name in OF_NODES},
    }


def _inputs(layout: WorkspaceLayout, part: Fraction) -> tuple[list[High], list[High], list[High]]:
    given = tuple(layout.assembly.scene.inputs.values())
    return (
        [HIGH.number(Fraction(item.start) + part * span_of(item)) for item in given],
        [HIGH.number(Fraction(item.rate)) for item in given],
        [HIGH.number(Fraction(item.acceleration)) for item in given],
    )


def _exact(layout: WorkspaceLayout, motion: dict[str, list[High]]) -> Exact:
    return Exact(layout, HIGH, motion, lambda _, value: HIGH.number(value))


def _solve(block: dict[str, list[High]], right: Sequence[High]) -> list[High]:
    n = len(right)
    matrix = CONTEXT.matrix([block["D"][n * row : n * row + n] for row in range(n)])
    return list(CONTEXT.lu_solve(matrix, CONTEXT.matrix(list(right))))


def _positions(layout: WorkspaceLayout, motion: dict[str, list[High]]) -> list[High]:
    """Positions x by damped Newton, block by block.

    Raises
    ------
    ArithmeticError
        It does not converge, or a matrix is singular.
    """
    motion = {**motion, "x": list(motion["x"])}
    length = HIGH.number(Fraction(layout.assembly.scene.largest_length))
    first = 0
    for number, block in enumerate(layout.blocks):
        part = slice(first, first + len(block.unknowns))
        for _ in range(MOST_CORRECTIONS):
            here = _exact(layout, motion).block(number, 0)
            correction = _solve(here, here["epsilon"])
            before, size = motion["x"][part], max(map(abs, here["epsilon"]))
            factor = CONTEXT.one
            while True:
                motion["x"][part] = [
                    a - factor * c for a, c in zip(before, correction, strict=True)
                ]
                if max(map(abs, correction)) < DONE * length:
                    break
                there = _exact(layout, motion).block(number, 0)
                if max(map(abs, there["epsilon"])) <= (1 - factor / 4) * size:
                    break
                factor /= 2
                if factor < DONE:
                    raise ArithmeticError("no smaller residual")
            if max(map(abs, correction)) < DONE * length:
                break
        else:
            raise ArithmeticError("no convergence")
        first = part.stop
    return motion["x"]


def _placed(layout: WorkspaceLayout, part: Fraction, near: list[High]) -> dict[str, list[High]]:
    """Motion at a part of the way, its position the one that Newton finds from near."""
    alpha, alpha_dot, alpha_ddot = _inputs(layout, part)
    motion = {"alpha": alpha, "x": near, "alpha_dot": alpha_dot, "alpha_ddot": alpha_ddot}
    return {**motion, "x": _positions(layout, motion)}


def _advanced(
    layout: WorkspaceLayout,
    motion: dict[str, list[High]],
    part: Fraction,
    end: Fraction,
    halvings: int,
) -> dict[str, list[High]]:
    """Motion at ``end``, in steps so short that none reaches over a dead centre.

    Raises
    ------
    ArithmeticError
        It cannot get there.
    """
    predicted = _predicted(layout, motion, end - part)
    try:
        there = _placed(layout, end, predicted)
        if _is_near(layout, motion["x"], predicted, there["x"]):
            return there
    except (ArithmeticError, ValueError):
        pass  # too long a step, or no way on
    if not halvings:
        raise ArithmeticError("a dead centre")
    middle = (part + end) / 2
    half = _advanced(layout, motion, part, middle, halvings - 1)
    return _advanced(layout, half, middle, end, halvings - 1)


def _is_near(
    layout: WorkspaceLayout, x: list[High], predicted: list[High], found: list[High]
) -> bool:
    """Whether the correction is small beside the motion: else another branch may be near."""
    scales = [HIGH.number(layout.assembly.coordinates[u].scale) for u in layout.unknowns]
    pairs = list(zip(scales, x, predicted, found, strict=True))
    moved = max((abs(s * (p - a)) for s, a, p, _ in pairs), default=CONTEXT.zero)
    missed = max((abs(s * (b - p)) for s, _, p, b in pairs), default=CONTEXT.zero)
    length = HIGH.number(Fraction(layout.assembly.scene.largest_length))
    return bool(missed <= max(moved / 4, DONE * length))


def _sides(layout: WorkspaceLayout, motion: dict[str, list[High]]) -> list[bool]:
    """Side of a dead centre on which each block is."""
    exact = _exact(layout, motion)
    sides = []
    for number, block in enumerate(layout.blocks):
        n, flat = len(block.unknowns), exact.block(number, 0)["D"]
        matrix = CONTEXT.matrix([flat[n * row : n * row + n] for row in range(n)])
        sides.append(bool(CONTEXT.det(matrix) > 0))
    return sides


def _derivatives(layout: WorkspaceLayout, motion: dict[str, list[High]], order: int) -> list[High]:
    name = ("x", "x_dot", "x_ddot")[order]
    motion = {**motion, name: [CONTEXT.zero] * len(motion["x"])}
    first = 0
    for number, block in enumerate(layout.blocks):
        exact = _exact(layout, motion)
        (right,) = exact.block(number, order).values()
        part = slice(first, first + len(block.unknowns))
        motion[name][part] = _solve(exact.block(number, 0), right)
        first = part.stop
    return motion[name]


def _predicted(
    layout: WorkspaceLayout, motion: dict[str, list[High]], step: Fraction
) -> list[High]:
    """Coordinates x about a step on, given as a part of the way, (26)."""
    spans = [step * span_of(item) for item in layout.assembly.scene.inputs.values()]
    along = {**motion, "alpha_dot": [HIGH.number(span) for span in spans]}
    along["alpha_ddot"] = [CONTEXT.zero] * len(spans)
    along["x_dot"] = _derivatives(layout, along, 1)
    bend = _derivatives(layout, along, 2)
    return [x + v + a / 2 for x, v, a in zip(motion["x"], along["x_dot"], bend, strict=True)]
