"""The benchmark of kernels: it states the emitted problem, times what is right, judges targets."""

import ctypes
import gc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kousoku import runtime
from kousoku.runtime.report import Row
from kousoku.runtime.toolchain import Toolchain
from tests.benchmarks import kernels, limits, p2
from tests.benchmarks.kit import Record, Size
from tests.benchmarks.limits import Limits
from tests.benchmarks.loops import Batch, kousoku_loop, sympy_loop

ROOT = Path(__file__).parents[2]
P2 = ROOT / "generated" / "kinds" / "p2"


@pytest.fixture(scope="module")
def judge() -> p2.Judge:
    return p2.Judge()


def test_the_peers_get_the_formula_that_is_emitted() -> None:
    rows = p2.inputs(5)
    c, c_q = p2.p2(*[list(array.T) for array in rows])
    wanted_c, wanted_c_q = runtime.load(P2, target="numpy")["constraint_z"](*rows)
    np.testing.assert_allclose(np.stack(c, axis=-1), wanted_c, rtol=1e-13, atol=1e-14)
    jacobian = np.stack([np.stack(row, axis=-1) for row in c_q], axis=-2)
    np.testing.assert_allclose(jacobian, wanted_c_q, rtol=1e-13, atol=1e-14)


def test_the_judge_measures_in_units_of_rounding(judge: p2.Judge) -> None:
    found, rows = p2.p2(*[list(array.T) for array in judge.inputs])
    c = np.stack(found, axis=-1)
    c_q = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    assert judge.worst(c, c_q) < 4
    c[7, 1] += 1e-12
    assert judge.worst(c, c_q) > 100


@pytest.mark.parametrize("cse", [False, True])
def test_the_code_of_sympy_is_right_and_its_arrays_last(
    compiler: Toolchain, judge: p2.Judge, tmp_path: Path, cse: bool
) -> None:
    loop = sympy_loop(tmp_path, cse=cse)
    n = p2.SAMPLE
    c, c_q = np.zeros((n, 2)), np.zeros((n, 24))
    run = loop.bind(p2.inputs(n), (c, c_q))  # nobody else holds the inputs
    gc.collect()
    run()
    assert judge.worst(c, c_q.reshape(-1, 2, 12)) < 4


def test_loops_and_batches_are_judged_by_what_they_wrote(
    compiler: Toolchain, judge: p2.Judge, tmp_path: Path
) -> None:
    n = p2.SAMPLE
    for bind in (kousoku_loop(tmp_path, P2).bind, Batch(tmp_path, P2).rows):
        c, c_q = np.zeros((n, 2)), np.zeros((n, 2, 12))
        run = bind(p2.inputs(n), (c, c_q))
        assert judge.worst(c, c_q) > 4
        run()
        assert judge.worst(c, c_q) < 4


def test_every_contest_of_p2_has_ours_first_and_peers() -> None:
    size = Size(is_full=True)
    raced = [name for name in kernels.contests(size) if name.startswith("p2, ")]
    assert set(kernels.contests(Size())) <= set(kernels.contests(size))
    tools = {name: [case.tool for case in kernels.cases(name, size)] for name in raced}
    assert {found[0] for found in tools.values()} == {"kousoku"}
    peers = {tool for found in tools.values() for tool in found} - {"kousoku"}
    assert peers == {"CasADi", "SymForce", "SymPy", "heyoka"}
    judged = {target.contest for target in kernels.targets(records_of(raced, 1.0))}
    extra = kernels.batch_name(kernels.EXTRA_BATCH)
    assert judged == set(raced) - {extra}


def records_of(contests: list[str], ours: float) -> list[Record]:
    """Records in which peers take a microsecond, and kousoku a multiple of that."""
    return [
        Record(contest, case.tool, case.line, "", fastest=1e-6 * ours ** (case.tool == "kousoku"))
        for contest in contests
        for case in kernels.cases(contest, Size(is_full=True))
    ]


@pytest.mark.parametrize(("ours", "is_met"), [(0.7, True), (0.71, False)])
def test_a_target_is_met_up_to_its_limit(ours: float, is_met: bool) -> None:
    found = kernels.targets(records_of([kernels.SINGLE], ours))
    assert [target.limit for target in found] == [0.7, 0.7]
    assert [target.is_met for target in found] == [is_met, is_met]
    assert found[0].value == pytest.approx(ours)


def test_words_tell_where_kernels_win_and_lose() -> None:
    records = records_of([kernels.batch_name(n) for n in (1000, 4000)], 0.5)
    told = "takes of the time of others\n- batch: 0.5 of heyoka (cfunc)"
    assert told in kernels.words(records)
    records[0].fastest = 2e-6
    assert "0.5 of heyoka (cfunc)" in kernels.words(records[4:])
    for one in records[:2]:
        one.fastest = 2e-6
    assert "0.5 to 2 of heyoka (cfunc)" in kernels.words(records)
    assert kernels.words([]) == ""


def test_a_peer_that_is_missing_misses_its_target() -> None:
    records = records_of([kernels.batch_name(4000)], 0.1)
    for one in records:
        if one.tool == "heyoka":
            one.fastest, one.note = None, "missing: heyoka"
    found = kernels.targets(records)
    assert len(found) == 2 and not any(target.is_met for target in found)


def test_calls_from_python_are_judged_in_microseconds() -> None:
    found = kernels.targets(records_of([kernels.CALLS], 0.59))
    assert {target.limit: target.is_met for target in found} == {2.0: True, 0.6: True}
    found = kernels.targets(records_of([kernels.CALLS], 0.61))
    assert {target.limit: target.is_met for target in found} == {2.0: True, 0.6: False}


def test_a_kind_is_measured_in_all_ways_with_its_error(
    compiler: Toolchain, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "rounds_of", lambda _: 0)  # trials alone
    monkeypatch.setattr(kernels, "QUICK_SIZES", (3, 1000))
    monkeypatch.setattr(kernels, "MOST_BYTES", 1000 * 400)
    found = list(kernels.measure_kind("p2", Size()))
    lines = {one.line for one in found}
    assert {line.partition(":")[0] for line in lines} == {"constraint_z", "rates_z", "reaction_z"}
    ways = {line.partition(": ")[2] for line in lines}
    assert ways == set(kernels.VERIFIED)
    for one in found:
        if one.note:  # C_q and the derivative of C_q^T lambda are large
            assert one.line.startswith("reaction_z") and one.fastest is None
            assert one.setting.startswith("1000,")
        else:
            assert one.fastest is not None and one.fastest > 0
            assert one.error is not None and 0 < one.error <= 4
    settings = {one.setting for one in found if one.line == "rates_z: C, lanes"}
    assert settings == {"3, 1 thread", "1000, 1 thread", "1000, 2 threads"}
    known = Limits({("vector", 1): 1e-10, ("vector", 2): 1e-10, ("scalar", 1): 1e-10}, FLAT)
    monkeypatch.setattr(kernels, "BATCH_SHOWN", 1000)
    own = [one for one in found if one.line.startswith("constraint_z")]
    table = kernels._table_of_kinds(own, known)
    assert "| p2 constraint_z | 183 |" in table


FLAT = {1: [(1e3, 1e-11), (1e9, 1e-11)], 2: [(1e3, 1e-11), (1e9, 1e-11)]}


def test_threads_share_all_evaluations() -> None:
    assert kernels._parts(7, 2) == [4, 3]
    assert sum(kernels._parts(10**6, 2)) == 10**6
    ran: list[int] = []
    limits.together([lambda: ran.append(1), lambda: ran.append(2)])()
    assert sorted(ran) == [1, 2]


def test_points_are_repeated_and_begin_a_cache_line() -> None:
    values = np.arange(6.0).reshape(3, 2)
    found = limits.repeated(values, 8)
    assert (found == np.resize(values, (8, 2))).all()
    assert found.ctypes.data % 64 == 0 and limits.aligned(values).ctypes.data % 64 == 0


def test_what_a_machine_needs_at_least_is_arithmetic_or_memory() -> None:
    def record(line: str, setting: str, seconds: float, **extra: float) -> Record:
        return Record(limits.CONTEST, "machine", line, setting, fastest=seconds, extra=extra)

    known = Limits.of(
        [
            record("operations, vector", "1 thread", 1e-10),
            record("bytes", "1024, 1 thread", 1e-11, bytes=1024.0, threads=1.0),
            record("bytes", "1048576, 1 thread", 3e-11, bytes=2.0**20, threads=1.0),
            Record("another", "kousoku", "bytes", "1 thread", fastest=1.0),
        ]
    )
    assert known.seconds(100, 8, 1024, unit="vector") == (1e-8, "arithmetic")
    seconds, what = known.seconds(1, 1000, 2.0**15, unit="vector")
    assert what == "memory" and seconds == pytest.approx(2e-8)  # half-way of the powers


def test_the_limits_are_those_of_what_is_computed(compiler: Toolchain, tmp_path: Path) -> None:
    library = limits._library(tmp_path, "vector")
    state = limits.aligned(np.array([0.5, 1.0, 2.0] + [0.0] * 21))
    address: Any = ctypes.c_void_p(state.ctypes.data)
    done = library.operations(ctypes.c_size_t(200), address)
    width = library.width()
    assert done == 200 * 12 * width * 2
    assert state[8 : 8 + width] == pytest.approx(12 * 2.0)  # y = y / 2 + 1 leads to 2
    x, y, z = (np.arange(8.0 * width) + k for k in range(3))
    run = limits._passes(library, "scale", 8, [x, y])
    run.call(ctypes.c_size_t(1), *run.arguments[1:])
    assert (y == x / 2).all()
    run = limits._passes(library, "triad", 8, [x, y, z])
    run.call(ctypes.c_size_t(1), *run.arguments[1:])
    assert (z == x + y / 2).all()


def test_a_kind_that_fails_is_a_line_of_the_table() -> None:
    known = Limits({("vector", 1): 1e-10, ("scalar", 1): 1e-10}, FLAT)
    failed = Record("kind p2", "kousoku", "all", "", note="fails: LoadError: p2 is edited")
    assert "| p2 | fails: LoadError: p2 is edited |" in kernels._table_of_kinds([failed], known)


def test_an_error_that_is_known_stands_beside_that_of_rounding() -> None:
    def row(worst: float, limit: float, way: str = "C") -> Row:
        return Row("k", "y", way, worst, (), 0, "", (), 0.0, 0.0, limit)

    rows = [row(0.5, 4.0), row(1.5, 4.0), row(80.0, 90.0), row(3.0, 4.0, "NumPy")]
    assert kernels._worst(rows, "C") == (1.5, 80.0)
    assert kernels._worst(rows, "NumPy") == (3.0, 0.0)
    one = Record("kind k", "kousoku", "k: C, one call", "", error=1.5, extra={"known": 80.0})
    assert kernels._units_of(one) == "1.50, known 80"
