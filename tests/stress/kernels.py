"""Kernels of kinds at random points, in states of machines, at the edges of doubles, and climbing.

The values come from the scalar formulas of the derivation, the units are those of ``verify``. A
climb changes exponents, signs, zeros and directions, and keeps what makes the error larger.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from unittest.mock import patch

import numpy as np

from kousoku.codegen.emit import emit
from kousoku.codegen.freeze import freeze
from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.generate import package_of, write_tree
from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.points import (
    EvaluationPoint,
    finite_points,
    infinite_points,
    is_euler_parameters,
    ordinary,
)
from kousoku.codegen.reference import WORKING_DIGITS, values_at
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.codegen.states import coincident_points, motion_points
from kousoku.model.errors import NoCompilerError
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.runtime import load
from kousoku.runtime.evaluate import different_bits, evaluate, ways
from kousoku.runtime.reference import reference_of
from kousoku.runtime.report import LIMIT
from kousoku.runtime.verify import rows_of
from kousoku.symbolic import derive, length
from kousoku.symbolic.joints import half_square_curvature
from kousoku.symbolic.kinds import KINDS
from kousoku.symbolic.matrices import Divisor, add, mul, neg, transpose
from kousoku.symbolic.spring import RELATIVE, D, L
from tests.stress import wide
from tests.stress.compiled import contracting
from tests.stress.kit import Fault, Outcome, Question, Size

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.model.operations import kernel as frozen
    from kousoku.runtime.kernel import Kernel
    from kousoku.symbolic.derivation import Function
    from kousoku.symbolic.sympy_types import SymbolicMatrix

#: Points of a climb that go on, and steps that each tries at a time.
CLIMBERS, TRIES = 12, 16
#: Ordinary magnitudes end here, as those of reference points where kernels were far off.
LARGEST_ORDINARY_NUMBER = 64.0
UNIT_ROUNDOFF = 2.0**-53
#: Where a value vanishes with its derivatives, roundings of roundings are left: of what terms of
#: both signs add up to, a climb asks for no more than this part, as ``verify`` of solvers does.
FLOOR = 2.0**-40 * UNIT_ROUNDOFF
#: Scales from 1e-150 to 1e150.
LARGEST_EXPONENT = 498
CLIMBING = "climbing over ordinary magnitudes"
#: Outputs whose forms lose a digit or two at points that a climb finds, and none in states that
#: machines are in.
BESIDE = {
    **dict.fromkeys(("n1", "n2"), ("gamma",)),
    **dict.fromkeys(("p2_x", "p2_y", "p2_z"), ("gamma", "reaction", "reaction_q")),
    "length": ("gamma", "reaction", "reaction_q"),
    "rotation": ("dr_P",),
    "spring_damper": ("l_dot", "force"),
}
SCALES = "scales of 1e-150 to 1e150"
#: Where manifests say what is lost: elsewhere it would hide what is wrong.
FAR = (CLIMBING, SCALES)
#: Other outputs: the sort of points, how many digits they lose there, and why.
LOST = {
    "gamma of angle": (CLIMBING, 2, "a_i and b_i are nearly opposite, as no machine has them."),
    "reaction_q of angle": (
        CLIMBING,
        2,
        "What is left of terms that cancel is off by little more than a unit of the largest"
        " element.",
    ),
    "h of mass_points": (
        CLIMBING,
        1,
        "Torques of forces along axes cancel; it is off by three units of the largest element.",
    ),
    "D_dot_x_dot of link": (
        SCALES,
        7,
        "2 β̇ l̇ l0 is below the normal doubles before it is divided by l: a link of 1e-110 m.",
    ),
    "reaction_q of length": (
        SCALES,
        6,
        "The product of both arms, over l, is below the normal doubles before λ multiplies it: arms"
        " of 1e-130 m, 1e50 m apart.",
    ),
}
KNOWN = {
    f"{output} of {kind} is up to {most} units off: {CLIMBING}": "A form that keeps all digits"
    " there loses them at points that machines pass through. One that is further off is found."
    for kind, outputs in BESIDE.items()
    for output in outputs
    for most in (10, 100, 1000)
} | {
    f"{output} is up to {10**lost:g} units off: {sort}": f"{why} One that is further off is found."
    for output, (sort, digits, why) in LOST.items()
    for lost in range(1, digits + 1)
}
#: Kinds whose reaction_q is told by its blocks where each element of the inputs has a scale of its
#: own: an element that is small beside others of its block is what is left of them.
BY_BLOCKS = ("angle", "length")
SCALED_ELEMENTS = "badly scaled elements"
#: Kinds that are asked also when there is little time: with roots and poles.
SINGULAR = ("length", "spring_damper", "angle", "link")
#: Sorts of points, and how many of them or how many rounds of climbing, quick and full.
STATES = "states that machines are in"
SORTS = (
    {"sorts": 1, "states": 6, "scales": 10},
    {"sorts": 1, "states": 500, "scales": 500, "climb": 60},
)


@dataclass(frozen=True, slots=True)
class Subject:
    """A kernel, and the formulas that it must give.

    Parameters
    ----------
    function : Function
        The derivation, all outputs.
    components : model.operations.kernel.Kernel
        Its formulas.
    graph : model.operations.kernel.Kernel
        The frozen kernel; it says which elements are identically zero.
    kernels : tuple of (str, Kernel)
        By target: compiled, where a compiler is in reach, and of NumPy.
    places : dict of str to list of int
        Where the elements of each input stand in a point, a row of numbers.
    """

    function: Function
    components: frozen.Kernel
    graph: frozen.Kernel
    kernels: tuple[tuple[Literal["c", "numpy"], Kernel], ...]
    places: dict[str, list[int]]

    def row(self, inputs: Mapping[str, Sequence[float]]) -> list[float]:
        """Point as a row of numbers."""
        return [x for quantity in self.function.inputs for x in inputs[quantity.name]]

    def inputs(self, row: Any) -> dict[str, tuple[float, ...]]:
        """Inputs that :meth:`row` made a row of."""
        return {name: tuple(row[places].tolist()) for name, places in self.places.items()}

    def values(self, rows: Any) -> Any:
        """Values of the first kernel at points: (n, elements)."""
        _, kernel = self.kernels[0]
        quantities = kernel.manifest.inputs
        inputs = (rows[:, self.places[q.name]].reshape((-1, *q.shape)) for q in quantities)
        with np.errstate(all="ignore"):
            found = kernel(*inputs)
        return np.concatenate([np.reshape(x, (len(rows), -1)) for x in found], axis=1)

    def errors(self, rows: Any, *, has_floor: bool = False) -> dict[str, Any]:
        """Units that the worst element of each output is off at points, nearly.

        Where a value, or a number on the way to it, is none that doubles have, it is NaN.
        """
        got = self.values(rows)
        errors = np.zeros(got.shape)
        with np.errstate(all="ignore"):
            values, is_double = wide.run(self.components, rows)
            for k, (value, size, whole) in enumerate(values):
                floor = FLOOR * whole if has_floor else SMALLEST_SUBNORMAL
                unit = np.maximum(UNIT_ROUNDOFF * (abs(value.high) + size), floor)
                found = abs((got[:, k] - value.high) - value.low)
                errors[:, k] = np.where(found == 0, 0, found / unit)
        errors[~(np.isfinite(errors) & is_double[:, None])] = math.nan
        outputs = self.components.outputs
        ends = np.cumsum([0] + [output.size for output in outputs])
        return {
            output.name: errors[:, start:end].max(axis=1)
            for output, start, end in zip(outputs, ends, ends[1:], strict=False)
        }


def folder_of(package: str) -> Path:
    """Folder of the kernels that are shipped."""
    return Path(str(resources.files("kousoku.generated").joinpath("kinds", package)))


def subjects(kind: str) -> tuple[Subject, ...]:
    """Kernels of a kind, or of a choice of its rows."""
    package = package_of(kind)
    choice = kind.removeprefix(package)
    libraries = [load(folder_of(package), target="numpy")]
    with contextlib.suppress(NoCompilerError):
        libraries.insert(0, load(folder_of(package), target="c"))
    graphs = {kernel.name: kernel for kernel in load_frozen(package).kernels}
    found = []
    for function in derive(kind).functions:
        name, components = function.name + choice, freeze_components(function)
        ends = np.cumsum([quantity.size for quantity in function.inputs]).tolist()
        places = {
            quantity.name: list(range(end - quantity.size, end))
            for quantity, end in zip(function.inputs, ends, strict=True)
        }
        kernels = tuple((library.target, library[name]) for library in libraries)
        found.append(Subject(function, components, graphs[name], kernels, places))
    return tuple(found)


def check(
    outcome: Outcome, kind: str, subject: Subject, points: Sequence[EvaluationPoint], sort: str
) -> Any:
    """Measure a kernel at points as ``verify`` does: every way of calling, every output.

    Returns
    -------
    dict of str to float
        For each output the worst error, in units.
    """
    with CONTEXT.workdps(WORKING_DIGITS):
        known = [values_at(subject.graph, subject.function, subject.components, x) for x in points]
    found = [raised(subject, x) if sort == CLIMBING else x for x in known if x is not None]
    if kind in BY_BLOCKS:
        found = [by_blocks(subject, x) for x in found]
    outcome.count("points", len(found))
    worst: dict[str, float] = {}
    if not found:
        return worst
    every = []
    for target, kernel in subject.kernels:
        manifest = replace(kernel.manifest, known=())
        reference = reference_of(manifest, found)
        for way in ways(target):
            every += list(evaluate(kernel, reference, way))
    for row in rows_of(manifest, reference, every):
        worst[row.output] = max(worst.get(row.output, 0.0), row.worst)
        figure = f"{row.output} of {kind}"
        known_units = dict(subject.kernels[0][1].manifest.known) if sort in FAR else {}
        outcome.measure(f"{sort} (units)", row.worst, f"{figure}, {row.label}")
        outcome.tabulate("worst (units)", f"{kind}, {row.output}", sort, row.worst, str(row))
        if row.worst > known_units.get(row.output, LIMIT):
            outcome.find(f"{figure} is {rounded_up(row.worst)} off: {sort}", str(row))
    if manifest.is_exact and all(x <= LIMIT for x in worst.values()):
        for message in different_bits(manifest, reference, every):
            outcome.find(f"{kind}: bits differ by the way of calling", message)
    return worst


def raised(subject: Subject, point: dict[str, Any]) -> dict[str, Any]:
    """Point with units that are at least the floor of a climb."""
    values, _ = wide.run(subject.components, np.array([subject.row(point["inputs"])]))
    floors = iter([float(FLOOR * whole[0]) for *_, whole in values])
    outputs = {}
    for k, output in enumerate(subject.components.outputs):
        own = [next(floors) for _ in range(output.size)]
        chosen = [own[element] for element in subject.graph.nonzero(k)]
        columns = point["outputs"][output.name]
        unit = [max(x, floor) for x, floor in zip(columns["unit"], chosen, strict=True)]
        outputs[output.name] = columns | {"unit": unit}
    return point | {"outputs": outputs}


def by_blocks(subject: Subject, point: dict[str, Any]) -> dict[str, Any]:
    """Point with units of reaction_q by its (3, 3) blocks, where elements are badly scaled."""
    names = [output.name for output in subject.components.outputs]
    if point["label"] != SCALED_ELEMENTS or "reaction_q" not in names:
        return point
    place = names.index("reaction_q")
    columns, width = point["outputs"]["reaction_q"], subject.components.outputs[place].shape[1]
    blocks = [(x // width // 3, x % width // 3) for x in subject.graph.nonzero(place)]
    largest: dict[tuple[int, int], float] = {}
    for block, unit in zip(blocks, columns["unit"], strict=True):
        largest[block] = max(largest.get(block, 0.0), unit)
    units = [largest[block] for block in blocks]
    return point | {"outputs": point["outputs"] | {"reaction_q": columns | {"unit": units}}}


def rounded_up(units: float) -> str:
    """Lost units, rounded up, as the title of a finding has them."""
    if not math.isfinite(units):
        return "beyond all units"
    return f"up to {10 ** math.ceil(math.log10(units)):g} units"


def of_all_sorts(outcome: Outcome, kind: str, name: str, turn: int) -> None:
    """Ask at points like those of ``verify``, with other numbers: also not finite, and poles."""
    for subject in subjects(kind):
        inputs, stream = subject.function.inputs, Sha256Random(f"{name} {subject.function.name}")
        points = finite_points(subject.components, stream, turn)
        points += infinite_points(subject.components, stream)
        points += motion_points(inputs, stream, turn)
        if all(output.at_pole is not None for output in subject.function.outputs):
            points += coincident_points(inputs, stream)
        check(outcome, kind, subject, points, "points of all sorts")


def at_all_scales(outcome: Outcome, kind: str, name: str, number: int) -> None:
    """Ask where each array has a scale of its own from 1e-150 to 1e150."""
    rng = np.random.default_rng([*name.encode()])
    for subject in subjects(kind):
        rows = starts(subject, f"{name} {subject.function.name}", number)
        for quantity in subject.function.inputs:
            if not is_euler_parameters(quantity):
                exponents = rng.integers(-LARGEST_EXPONENT, LARGEST_EXPONENT + 1, (number, 1))
                places = subject.places[quantity.name]
                rows[:, places] = np.ldexp(rows[:, places], exponents)
        check_worst(outcome, kind, subject, rows, SCALES)


def in_states(outcome: Outcome, kind: str, name: str, number: int) -> None:
    """Ask in random states that machines are in."""
    for subject in subjects(kind):
        rows = starts(subject, f"{name} {subject.function.name}", number)
        check_worst(outcome, kind, subject, rows, STATES)


def check_worst(
    outcome: Outcome, kind: str, subject: Subject, rows: Any, sort: str
) -> dict[str, float]:
    """Measure the worst of many points, for each output one.

    Where a product overflows, the result is not finite and says so by itself.
    """
    outcome.count("points looked at", len(rows))
    is_finite = np.isfinite(subject.values(rows)).all(axis=1)
    outcome.count(
        "points at which products overflow, and the result is not finite", int(sum(~is_finite))
    )
    if sort == STATES and not is_finite.all():
        place = str(subject.inputs(rows[int(np.argmin(is_finite))]))
        outcome.find(f"{kind}: not finite where machines are", place)
    rows = rows[is_finite]
    every = [x for x in subject.errors(rows).values() if not np.isnan(x).all()]
    worst = {int(np.nanargmax(errors)) for errors in every}
    points = [EvaluationPoint(sort, subject.inputs(rows[k])) for k in sorted(worst)]
    return dict(check(outcome, kind, subject, points, sort))


def starts(subject: Subject, name: str, number: int) -> Any:
    """Ordinary points, and states that machines are in, as rows."""
    inputs, rows = subject.function.inputs, list[list[float]]()
    stream = Sha256Random(name)
    for turn in range(number):
        states = motion_points(inputs, stream, turn)[: number - len(rows)]
        rows += [subject.row(state.inputs) for state in states]
        if len(rows) < number:
            rows.append(subject.row(ordinary(inputs, stream)))
    return np.array(rows[:number])


def climb(outcome: Outcome, kind: str, name: str, rounds: int) -> None:
    """Climb to the worst point of each output that ordinary magnitudes have."""
    for subject in subjects(kind):
        for output in (quantity.name for quantity in subject.components.outputs):
            rng = np.random.default_rng([*f"{name} {output}".encode()])
            rows = starts(subject, f"{name} {output}", CLIMBERS * TRIES)
            errors = np.nan_to_num(subject.errors(rows, has_floor=True)[output])
            best = np.argsort(-errors)[:CLIMBERS]
            rows, errors = rows[best], errors[best]
            for _ in range(rounds):
                tried = changed(subject, rng, np.repeat(rows, TRIES, axis=0))
                found = subject.errors(tried, has_floor=True)[output]
                found = np.nan_to_num(found).reshape((CLIMBERS, TRIES))
                chosen = np.argmax(found, axis=1)
                is_worse = found.max(axis=1) > errors
                steps = tried.reshape((CLIMBERS, TRIES, -1))[range(CLIMBERS), chosen]
                rows = np.where(is_worse[:, None], steps, rows)
                errors = np.maximum(errors, found.max(axis=1))
            outcome.count("points looked at", CLIMBERS * TRIES * (rounds + 1))
            point = EvaluationPoint("climbing", subject.inputs(rows[int(np.argmax(errors))]))
            check(outcome, kind, subject, [point], CLIMBING)


def changed(subject: Subject, rng: np.random.Generator, rows: Any) -> Any:
    """Points beside others: another exponent, sign, zero, direction, or a shared array."""
    rows, names = rows.copy(), list(subject.places)
    for row, step in zip(rows, rng.integers(6, size=len(rows)), strict=True):
        places = subject.places[names[rng.integers(len(names))]]
        others = subject.places[names[rng.integers(len(names))]]
        place = rng.integers(len(row))
        by = 2.0 ** -rng.integers(45)
        if step == 0:
            row[place] *= 2.0 ** rng.normal(scale=3)
        elif step == 1:
            row[place] = (0, 1, -1, -row[place])[rng.integers(4)]
        elif step == 2:
            row[places] += by * abs(row[places]).max() * rng.normal(size=len(places))
        elif step == 3 and len(places) == len(others):
            row[places] = row[others]
        elif step == 4:
            row[places] = rows[rng.integers(len(rows)), places]
        else:
            row[place] *= 1 + by * rng.normal()
    for quantity in subject.function.inputs:
        places = subject.places[quantity.name]
        chosen = rows[:, places]
        if is_euler_parameters(quantity):
            chosen[~chosen.any(axis=1), 0] = 1
            rows[:, places] = chosen / np.linalg.norm(chosen, axis=1, keepdims=True)
        else:
            rows[:, places] = np.clip(chosen, -LARGEST_ORDINARY_NUMBER, LARGEST_ORDINARY_NUMBER)
    return rows


def cases(size: Size) -> Iterator[str]:
    """Name a case for each kind, sort of points and batch."""
    every = [name for kind in KINDS.values() for name in kind.packages]
    for batch in range(size.fixed(1, 2)):
        for kind in every if size.is_full else SINGULAR:
            for sort, number in SORTS[size.is_full].items():
                yield f"{sort} {kind} {number} {size.seed} {batch}"


def run(case: str) -> Outcome:
    """Ask a kind at points of one sort."""
    outcome = Outcome()
    sort, kind, number, _, batch = case.split()
    if sort == "sorts":
        of_all_sorts(outcome, kind, case, int(batch))
    else:
        {"scales": at_all_scales, "states": in_states, "climb": climb}[sort](
            outcome, kind, case, int(number)
        )
    return outcome


@contextlib.contextmanager
def cancelling() -> Iterator[None]:
    """Emit γ of ``length`` as the difference of what d·ḋ and its rate hold of what is along d."""

    def plain(by_points: SymbolicMatrix) -> SymbolicMatrix:
        whole = add(mul(transpose(D), RELATIVE["v"]), by_points)
        along = mul(1 / Divisor(L), whole)
        rest = add(mul(along, along), neg(half_square_curvature()))
        return mul(1 / Divisor(L), rest)

    with patch.object(length, "_gamma", plain):
        functions = length.derive("length").functions
    package = load_frozen("length")
    kernels = [freeze(x) for x in functions]
    with tempfile.TemporaryDirectory() as folder:
        write_tree(Path(folder), emit(replace(package, kernels=tuple(kernels)), {}))
        with patch(f"{__name__}.folder_of", lambda _: Path(folder)):
            yield


QUESTION = Question(
    asks="kernels at and near each singular condition, at all scales, and in states that machines"
    " are in: by how many units is the worst output off?",
    in_full="that of all variants, and where a climb to the worst point leads",
    cases=cases,
    run=run,
    faults=(
        Fault("γ of a length in a form whose terms cancel", cancelling, "states length 200 1 0"),
        Fault("a compiler that rounds products and sums once", contracting, "states n1 20 1 0"),
    ),
    known=KNOWN,
)
