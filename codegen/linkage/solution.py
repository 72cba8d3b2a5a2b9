"""Motion of a linkage in 50 digits, at the positions of its references."""

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

#: Count of steps over the range of the inputs.
STEPS = 10
#: Halvings of a step at most: a step that needs more meets a dead centre.
HALVINGS = 8
#: Size of the last correction, relative to the largest length.
DONE = CONTEXT.mpf(10) ** -40
MOST_CORRECTIONS = 60


@dataclass(frozen=True, slots=True)
class LinkagePosition:
    """Position of the linkage with its motion.

    Parameters
    ----------
    part : Fraction
        Fraction of the range of the inputs.
    motion : dict of str to list
        The inputs of the kernels, in 50 digits.
    """

    part: Fraction
    motion: dict[str, list[High]]


def span_of(item: Input) -> Fraction:
    """Range of an input until the last division."""
    if item.to is not None:
        return Fraction(item.to) - Fraction(item.start)
    return 2 * HALF_TURN * Fraction(turns_of(item) or 0)


def positions_of(layout: WorkspaceLayout) -> list[LinkagePosition]:
    """Positions at the steps of the inputs, up to a dead centre; empty if it never fits."""
    start = [HIGH.number(layout.assembly.coordinates[u].start) for u in layout.unknowns]
    positions: list[LinkagePosition] = []
    try:
        motion = _placed(layout, Fraction(0), start)
        first_sides = _sides(layout, motion)
        while _sides(layout, motion) == first_sides:  # else past a dead centre, on another branch
            fraction = Fraction(len(positions), STEPS)
            for order, name in ((1, "x_dot"), (2, "x_ddot")):
                motion[name] = _derivatives(layout, motion, order)
            positions.append(LinkagePosition(fraction, motion))
            if fraction == 1:
                break
            motion = _advanced(layout, motion, fraction, fraction + Fraction(1, STEPS), HALVINGS)
    except (ArithmeticError, ValueError):
        pass  # the motion ends here
    return positions


def solution(layout: WorkspaceLayout, positions: Sequence[LinkagePosition]) -> dict[str, object]:
    """Solution that the solver of the scene must compute, as data.

    Motions of the nodes at some of :data:`STEPS` divisions, rounded to doubles. Where a block has
    more than two unknowns only the first position is sure to be on the branch of the scene.
    """
    largest = max(len(block.unknowns) for block in layout.blocks)
    compared = positions if largest <= 2 else positions[:1]
    nodes = [_exact(layout, position.motion).nodes() for position in compared]
    return {
        "divisions": STEPS,
        "rows": [int(position.part * STEPS) for position in compared],
        **{name: [[float(x) for x in row[name]] for row in nodes] for name in OF_NODES},
    }


def _inputs(
    layout: WorkspaceLayout, fraction: Fraction
) -> tuple[list[High], list[High], list[High]]:
    inputs = tuple(layout.assembly.scene.inputs.values())
    return (
        [HIGH.number(Fraction(item.start) + fraction * span_of(item)) for item in inputs],
        [HIGH.number(Fraction(item.rate)) for item in inputs],
        [HIGH.number(Fraction(item.acceleration)) for item in inputs],
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
        unknowns = slice(first, first + len(block.unknowns))
        for _ in range(MOST_CORRECTIONS):
            equations = _exact(layout, motion).block(number, 0)
            correction = _solve(equations, equations["epsilon"])
            before, size = motion["x"][unknowns], max(map(abs, equations["epsilon"]))
            factor = CONTEXT.one
            while True:
                motion["x"][unknowns] = [
                    a - factor * c for a, c in zip(before, correction, strict=True)
                ]
                if max(map(abs, correction)) < DONE * length:
                    break
                trial = _exact(layout, motion).block(number, 0)
                if max(map(abs, trial["epsilon"])) <= (1 - factor / 4) * size:
                    break
                factor /= 2
                if factor < DONE:
                    raise ArithmeticError("no smaller residual")
            if max(map(abs, correction)) < DONE * length:
                break
        else:
            raise ArithmeticError("no convergence")
        first = unknowns.stop
    return motion["x"]


def _placed(layout: WorkspaceLayout, fraction: Fraction, near: list[High]) -> dict[str, list[High]]:
    """Motion at a fraction of the range, its position from Newton iterations that start near."""
    alpha, alpha_dot, alpha_ddot = _inputs(layout, fraction)
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
        reached = _placed(layout, end, predicted)
        if _is_near(layout, motion["x"], predicted, reached["x"]):
            return reached
    except (ArithmeticError, ValueError):
        pass  # too long a step, or no motion beyond
    if not halvings:
        raise ArithmeticError("a dead centre")
    middle = (part + end) / 2
    half = _advanced(layout, motion, part, middle, halvings - 1)
    return _advanced(layout, half, middle, end, halvings - 1)


def _is_near(
    layout: WorkspaceLayout, x: list[High], predicted: list[High], corrected: list[High]
) -> bool:
    """Whether the correction is small beside the step: else another branch may be near."""
    scales = [HIGH.number(layout.assembly.coordinates[u].scale) for u in layout.unknowns]
    pairs = list(zip(scales, x, predicted, corrected, strict=True))
    moved = max((abs(s * (p - a)) for s, a, p, _ in pairs), default=CONTEXT.zero)
    missed = max((abs(s * (b - p)) for s, _, p, b in pairs), default=CONTEXT.zero)
    length = HIGH.number(Fraction(layout.assembly.scene.largest_length))
    return bool(missed <= max(moved / 4, DONE * length))


def _sides(layout: WorkspaceLayout, motion: dict[str, list[High]]) -> list[bool]:
    """Side of a dead centre for each block: the sign of det D."""
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
        unknowns = slice(first, first + len(block.unknowns))
        motion[name][unknowns] = _solve(exact.block(number, 0), right)
        first = unknowns.stop
    return motion[name]


def _predicted(
    layout: WorkspaceLayout, motion: dict[str, list[High]], step: Fraction
) -> list[High]:
    """Coordinates x predicted for the next step, a fraction of the range, (26)."""
    spans = [step * span_of(item) for item in layout.assembly.scene.inputs.values()]
    per_step = {**motion, "alpha_dot": [HIGH.number(span) for span in spans]}
    per_step["alpha_ddot"] = [CONTEXT.zero] * len(spans)
    per_step["x_dot"] = _derivatives(layout, per_step, 1)
    x_ddot = _derivatives(layout, per_step, 2)
    return [x + v + a / 2 for x, v, a in zip(motion["x"], per_step["x_dot"], x_ddot, strict=True)]
