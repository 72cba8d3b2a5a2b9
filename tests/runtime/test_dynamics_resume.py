"""A run can be stopped anywhere, copied, and resumed: its rows keep their bits."""

from __future__ import annotations

import pickle
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import SolveError
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate.settings import Status
from kousoku.runtime.run import Interrupted

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run import Run
    from kousoku.runtime.saved import SavedRun

    Load = Callable[..., DynamicsSolver]

ALL = ("accelerations", "reactions", "energies")
TIMES = np.sort(np.append(np.linspace(0.0, 0.6, 25), [0.0, 0.31, 0.3100001]))
SPRING = """
name = "spring"
unit = "m"
parameters = { k = 3 }
[bodies.bob]
position = [2, 0, 0]
mass = 1
point = true
[forces.pull]
type = "force"
body = "bob"
force = ["-k*t", 0, 0]
"""
#: Numbers of a state that no run leaves in it.
DAMAGE = (
    *(("key", 1.0), ("next_row", np.nan), ("next_row", -1.0), ("next_row", 0.5)),
    *(("next_row", 1e300), ("time", np.nan), ("time_before", 7.0), ("step_size", np.inf)),
    *(("y", np.nan), ("low", np.inf), ("f", np.nan)),
)


@pytest.fixture
def load(load: Load) -> Load:
    return lambda scene: load(scene, *ALL)


def table(run: Run) -> Any:
    """Columns and the state at the end, without the time that it took."""
    columns = run.motion().columns()
    return np.stack(list(columns.values())), run.state


def whole(solver: DynamicsSolver, **options: Any) -> Any:
    run = solver.begin(TIMES, **options)
    run.finish()
    return table(run)


def poison(run: Run) -> None:
    """Fill the memory for work with NaN: nothing in it may last from call to call."""
    run._memory.work[:] = np.nan


@pytest.mark.parametrize("scene", [chain(2), n_four_bar(1)], ids=["tasks", "straight"])
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
@pytest.mark.parametrize(("steps", "rows"), [(10**6, 1), (3, 10**6), (1, 2)])
def test_run_in_pieces_gives_the_bits_of_a_run_in_one(
    load: Load, scene: Any, method: str, steps: int, rows: int
) -> None:
    solver = load(scene)
    wanted, end = whole(solver, method=method, tolerance=1e-8)
    run = solver.begin(TIMES, method=method, tolerance=1e-8)
    calls: list[int] = []
    while not calls or calls[-1] in (Status.BUFFER_FULL, Status.PAUSED):
        poison(run)
        calls.append(run.advance(steps, rows))
    assert calls[-1] == Status.GOOD
    assert len(calls) > 2
    got, state = table(run)
    np.testing.assert_array_equal(got, wanted)
    np.testing.assert_array_equal(state, end)


def test_a_pickled_copy_goes_on_where_the_run_was(load: Load) -> None:
    solver = load(chain(2))
    wanted, end = whole(solver)
    run = solver.begin(TIMES)
    run.advance(3, 5)
    saved = pickle.dumps(run.save())
    run.finish()
    for _ in range(2):
        copy = solver.resume(pickle.loads(saved))
        assert copy.written == 5
        copy.finish()
        np.testing.assert_array_equal(table(copy)[0], wanted)
        np.testing.assert_array_equal(copy.state, end)


def test_runs_in_threads_give_the_bits_of_a_run_alone(load: Load) -> None:
    solver = load(chain(2))
    wanted, _ = whole(solver)
    with ThreadPoolExecutor(4) as pool:
        for got, _ in pool.map(lambda _: whole(solver), range(8)):
            np.testing.assert_array_equal(got, wanted)


def test_state_of_another_solver_is_refused(load: Load) -> None:
    saved = load(chain(2)).begin(TIMES).save()
    with pytest.raises(SolveError, match="another solver: its size differs"):
        load(n_four_bar(1)).resume(saved)
    with pytest.raises(SolveError, match="another solver"):
        load(n_four_bar(1)).resume(load(n_four_bar(1, rate=-2.0)).begin(TIMES).save())
    empty = replace(saved, state=np.zeros_like(saved.state)).sealed()
    with pytest.raises(SolveError, match="is not started"):
        load(chain(2)).resume(empty)


def changed(solver: DynamicsSolver, saved: SavedRun, name: str, value: float) -> SavedRun:
    """Saved run with another number in its state."""
    state = saved.state.copy()
    solver.state[name].view(state).flat[-1] = value
    return replace(saved, state=state)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda s: replace(s, rows=s.rows[:2]), "it has 2 rows, 5 are written"),
        (lambda s: replace(s, rows=s.rows[:, :3]), "their shape is .*, wanted"),
        (lambda s: replace(s, rows=s.rows[0]), "the rows belong to another solver"),
        (lambda s: replace(s, rows=None), "the rows belong to another solver"),
        (lambda s: replace(s, rows=s.rows[::-1]), "its rows are of other times"),
        (lambda s: replace(s, rows=s.rows * np.nan), "its rows are of other times"),
        (lambda s: replace(s, state=s.state[:-1]), "its size differs"),
        (lambda s: replace(s, state=s.state.reshape(1, -1)), "its size differs"),
        (lambda s: replace(s, state="abc"), "state 'abc'; wanted a row of numbers"),
        (lambda s: replace(s, times=s.times[::-1]), "times must ascend"),
        (lambda s: replace(s, times=s.times[:3]), "5 rows are written, 3 times are asked for"),
        (lambda s: replace(s, times=s.times * 1.5), "its rows are of other times"),
        (lambda s: replace(s, options=None), "options None; wanted those of a saved run"),
        (lambda s: replace(s, options=replace(s.options, tolerance=np.nan)), "tolerance nan"),
        (lambda s: replace(s, options=replace(s.options, parameters=3)), "parameters 3"),
        (lambda s: replace(s, options=replace(s.options, initial=3)), "initial 3"),
        (lambda s: replace(s, options=replace(s.options, method="dopri5")), "method 'dopri5'"),
    ],
)
def test_saved_run_that_does_not_fit_itself_is_refused(
    load: Load, damage: Callable[[SavedRun], SavedRun], words: str
) -> None:
    solver = load(chain(2))
    run = solver.begin(TIMES)
    run.advance(3, 5)
    with pytest.raises(SolveError, match=words) as raised:
        solver.resume(damage(run.save()))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("next_row", 4.0, "it has 5 rows, 4 are written"),
        ("next_row", 1e9, "1000000000 rows are written, 28 times are asked for"),
        ("next_row", -1.0, "next_row in the state is -1.0; wanted a count"),
        ("next_row", 4.5, "next_row in the state is 4.5; wanted a count"),
        ("steps", np.nan, "steps in the state is nan; wanted a count"),
        ("avoided", np.nan, "avoided in the state is nan; wanted a count"),
        ("unresolved", np.nan, "unresolved in the state is nan; wanted a count"),
        ("short_steps", -1.0, "short_steps in the state is -1.0; wanted a count"),
        ("error", np.nan, "error in the state is not finite"),
        ("fastest", np.nan, "fastest in the state is not finite"),
        ("longest", np.inf, "longest in the state is not finite"),
        ("time", np.inf, "time in the state is not finite"),
        ("time", 0.01, "back to 0.01 s|only 0.01 s is reached"),
        ("time_before", 0.59, "leads from t = 0.59 s back"),
        ("y", np.nan, "y in the state is not finite"),
        ("f", np.inf, "f in the state is not finite"),
        ("dense", np.nan, "dense in the state is not finite"),
        *(
            (name, np.nan, f"{name} in the state is no number")
            for name in (
                *("drift", "row_drift", "limit", "behind", "switched", "largest_pivot_ratio"),
                *("energy_error", "energy_moved", "work_error", "violations"),
            )
        ),
    ],
)
def test_saved_state_that_was_forged_is_refused(
    load: Load, name: str, value: float, words: str
) -> None:
    solver = load(chain(2))
    run = solver.begin(TIMES)
    run.advance(3, 5)
    with pytest.raises(SolveError, match=words):
        solver.resume(changed(solver, run.save(), name, value))


@pytest.mark.parametrize("part", ["rows", "state", "times", "options", "digest"])
def test_number_that_was_changed_is_not_gone_on_from(load: Load, part: str) -> None:
    solver = load(scene_from_toml(SPRING))
    run = solver.begin(TIMES)
    run.advance(3, 5)
    saved = run.save()
    other: Any = ""
    if part == "options":
        other = replace(saved.options, tolerance=1.1 * saved.options.tolerance)
    elif part != "digest":
        other = getattr(saved, part).copy()
        place = solver.state["y"].place if part == "state" else -1
        other.flat[place] = np.nextafter(other.flat[place], np.inf)
    with pytest.raises(SolveError, match="are not those that were saved, as their digest tells"):
        solver.resume(replace(saved, **{part: other}))


def test_run_that_had_no_value_somewhere_is_resumed_and_not_trusted(load: Load) -> None:
    solver = load(chain(2))
    run = solver.begin(TIMES)
    run.advance(3, 5)
    saved = changed(solver, run.save(), "not_finite", 1.0)
    resumed = solver.resume(changed(solver, saved, "energy_error", np.nan).sealed()).finish()
    assert not resumed.ledger.trust.is_trusted


def test_parameters_of_options_and_state_must_agree(load: Load) -> None:
    solver = load(scene_from_toml(SPRING))
    saved = solver.begin(TIMES, parameters={"k": 2.0}).save()
    assert solver.resume(saved).finish().is_complete
    forged = replace(saved, options=replace(saved.options, parameters=(("k", 3.0),)))
    with pytest.raises(SolveError, match="other parameters than its state"):
        solver.resume(forged)


@pytest.mark.usefixtures("numpy_solver", "compiler")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_state_that_was_damaged_is_not_run(bodies_folder: Callable[..., Path], target: Any) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ALL), target=target)
    run = solver.begin(TIMES)
    rows = np.full((len(TIMES), solver.target.row_size), 7.0)
    for name, value in DAMAGE:
        memory = Memory(run.state.copy(), run._memory.work)
        solver.state[name].view(memory.state).flat[-1] = value
        before = memory.state.copy()
        go = solver.target.runner(run.options.settings(), TIMES, memory)
        assert go(9, rows) == Status.WRONG_STATE, name
        np.testing.assert_array_equal(memory.state, before)
    assert (rows == 7.0).all()


@pytest.mark.usefixtures("numpy_solver", "compiler")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_solver_that_is_called_alone_refuses_what_a_run_refuses(
    bodies_folder: Callable[..., Path], target: Any
) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ALL), target=target)
    settings = solver.begin(TIMES).options.settings()
    rows = np.empty((len(TIMES), solver.target.row_size))

    def status_with(times: Any = TIMES, **given: Any) -> int:
        """Status of the first call of a new run."""
        run = solver.begin(TIMES)
        memory = Memory(run.state, run._memory.work)
        go = solver.target.runner(settings._replace(**given), np.array(times), memory)
        return go(1, rows)

    for tolerance in (0.0, -1.0, 9e-16, 1.0, 2.0, np.inf, np.nan):
        assert status_with(tolerance=tolerance) == Status.BAD_ARGUMENT, tolerance
        with pytest.raises(SolveError, match="tolerance"):
            solver.begin(TIMES, tolerance=tolerance)
    for tolerance in (1e-15, 1e-9, 0.9):
        assert status_with(tolerance=tolerance) >= Status.GOOD, tolerance
    for step in (-1.0, np.inf, np.nan, 0.2):
        assert status_with(fixed_step=step, largest_step=0.1) == Status.BAD_ARGUMENT, step
        with pytest.raises(SolveError, match="step"):
            solver.begin(TIMES, step=step, largest_step=0.1)
    assert status_with(fixed_step=0.1, largest_step=0.1) >= Status.GOOD
    for longest in (0.0, -1.0, np.nan):
        assert status_with(largest_step=longest) == Status.BAD_ARGUMENT, longest
    for times in ([0.5, 0.2], [0.5, -1.0], [0.5, np.inf], [0.5, np.nan], [np.nan, 0.5], [-1.0]):
        assert status_with(times) == Status.BAD_ARGUMENT, times


@pytest.mark.usefixtures("interrupts")
def test_interrupt_keeps_what_was_computed_and_the_run_can_go_on(load: Load) -> None:
    solver = load(chain(2))
    wanted, _ = whole(solver, tolerance=1e-12)

    def press(reached: float, end: float) -> None:
        if reached > 0.1:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as caught:
        solver.simulate(times=TIMES, tolerance=1e-12, progress=press)
    stop = caught.value
    assert isinstance(stop, Interrupted)
    assert not stop.result.is_complete
    assert 0 < len(stop.result) < len(TIMES)
    rows = np.stack(list(stop.result.columns().values()))
    np.testing.assert_array_equal(rows, wanted[:, : len(stop.result)])
    assert stop.run.finish().is_complete
    np.testing.assert_array_equal(table(stop.run)[0], wanted)


def test_progress_tells_the_time_reached_and_the_last_time(load: Load) -> None:
    seen: list[tuple[float, float]] = []
    load(chain(2)).simulate(
        times=TIMES, tolerance=1e-12, progress=lambda *times: seen.append(times)
    )
    assert seen
    assert [reached for reached, _ in seen] == sorted({reached for reached, _ in seen})
    assert {end for _, end in seen} == {TIMES[-1]}
