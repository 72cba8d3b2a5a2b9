"""The benchmark of evaluations: segments are counted as the ledger counts, and computed alike."""

from pathlib import Path

import numpy as np
import pytest

import kousoku as ks
from kousoku.model.reading.families import n_four_bar
from kousoku.runtime.toolchain import Toolchain
from tests.benchmarks import aba, chains, evaluations
from tests.benchmarks.kit import Figures, PeerMissingError, Record, Size
from tests.benchmarks.problems.problem import finished
from tests.benchmarks.segments import (
    END_OF_SOURCE,
    SEGMENTS,
    Segments,
    instrumented,
    seconds_of_parts,
    share_of_factors,
)
from tests.door.test_own_kinds import solver_of

END = 0.5


@pytest.fixture(scope="module")
def bars() -> ks.Mechanism:
    return ks.load(n_four_bar(2), target="c")


def test_segments_are_run_as_often_as_the_ledger_says_and_bits_stay(
    compiler: Toolchain, bars: ks.Mechanism, tmp_path: Path
) -> None:
    segments = Segments.of(solver_of(bars), tmp_path)
    run = segments.solver.begin([END], checks=False, tolerance=1e-8)
    segments.counted()
    finished(run)
    found = segments.counted()
    ledger = run.motion().ledger
    assert found["position"] == ledger.corrections > 0
    # but for what is looked at where a run begins
    assert 0 <= found["acceleration"] - ledger.derivatives <= 2
    assert 0 <= found["geometry"] - ledger.factorisations <= 2 < ledger.derivatives
    assert set(segments.counted().values()) == {0}
    plain = bars.begin([END], checks=False, tolerance=1e-8)
    finished(plain)
    assert (plain.motion().rows == run.motion().rows).all()


def test_a_loop_leaves_a_segment_what_it_found(
    compiler: Toolchain, bars: ks.Mechanism, tmp_path: Path
) -> None:
    solver = solver_of(bars)
    segments = Segments.of(solver, tmp_path)
    y = np.concatenate([solver.q, solver.v])
    wanted = solver.evaluate()
    for name in ("geometry", "position", "velocity", "acceleration"):
        loop = segments.alone(name, 0.0, y, np.zeros(0))
        assert loop.rounds >= 10
        loop()
        places = {key: loop.work[base : base + n] for key, (base, n) in solver.places.items()}
        for key in ("v_dot", "C", "dq", "dv"):
            assert places[key] == pytest.approx(wanted[key], rel=1e-12, abs=1e-14), (name, key)


def test_a_source_that_ends_otherwise_is_refused() -> None:
    text = instrumented(f"int x;\n{END_OF_SOURCE}\n")
    assert text.index("#define geometry(w)") < text.index(END_OF_SOURCE)
    for source in ("int x;\n", f"{END_OF_SOURCE}\nint x;\n"):
        with pytest.raises(ValueError, match="solver's source ends with"):
            instrumented(source)


def test_the_parts_of_an_evaluation_are_all_of_it() -> None:
    calls = dict.fromkeys(SEGMENTS, 0.0) | {"geometry": 2.0, "position": 1.0, "acceleration": 1.0}
    alone = {"geometry": 10.0, "position": 3.0, "acceleration": 5.0}
    found = seconds_of_parts(calls, alone, 0.25, 100.0)
    assert found["factorisation"] == 5.0 and found["projection"] == 18.0
    assert found["equations"] == 5.0 and found["others"] == 0.0
    assert sum(found.values()) == pytest.approx(100.0)


def test_a_bar_on_a_hinge_has_nothing_to_factorise(bars: ks.Mechanism) -> None:
    assert share_of_factors(ks.load("scenes/pendulum.toml", target="c")) == 0.0
    assert 0.05 < share_of_factors(bars) < 0.9


@pytest.mark.parametrize("count", [2, 10])
def test_the_accelerations_that_are_timed_are_those_of_dense_matrices(
    compiler: Toolchain, tmp_path: Path, count: int
) -> None:
    """At random consistent states; the matrices are those of joint angles, without constraints."""
    ours = chains.kousoku_accelerations(count, tmp_path)
    ours.run(1)
    assert chains.difference(ours.results(), chains.reference(count)) < 1e-11


def test_the_recursion_gives_what_dense_matrices_give() -> None:
    theta, rate = chains.joint_states(10)
    wanted = [chains.dense(*state) for state in zip(theta, rate, strict=True)]
    assert chains.recursive(theta, rate) == pytest.approx(np.array(wanted), rel=1e-10)


def test_the_accelerations_of_a_thousand_bars_are_those_of_the_recursion(
    compiler: Toolchain,
) -> None:
    contest = evaluations.chain_name(1000)
    (case,) = evaluations.cases(contest, Size(is_full=True))
    call = case.prepare()
    call.run()
    judged = call.judge()
    (target,) = evaluations.targets(
        [Record(contest, "kousoku", case.line, "", fastest=1.0, extra=judged.extra)]
    )
    assert target.quantity.endswith("recursion") and target.is_met and target.limit == 1e-9


def test_the_dense_matrices_swing_a_bar_as_a_pendulum() -> None:
    """θ̈ = m g l cos θ / J about the hinge, θ downwards from the horizontal about y."""
    theta = np.array([0.3])
    inertia = 1.01 / 12 + 0.25
    wanted = 9.81 * 0.5 * np.cos(theta) / inertia
    assert chains.dense(theta, np.array([0.7])) == pytest.approx(wanted, rel=1e-14)


def test_the_motion_of_the_bars_is_differentiated_as_differences_are() -> None:
    theta, rate = (array[:2, :4] for array in chains.joint_states(10))
    change, h = rate[::-1], 1e-4

    def at(t: float) -> chains.Bars:
        angles = theta + t * rate + t * t / 2 * change
        return chains.bars(angles, rate + t * change, change)

    before, now, after = at(-h), at(0.0), at(h)
    for value, slope in (("r", "v"), ("v", "a"), ("omega_b", "alpha_b")):
        difference = (getattr(after, value) - getattr(before, value)) / (2 * h)
        assert getattr(now, slope) == pytest.approx(difference, rel=1e-6, abs=1e-6)


def chain_records(*, looped: bool) -> list[Record]:
    """Times of a chain of 10: 200 ns a bar, Pinocchio 300 ns with 1 µs for each call."""

    def record(count: int, tool: str, line: str, seconds: float, **extra: float) -> Record:
        names = (evaluations.chain_name(count), tool, line, "")
        return Record(*names, fastest=seconds, extra=extra)

    differences = {"Pinocchio": 1e-12, "recursion": 1e-8}
    found = [
        record(1, "Pinocchio", evaluations.BY_CALL, 1.3e-6),
        record(10, "kousoku", "geometry and acceleration", 200e-9, **differences),
        record(10, "Pinocchio", evaluations.BY_CALL, 400e-9),
    ]
    loop = record(10, "Pinocchio", evaluations.BY_LOOP, 160e-9)
    return [*found, loop] if looped else found


def test_a_call_of_pinocchio_counts_without_what_calling_takes() -> None:
    time, peer, recursion = evaluations.targets(chain_records(looped=False))
    assert time.value == pytest.approx(200 / 300) and time.is_met
    assert peer.is_met and not recursion.is_met
    time, *_ = evaluations.targets(chain_records(looped=True))
    assert time.value == pytest.approx(200 / 160) and not time.is_met


def test_what_could_not_be_measured_misses_its_target() -> None:
    ours = [one for one in chain_records(looped=False) if one.tool == "kousoku"]
    ours[0].extra.clear()
    assert [target.value for target in evaluations.targets(ours)] == [None, None, None]


def test_without_pinocchio_its_case_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise PeerMissingError(name)

    monkeypatch.setattr(aba, "required", missing)
    cases = evaluations.cases(evaluations.chain_name(10), Size())
    assert [case.tool for case in cases] == ["kousoku", "Pinocchio", "MuJoCo"]
    with pytest.raises(PeerMissingError, match="pinocchio"):
        cases[1].prepare()


def test_the_page_has_parts_counts_and_chains(tmp_path: Path) -> None:
    names = ("pendulum", "kousoku")
    made = {"steps": 0.1, "rejected": 0.01, "factorisations": 2.0, "corrections": 1.0}
    extra = made | {"refinements": 0.0, "evaluations": 1000.0}
    records = [Record(*names, "all", "", fastest=1e-6, extra=extra)]
    records += [Record(*names, part, "", fastest=2e-7) for part in evaluations.COLUMNS]
    records[1].extra = {"geometry": 2.0}
    records += chain_records(looped=True)
    page = evaluations.body(records, Figures(tmp_path, "here"))
    assert "| pendulum | 1000 | 200 (20 %) |" in page
    assert "| pendulum | 1000 | 100 | 10 | 2 | 1 | 0 | geometry 2 |" in page
    assert "kousoku, geometry and acceleration | 200 | 1.0e-12 from Pinocchio" in page
