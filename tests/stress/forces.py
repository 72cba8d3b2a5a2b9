"""Forces of time and place that act for a moment, at random places and of random widths.

Each has a closed form: the momentum that a pulse gives, the speed that a wall gives back, the work
of a load while its driver bumps. What is wrong without a word is found; what is told is counted.
"""

from __future__ import annotations

import math
import random
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import kousoku as ks
from kousoku.model.errors import MotionError
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.operations.expression import names_of
from tests.stress import hidden_hills
from tests.stress.force_laws import END, SPEED, Form
from tests.stress.force_laws import FORMS as PLAIN_FORMS
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.scenes import STOPS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.lowering.root_functions import RootFunctions
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.operations.expression import Expression
    from tests.stress.force_laws import Wanted

FORMS = PLAIN_FORMS | hidden_hills.FORMS
BATCH = 50
"""Random runs of a case: they share the compiled scene."""
QUICK, OF_NUMPY = 8, 5
"""Runs of a form in the quick size, and in NumPy, which is a hundred times slower, in the full."""
MOST_STEPS = 20_000
EXACT = 1e3
"""Error that is right, in tolerances: ten times what the verdict lets a healthy run lose. Below a
tolerance of 1e-11 rounding of places in units of their widths is no less."""
MISSED = 0.01
"""A force is missed of which this part is missing, told or not."""

Way = dict[str, Any]
CONTROLLED: tuple[Way, ...] = (
    {"method": "dopri5"},
    {"method": "dop853"},
    {"method": "dop853", "tolerance": 1e-12},
    {"method": "dopri5", "tolerance": 1e-6},
)
FIXED: tuple[Way, ...] = ({"method": "dopri5", "step": 0.37}, {"method": "dop853", "step": 0.37})
LOOSE: tuple[Way, ...] = (
    {"method": "dopri5", "tolerance": 1e-4},
    {"method": "dop853", "tolerance": 1e-4},
)
LED: tuple[Way, ...] = ({"method": "kinematics"}, {"method": "kinematics", "tolerance": 1e-6})
ROWS = (2, 11, 101)
OFTEN = ("two", "gauss_wall")
"""Forms that are also made in NumPy in the quick size."""


def cases(size: Size) -> Iterator[str]:
    """Name a case for each batch of a form, and a few in NumPy for the full size."""
    for name, form in FORMS.items():
        numbers = {"c": size.examples(QUICK, form.number), "numpy": OF_NUMPY * size.is_full}
        if name in OFTEN:
            numbers["numpy"] = max(numbers["numpy"], 2)
        for target, number in numbers.items():
            for batch in range(-(-number // BATCH)):
                yield f"{name} {target} {size.seed} {batch} {min(BATCH, number - batch * BATCH)}"


def run(case: str) -> Outcome:
    """Make the runs of a case."""
    name, target, seed, batch, number = case.split()
    chosen: dict[str, Any] = {"target": target}
    form, outcome = FORMS[name], Outcome()
    scene = ks.load(form.text, **chosen)
    for k in range(int(number)):
        draw = random.Random(f"{name} {seed} {batch} {k}")
        parameters, wanted = form.draw(draw)
        ways = (*CONTROLLED, *FIXED * form.may_be_fixed, *LOOSE * form.may_be_loose)
        ways = LED if form.is_led else ways
        way = ways[k % len(ways)]
        Asked(name, form, parameters, way, draw.choice(ROWS)).judge(scene, wanted, outcome)
    return outcome


@dataclass(frozen=True, slots=True)
class Asked:
    """A run: its form, parameters, how it is made, and how many rows it has."""

    name: str
    form: Form
    parameters: dict[str, float]
    way: Way
    rows: int

    def judge(self, scene: ks.Mechanism, wanted: Wanted, outcome: Outcome) -> None:
        """Make the run, and compare it with its closed form."""
        outcome.count(f"{self.form.kind}: runs")
        options = {"most_steps": MOST_STEPS, "parameters": self.parameters, **self.way}
        is_fixed = "step" in self.way
        try:
            result = scene.simulate(END, samples=self.rows, **options)
        except MotionError as error:
            outcome.count(f"{self.form.kind}: stopped and told")
            if not is_fixed:
                tolerance = self.way.get("tolerance", 1e-9)
                is_tight = self.gained > GAINED * tolerance * SPEED
                is_told = any(reason in str(error) for reason in STOPS)
                what = "stops" if is_tight and is_told else "stops for a reason that is not known"
                self.tell(outcome, f"{what}, tolerance {tolerance:g}", str(error))
            return
        worst, where, is_missed = 0.0, "", False
        tolerance = max(self.way.get("tolerance", 1e-9), 1e-11)
        for what, (column, value, allowed) in wanted(result).items():
            off = abs(column - value) / allowed
            if what.startswith("speed"):  # half of what the force does is not there
                half = max(0.5 * abs(value - self.form.free), EXACT * tolerance * SPEED)
                is_missed |= not abs(column - value) <= half
            if not off <= worst:
                worst, where = off, f"{what} {column:.9g}, wanted {value:.9g}"
        is_told = not result.ledger.trust.is_trusted
        if (worst > MISSED and not (is_fixed and is_told)) or (is_missed and not is_told):
            self.tell(outcome, "is missed", where)
        elif is_fixed:
            outcome.count(
                "fixed steps: off by more than a hundredth, and told", int(worst > MISSED)
            )
        elif worst <= EXACT * tolerance:
            outcome.count(f"{self.form.kind}: right, but not trusted", int(is_told))
        elif is_told:
            outcome.count(f"{self.form.kind}: less exact, and told")
        else:
            self.tell(outcome, "is less exact than tolerances, and nothing is told", where)
        if not is_told and not is_fixed:
            outcome.measure(
                f"{self.form.kind}: error (tolerances)", worst / tolerance, self.name + self.how
            )

    @property
    def gained(self) -> float:
        """Speed [m/s] that rounding of time makes at a jump, and that of place in a hill."""
        height = self.parameters.get("height", 0.0)
        if self.name.removesuffix("_wall") in HILLS:
            return height * math.ulp(self.parameters["place"]) / SPEED
        return height * JUMPS.get(self.name, 0.0) * math.ulp(END)

    @property
    def how(self) -> str:
        """Parameters and options in words."""
        numbers = ", ".join(f"{name} = {value!r}" for name, value in self.parameters.items())
        return f" {numbers}; {self.way}, {self.rows} rows"

    def tell(self, outcome: Outcome, what: str, details: str) -> None:
        """Add a finding with the scene and a command."""
        file, options = f"{self.name}.toml", [f"--end {END:g}", f"--samples {self.rows}"]
        options += [f"--set {name}={value!r}" for name, value in self.parameters.items()]
        options += [f"--{name} {value}" for name, value in self.way.items()]
        control = "fixed steps" if "step" in self.way else "steps by tolerance"
        outcome.find(
            f"{self.name} {what}, {control}",
            details + ";" + self.how,
            f"kousoku simulate {file} {' '.join(options)}",
            **{file.replace(".", "__"): self.form.text},
        )


@contextmanager
def blind(*names: str) -> Iterator[None]:
    """Compose solvers that do not know some of the functions at which steps end."""
    scales = (SCALES[name] for name in names if name in SCALES)
    nothing: dict[str, Any] = dict.fromkeys((*names, *scales), ())

    def blinded(system: System) -> RootFunctions:
        found = replace(root_functions_of(system), **nothing)
        told = chain.from_iterable(getattr(found, name) for name in OF_MEASURES)
        read = set(chain.from_iterable(map(names_of, told)))
        used = tuple(one for one in found.measures if {one.name, one.rate} & read)
        return replace(found, measures=used)

    stages = (f"kousoku.codegen.dynamics.{stage}.root_functions_of" for stage in SEEING)
    with ExitStack() as stack:
        for stage in stages:
            stack.enter_context(patch(stage, blinded))
        yield


def nothing_hidden(*_: object) -> Iterator[Expression]:
    """No parts of arguments."""
    return iter(())


#: Stages that ask which functions a run looks at, and which of these depend on measures.
SEEING = ("composition.switching", "emission.context_numbers", "checking.start")
#: What goes along with functions, of each one.
SCALES = {"narrow": "narrow_scales", "features": "feature_scales"}
OF_MEASURES = ("crossings", "narrow", "poles", "infinite", "lengths", "distances")
TIGHT = (
    "when a force jumps is known no better than to the rounding of time, 2e-15 s; what the speed"
    " gains meanwhile is ten times what this tolerance allows and more, and the run says so"
)
#: A run may stop there if that is so many tolerances: of 218 that did it was 15 and more.
GAINED = 10.0
#: Forms that jump in time, or nearly, by how much for each of their height.
JUMPS = {"brake": SPEED, "step_wall": 1.0, "distance_wall": 2.0, "length_wall": 2.0}
#: Of walls that are steep.
HILLS = ("gauss", "sech", "double_exponential", "arctangent", "cap", "trapezoid")
NARROW = (
    "a hill of 5e7 N, 5e-5 m wide and 70 m away, is known to 0.1 N within the rounding of a place:"
    " at this tolerance steps through it are 1e4 and more"
)
QUESTION = Question(
    asks="pulses, walls, bumps, kinks and jumps at random places, of widths down to 1e-6 of the"
    " span: is one missed?",
    cases=cases,
    run=run,
    needs_compiler=True,
    faults=(
        Fault(
            "no step ends where formulas of time switch, or is shorter where they vary",
            partial(blind, "switches", "features"),
            "two c 1 0 30",
        ),
        Fault(
            "steps leap over kinks of the state",
            partial(blind, "crossings", "breaks"),
            "triangle_wall c 1 0 30",
        ),
        Fault(
            "steps leap over narrow hills of the state",
            partial(blind, "narrow"),
            "gauss_wall c 1 0 30",
        ),
        Fault(
            "steps leap over places where distances in formulas are none, and what varies there",
            partial(blind, "distances", "narrow"),
            "distance_wall c 1 1 50",
            "distance_wall is missed",
        ),
        Fault(
            "steps leap over places where ends of springs meet",
            partial(blind, "lengths"),
            "length_wall c 1 0 50",
            "length_wall is missed",
        ),
        Fault(
            "narrow hills that stand beside others in arguments of functions are not looked for",
            partial(patch, "kousoku.model.expressions.switching._hidden_terms", nothing_hidden),
            "hidden_of_place c 1 0 50",
            "hidden_of_place is less exact",
        ),
    ),
    known={f"{name} stops, tolerance 1e-12": TIGHT for name in JUMPS}
    | {f"{name}_wall stops, tolerance 1e-12": NARROW for name in HILLS}
    | {"step_wall stops, tolerance 1e-09": TIGHT},
)
