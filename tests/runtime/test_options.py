"""Options that are no numbers are refused by name, not by an error of Python."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import LoadError, SolveError
from kousoku.model.reading.families import chain
from kousoku.runtime import load, verify
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate import run_arguments
from kousoku.runtime.kinematics import moving
from kousoku.runtime.kinematics.rows import request
from kousoku.runtime.linkage import load_linkage
from kousoku.runtime.options import ALL_OPTIONS, options_of

if TYPE_CHECKING:
    from collections.abc import Callable

GENERATED = Path(__file__).parents[2] / "generated"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"end": "3"}, "end '3'; wanted a number"),
        ({"end": 1.0, "samples": 2.5}, "samples 2.5; wanted a whole number"),
        ({"end": 1.0, "tolerance": "1e-9"}, "tolerance '1e-9'; wanted a number"),
        ({"end": 1.0, "largest_step": None}, "largest step None; wanted a number"),
        ({"end": 1.0, "step": True}, "step True; wanted a number"),
        (
            {"end": 1.0, "step": 0.1, "largest_step": 0.01},
            "0.1 with largest_step 0.01; wanted",
        ),
        ({"end": 1.0, "most_steps": 2.5}, "most steps 2.5; wanted a whole number"),
        ({"times": "soon"}, "times 'soon'; wanted a row of numbers"),
        ({"times": [0, 1j]}, r"times \[0, 1j\]; wanted a row of numbers"),
        ({"end": Decimal("1")}, r"end Decimal\('1'\); wanted a number"),
        ({"end": 10**400}, "end 10{59}…; wanted a number in the range of doubles"),
        ({"end": 1.0, "tolerance": 10**5000}, "a number of very many digits; wanted a number in"),
        ({"end": 1.0, "samples": 10**12}, "samples 1000000000000; wanted 2 to 1000000000"),
        ({"end": 1.0, "checks": "no"}, "checks 'no'; wanted True or False"),
        ({"end": 1.0, "progress": 3}, "progress 3; wanted a function of two times"),
        ({"end": 1.0, "parameters": [("k", 3)]}, "wanted a mapping of names to numbers"),
        ({"end": 1.0, "parameters": {3: 3}}, "no parameter 3: its formulas have none"),
        ({"end": 1.0, "tolerence": 3}, "no option 'tolerence'.*; did you mean 'tolerance'"),
        ({"end": 1.0, "sample": 3}, "no option 'sample': there are end, .*did you mean 'samples'"),
    ],
)
def test_what_is_no_number_is_refused_by_name(
    bodies_folder: Callable[..., Path], options: dict[str, Any], message: str
) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    with pytest.raises(SolveError, match=message):
        solver.simulate(**options)


def test_more_rows_than_the_machine_holds_are_refused_before_they_are_made(
    bodies_folder: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A system promises memory that it does not have, and kills whoever uses it."""
    monkeypatch.setattr(run_arguments, "_memory", lambda: 1e9)
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    with pytest.raises(SolveError, match=r"no room for 1000000000 rows of .* machine has 1 GB"):
        solver.simulate(1.0, samples=10**9)
    with pytest.raises(SolveError, match=r"no room for 8000000 rows of .*; ask for fewer times"):
        solver.begin(np.zeros(8_000_000))


@pytest.mark.usefixtures("numpy_solver")
def test_numbers_of_numpy_are_numbers(bodies_folder: Callable[..., Path]) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    count: Any = np.int64(2)
    motion = solver.simulate(np.float64(0.01), samples=count, tolerance=np.float32(1e-3))
    assert len(motion) == 2


def test_the_options_that_are_known_are_those_that_there_are() -> None:
    solver, *options = signature(options_of).parameters
    assert solver == "solver"
    assert tuple(options) == ALL_OPTIONS


def test_a_quotient_is_a_number_but_no_count(
    bodies_folder: Callable[..., Path], backend: str
) -> None:
    target: Any = backend
    solver = load_dynamics(bodies_folder(chain(2), ()), target=target)
    part: Any = Fraction(1, 100)
    motion = solver.simulate(part, samples=2, tolerance=Fraction(1, 1000), largest_step=part)
    assert motion.time[-1] == 0.01
    assert np.isfinite(solver.evaluate(part)["v_dot"]).all()
    run = solver.begin([0.0, part])
    assert isinstance(run.options.tolerance, float)
    counts: tuple[Any, ...] = (Fraction(3), 3.0, "3", None, True, 0, -1)
    for count in counts:
        with pytest.raises(SolveError, match=r"max steps .*; wanted a whole number, 1 or more"):
            run.advance(count)
        with pytest.raises(SolveError, match=r"max rows .*; wanted a whole number, 1 or more"):
            run.advance(3, count)
    assert run.advance(10**30, 10**30) == 0


@pytest.mark.usefixtures("numpy_solver")
def test_other_calls_say_what_they_want(bodies_folder: Callable[..., Path]) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    wrong: Any = 3
    text: Any = "now"
    imaginary: Any = solver.q * 1j
    with pytest.raises(SolveError, match="resumed from 3; wanted what save"):
        solver.resume(wrong)
    with pytest.raises(SolveError, match="progress 3; wanted a function"):
        solver.begin([0.0, 0.01]).finish(wrong)
    with pytest.raises(SolveError, match="3 is no name of a file"):
        solver.simulate(0.01, samples=2).save(wrong)
    with pytest.raises(SolveError, match="not the name of a file: it has a null character"):
        solver.simulate(0.01, samples=2).save("a\0.csv")
    with pytest.raises(LoadError, match="not the name of a folder: it has a null character"):
        load_dynamics("a\0b")
    with pytest.raises(SolveError, match="time 'now'; wanted a number"):
        solver.evaluate(text)
    with pytest.raises(SolveError, match=r"q .*; wanted a row of numbers"):
        solver.evaluate(0.0, q=imaginary)
    with pytest.raises(LoadError, match="3 is no folder; wanted the path of one"):
        load_dynamics(wrong)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"divsions": 3}, "no option 'divsions': there are method, .*; did you mean 'divisions'"),
        ({"divisions": Fraction(3)}, r"divisions Fraction\(3, 1\); wanted a whole number"),
        ({"turns": 1.0}, r"turns 1\.0; wanted a whole number"),
        ({"limit": "small"}, "limit 'small'; wanted a number"),
        ({"divisions": 10**5000}, "no room for a number of very many digits rows"),
    ],
)
def test_a_linkage_refuses_what_is_no_option_or_no_number(
    options: dict[str, Any], message: str
) -> None:
    solver = load_linkage(GENERATED / "lever_crank", target="numpy")
    with pytest.raises(SolveError, match=message):
        solver.solve(**options)


def test_the_options_of_linkages_are_those_that_there_are() -> None:
    assert sorted(signature(request).parameters) == sorted((*moving.OPTIONS, "scene"))


def test_what_is_no_path_is_no_folder() -> None:
    nothing: Any = None
    calls: tuple[Callable[[Any], object], ...] = (load, load_linkage, load_dynamics, verify)
    for call in calls:
        with pytest.raises(LoadError, match=r"^None is no folder; wanted the path of one$"):
            call(nothing)
