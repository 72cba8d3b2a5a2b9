"""A run can be stopped anywhere, copied, and resumed: its rows keep their bits."""

from __future__ import annotations

import pickle
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError, SolveError
from kousoku.model.families import chain, n_four_bar
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.settings import Status
from kousoku.runtime.run import Interrupted

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run import Run

ALL = ("accelerations", "reactions", "energies")
TIMES = np.sort(np.append(np.linspace(0.0, 0.6, 25), [0.0, 0.31, 0.3100001]))
Load = Any


@pytest.fixture
def load(backend: str, bodies_folder: Callable[..., Path]) -> Load:
    target: Any = backend
    return lambda scene: load_dynamics(bodies_folder(scene, ALL), target=target)


def table(run: Run) -> Any:
    """Return the columns and the state at the end, without the time that it took."""
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
    run.advance(2, 5)
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
    empty = replace(saved, state=np.zeros_like(saved.state))
    with pytest.raises(SolveError, match="is not started"):
        load(chain(2)).resume(empty)


def test_state_that_was_damaged_is_not_run(load: Load) -> None:
    run = load(chain(2)).begin(TIMES)
    run.state[0] += 1.0
    assert run.advance() == Status.WRONG_STATE
    assert run.written == 0


def test_method_cannot_change_on_the_way(load: Load) -> None:
    solver = load(chain(2))
    run = solver.begin(TIMES, method="dopri5")
    run.advance(2)
    saved = run.save()
    with pytest.raises(MotionError, match="out of range"):
        solver.resume(replace(saved, options=replace(saved.options, method="dop853"))).finish()


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
