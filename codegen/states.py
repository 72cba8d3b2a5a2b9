"""Points of states of machines: bodies that turn together, points that move along lines, axes.

There the terms of a formula are large and their sum is small, so that code in which they cancel
loses digits, though no number is unusual.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kousoku.codegen.points import EvaluationPoint, ordinary
from kousoku.model.numbers.digits import CONTEXT
from kousoku.symbolic.matrices import quadratic_form

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.sha256_random import Sha256Random
    from kousoku.model.files.quantity import Quantity

    Numbers = dict[str, tuple[float, ...]]
    Triple = Sequence[float]

TURNING = {"p_i", "p_j", "omega_i_b", "omega_j_b"}
LINE = {"r_i", "p_i", "s_i_b", "r_j", "p_j", "s_j_b"}
MOVING_LINE = LINE | TURNING | {"v_i", "v_j"}
#: Ratios of the common to the relative speed of turning, and of the speed of points along their
#: line to that across it.
FASTER = 1024.0, 128.0


def motion_points(
    inputs: Sequence[Quantity], stream: Sha256Random, pick: int
) -> list[EvaluationPoint]:
    """States that the inputs allow: another orientation or axis at each pick.

    Parameters
    ----------
    inputs : sequence of Quantity
        The inputs of a function of two bodies; other functions have no states.
    stream : Sha256Random
        Source of the digits.
    pick : int
        Index of the axis that a line is near; bodies that turn together have one orientation at
        every other pick.
    """
    names = {quantity.name for quantity in inputs}
    points = []
    if names >= TURNING:
        points.append(
            EvaluationPoint(
                "bodies turn together", _turning_together(ordinary(inputs, stream), pick)
            )
        )
        points.append(
            EvaluationPoint("fast common turning", _fast_turning(ordinary(inputs, stream)))
        )
    if names >= MOVING_LINE:
        points.append(
            EvaluationPoint("points move along their line", _along_line(ordinary(inputs, stream)))
        )
    if names >= LINE:
        points.append(
            EvaluationPoint("line near an axis", _near_axis(ordinary(inputs, stream), pick))
        )
    return points


def coincident_points(inputs: Sequence[Quantity], stream: Sha256Random) -> list[EvaluationPoint]:
    """Points that coincide, and stay so: of one body in two places, and of two bodies."""
    if not {quantity.name for quantity in inputs} >= LINE:
        return []
    numbers = ordinary(inputs, stream)
    one_place = {
        name: numbers[_of_i(name)] if _of_i(name) in numbers else numbers[name] for name in numbers
    }
    # With whole numbers and half a turn about x nothing is rounded.
    integers = {name: tuple(float(round(4 * x)) for x in xs) for name, xs in numbers.items()}
    integers |= {"p_i": (1.0, 0.0, 0.0, 0.0), "p_j": (0.0, 1.0, 0.0, 0.0)}
    integers["r_j"] = _sum(integers["r_i"], _arm(integers, "i"), _times(-1.0, _arm(integers, "j")))
    if integers.keys() >= MOVING_LINE:
        rates = _arm_rate(integers, "i"), _times(-1.0, _arm_rate(integers, "j"))
        integers["v_j"] = _sum(integers["v_i"], *rates)
    return [
        EvaluationPoint("bodies in one place", one_place),
        EvaluationPoint("points coincide", integers),
    ]


def _of_i(name: str) -> str:
    return "_".join("i" if part == "j" else part for part in name.split("_"))


def _turning_together(numbers: Numbers, pick: int) -> Numbers:
    if pick % 2:
        return numbers | {"p_j": numbers["p_i"], "omega_j_b": numbers["omega_i_b"]}
    return numbers | {"omega_j_b": _seen_from_j(numbers, numbers["omega_i_b"])}


def _fast_turning(numbers: Numbers) -> Numbers:
    common = _times(FASTER[0], numbers["omega_i_b"])
    omega_j = _sum(_seen_from_j(numbers, common), numbers["omega_j_b"])
    return numbers | {"omega_i_b": common, "omega_j_b": omega_j}


def _along_line(numbers: Numbers) -> Numbers:
    line = _sum(
        numbers["r_j"], _arm(numbers, "j"), _times(-1.0, _sum(numbers["r_i"], _arm(numbers, "i")))
    )
    rate = _sum(
        numbers["v_i"],
        _arm_rate(numbers, "i"),
        _times(-1.0, _arm_rate(numbers, "j")),
        _times(FASTER[1], line),
        numbers["v_j"],  # the speed across is of order one
    )
    return numbers | {"v_j": rate}


def _near_axis(numbers: Numbers, pick: int) -> Numbers:
    small = [math.ldexp(x, -20 * k) for k, x in enumerate(numbers["r_j"])]
    line = (*small[pick % 3 :], *small[: pick % 3])
    r_j = _sum(numbers["r_i"], _arm(numbers, "i"), _times(-1.0, _arm(numbers, "j")), line)
    return numbers | {"r_j": r_j}


def _seen_from_j(numbers: Mapping[str, Triple], vector: Triple) -> tuple[float, ...]:
    """Vector of the frame of i in the frame of j, for p of norm one."""
    return _product(_transposed(numbers["p_j"]), _product(_orientation(numbers["p_i"]), vector))


def _arm(numbers: Mapping[str, Triple], body: str) -> tuple[float, ...]:
    """Arm A s′."""
    return _product(_orientation(numbers[f"p_{body}"]), numbers[f"s_{body}_b"])


def _arm_rate(numbers: Mapping[str, Triple], body: str) -> tuple[float, ...]:
    """A (ω′ × s′)."""
    (a, b, c), (x, y, z) = numbers[f"omega_{body}_b"], numbers[f"s_{body}_b"]
    rate = (b * z - c * y, c * x - a * z, a * y - b * x)
    return _product(_orientation(numbers[f"p_{body}"]), rate)


def _orientation(p: Sequence[float]) -> list[list[float]]:
    return quadratic_form([CONTEXT.mpf(e) for e in p])


def _transposed(p: Sequence[float]) -> list[list[float]]:
    return [list(column) for column in zip(*_orientation(p), strict=True)]


def _product(matrix: Sequence[Sequence[float]], vector: Triple) -> tuple[float, ...]:
    return tuple(float(sum(a * x for a, x in zip(row, vector, strict=True))) for row in matrix)


def _sum(*vectors: Triple) -> tuple[float, ...]:
    return tuple(math.fsum(elements) for elements in zip(*vectors, strict=True))


def _times(factor: float, vector: Triple) -> tuple[float, ...]:
    return tuple(factor * x for x in vector)
