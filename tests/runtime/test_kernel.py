"""Calling a kernel: the same behaviour through the extension, through ctypes and in NumPy."""

from __future__ import annotations

import copy
import pickle
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime import from_lanes, load, to_lanes

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from kousoku.runtime import Library

    Floats = NDArray[np.float64]

R, LENGTH = np.array([1.0, 2.0, 3.0]), np.array(2.0)
C, C_Q = np.array([28.0]), np.array([[4.0, 8.0, 12.0, 0.0]])


def outputs_of(r: Floats, length: Floats) -> tuple[Floats, Floats]:
    """Constraints C and Jacobian C_q by einsum, exact for small integers."""
    row = np.concatenate([r, np.zeros((*r.shape[:-1], 1))], axis=-1)
    C = np.broadcast_to(length, np.broadcast_shapes(length.shape, r.shape[:-1])) * (r**2).sum(-1)
    return C[..., None], (2 * length[..., None] * row)[..., None, :]


def test_a_call_gives_all_outputs_in_kernel_order(library: Library) -> None:
    results = library.sphere(R, LENGTH)
    assert isinstance(results, tuple)
    np.testing.assert_array_equal(results[0], C, strict=True)
    np.testing.assert_array_equal(results[1], C_Q, strict=True)


def test_inputs_may_be_named(library: Library) -> None:
    for results in (
        library.sphere(R, length=LENGTH),
        library.sphere(length=LENGTH, r=R),
    ):
        np.testing.assert_array_equal(results[0], C)


@pytest.mark.parametrize(
    ("r", "length"),
    [
        ([1, 2, 3], 2),
        ((1.0, 2.0, 3.0), 2.0),
        (np.array([1, 2, 3], dtype=np.int8), np.float32(2)),
        (np.array([1, 2, 3], dtype=np.float16), np.longdouble(2)),
        (np.array([1, 2, 3], dtype=np.dtype(np.float64).newbyteorder()), LENGTH),
        (np.arange(12.0)[1:7:2] / 2 + 0.5, LENGTH),
        (np.array([3.0, 2.0, 1.0])[::-1], LENGTH),
        (np.frombuffer(b"x" + R.tobytes(), np.float64, offset=1), LENGTH),
        (R.astype(object).tolist(), np.array(2)),
        (np.ma.array(R), LENGTH),
    ],
    ids=lambda value: type(value).__name__,
)
def test_inputs_are_converted_as_numpy_does(library: Library, r: Any, length: Any) -> None:
    results = library.sphere(r, length)
    np.testing.assert_array_equal(results[0], C)
    np.testing.assert_array_equal(results[1], C_Q)
    assert all(type(array) is np.ndarray for array in results)


@pytest.mark.parametrize("outputs", [("C_q",), ["C_q"], "C_q", ("C_q", "C_q")])
def test_only_what_is_asked_for_is_returned(library: Library, outputs: Any) -> None:
    for _ in range(2):
        (result,) = library.sphere(R, LENGTH, outputs=outputs)
        np.testing.assert_array_equal(result, C_Q)


def test_asked_for_outputs_come_in_kernel_order(library: Library) -> None:
    first, second = library.sphere(R, LENGTH, outputs=iter(["C_q", "C"]))
    assert first.shape == (1,)
    assert second.shape == (1, 4)
    assert library.sphere(R, LENGTH, outputs=()) == ()


def test_out_is_written_and_returned(library: Library) -> None:
    out = (np.full(1, np.nan), np.full((1, 4), np.nan))
    results = library.sphere(R, LENGTH, out=out)
    assert [a is b for a, b in zip(results, out, strict=True)] == [True, True]
    np.testing.assert_array_equal(out[0], C)
    np.testing.assert_array_equal(out[1], C_Q)


@pytest.mark.parametrize("n", [None, 5])
def test_what_out_leaves_away_is_not_computed(library: Library, n: int | None) -> None:
    batch = () if n is None else (n,)
    out = np.full((*batch, 1, 4), np.nan)
    r = np.broadcast_to(R, (*batch, 3)).copy()
    (result,) = library.sphere(r, LENGTH, out=(None, out), outputs=("C",))
    assert result is out
    np.testing.assert_array_equal(out, np.broadcast_to(C_Q, (*batch, 1, 4)))


@pytest.mark.parametrize(
    ("r_batch", "length_batch"),
    [
        ((), ()),
        ((1,), ()),
        ((7,), ()),
        ((), (7,)),
        ((7,), (7,)),
        ((7,), (1,)),
        ((1,), (1,)),
        ((1, 1), (1,)),
        ((2, 3), (2, 3)),
        ((2, 3), ()),
        ((2, 3), (3,)),
        ((2, 1), (3,)),
        ((4, 1, 2), (3, 1)),
        ((2, 3, 2, 2, 2), (2,)),
        ((0,), ()),
        ((0,), (0,)),
        ((3, 0), (1,)),
        ((0,), (1,)),
        ((8192,), (8192,)),
    ],
)
def test_leading_axes_broadcast(
    library: Library,
    rng: np.random.Generator,
    r_batch: tuple[int, ...],
    length_batch: tuple[int, ...],
) -> None:
    r = rng.integers(-9, 9, (*r_batch, 3)).astype(np.float64)
    length = rng.integers(-9, 9, length_batch).astype(np.float64)
    wanted = outputs_of(r, length)
    for results in (
        library.sphere(r, length),
        library.sphere(r, length, out=tuple(np.full(a.shape, np.nan) for a in wanted)),
    ):
        for got, expected in zip(results, wanted, strict=True):
            np.testing.assert_array_equal(got, expected, strict=True)


@pytest.mark.parametrize("batch", [(1,), (1, 1), (2, 1)])
def test_a_batch_of_one_reaches_an_emitted_kernel_as_a_batch(batch: tuple[int, ...]) -> None:
    folder = str(files("kousoku.generated") / "kinds" / "norm")
    results = load(folder, target="numpy")["constraint"](np.ones((*batch, 4)))
    for got, wanted in zip(results, (np.full(1, 3.0), np.full((1, 4), 2.0)), strict=True):
        expected = np.broadcast_to(wanted, batch + wanted.shape)
        np.testing.assert_array_equal(got, expected, strict=True)


def test_a_batch_with_strides_is_copied(library: Library) -> None:
    table = np.arange(60.0).reshape(10, 6)
    for r in (table[:, ::2], table[::3, :3], np.asfortranarray(table[:, :3]), table[::-1, 3:]):
        for got, wanted in zip(library.sphere(r, LENGTH), outputs_of(r, LENGTH), strict=True):
            np.testing.assert_array_equal(got, wanted)


def test_results_do_not_share_memory_with_the_next_call(library: Library) -> None:
    first = library.sphere(R, LENGTH)
    library.sphere(-R, LENGTH)
    np.testing.assert_array_equal(first[1], C_Q)


def test_an_output_may_overwrite_an_input(library: Library) -> None:
    memory = np.array([1.0, 2.0, 3.0, 9.0])
    library.sphere(memory[:3], LENGTH, out=(None, memory.reshape(1, 4)))
    np.testing.assert_array_equal(memory, C_Q[0])
    rows = np.repeat(np.array([[1.0, 2.0, 3.0, 9.0]]), 5, axis=0)
    library.sphere(rows.reshape(-1)[:15].reshape(5, 3), LENGTH, out=(None, rows.reshape(5, 1, 4)))
    np.testing.assert_array_equal(rows[0], C_Q[0])


def test_nan_and_infinity_are_numbers_like_others(library: Library) -> None:
    with np.errstate(all="ignore"):
        values, row = library.sphere([np.nan, np.inf, 1.0], 1.0)
    assert np.isnan(values[0])
    np.testing.assert_array_equal(row[0], [np.nan, np.inf, 2.0, 0.0])


class TestBind:
    """A kernel with fixed arrays."""

    def test_it_reads_and_writes_in_place(self, library: Library) -> None:
        r, out = R.copy(), (np.empty(1), np.empty((1, 4)))
        bound = library.sphere.bind(r, LENGTH, out=out)
        results = bound()
        np.testing.assert_array_equal(out[0], C)
        r[0] = 0.0
        assert bound() is results
        np.testing.assert_array_equal(out[0], [26.0])
        assert results[0] is out[0]

    def test_it_allocates_what_is_not_given(self, library: Library) -> None:
        bound = library.sphere.bind(length=LENGTH, r=R, outputs=("C_q",))
        assert bound.out[0] is None
        np.testing.assert_array_equal(bound()[0], C_Q)

    def test_it_takes_a_batch(self, library: Library) -> None:
        r = np.arange(15.0).reshape(5, 3)
        np.testing.assert_array_equal(library.sphere.bind(r, LENGTH)()[1], outputs_of(r, LENGTH)[1])

    @pytest.mark.parametrize(
        "r", [[1, 2, 3], np.arange(3), np.arange(6.0)[::2], np.arange(3, dtype=np.float32)]
    )
    def test_it_refuses_what_it_would_have_to_copy(self, library: Library, r: Any) -> None:
        with pytest.raises(TypeError, match=r"tiny\.sphere: bind reads r in place"):
            library.sphere.bind(r, LENGTH)

    def test_it_reads_a_read_only_array(self, library: Library) -> None:
        r = R.copy()
        r.flags.writeable = False
        np.testing.assert_array_equal(library.sphere.bind(r, LENGTH)()[0], C)

    def test_an_array_that_was_changed_underneath_is_noticed(self, library: Library) -> None:
        r = R.copy()
        bound = library.sphere.bind(r, LENGTH)
        r.resize((100000,), refcheck=False)
        with pytest.raises(ValueError, match="input r: got shape"):
            bound()


class TestLanes:
    """Arrays laid out in blocks of the vector width."""

    @pytest.mark.parametrize("n", [0, 1, 8, 13])
    def test_it_gives_what_a_batch_gives(
        self, library: Library, rng: np.random.Generator, n: int
    ) -> None:
        width = library.sphere.lane_width
        r, length = rng.standard_normal((n, 3)), rng.standard_normal(n)
        blocks = library.sphere.lanes(to_lanes(r, width), length=to_lanes(length, width))
        for got, wanted in zip(blocks, library.sphere(r, length), strict=True):
            assert got.shape == (-(-n // width), *wanted.shape[1:], width)
            np.testing.assert_array_equal(from_lanes(got, n), wanted)

    def test_it_takes_out_and_outputs(self, library: Library) -> None:
        width = library.sphere.lane_width
        r, length = to_lanes(np.ones((5, 3)), width), to_lanes(np.ones(5), width)
        out = np.empty((len(r), 1, width))
        assert library.sphere.lanes(r, length, out=(out, None))[0] is out
        np.testing.assert_array_equal(out, 3.0)
        assert len(library.sphere.lanes(r, length, outputs=("C_q",))) == 1

    def test_it_names_the_shape_it_wants(self, library: Library) -> None:
        width = library.sphere.lane_width
        wanted = rf"input r: got shape \(2, 3\), wanted \(2, 3, {width}\)"
        with pytest.raises(ValueError, match=wanted):
            library.sphere.lanes(np.ones((2, 3)), np.ones((2, width)))
        with pytest.raises(ValueError, match=rf"input length: got shape .*, wanted \(2, {width}\)"):
            library.sphere.lanes(np.ones((2, 3, width)), np.ones((3, width)))
        with pytest.raises(ValueError, match="input r: got shape"):
            library.sphere.lanes(1.0, 1.0)


def test_many_threads_may_call_at_once(library: Library, rng: np.random.Generator) -> None:
    r = rng.integers(-9, 9, (64, 501, 3)).astype(np.float64)
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda rows: library.sphere(rows, LENGTH), r))
    for rows, got in zip(r, results, strict=True):
        np.testing.assert_array_equal(got[1], outputs_of(rows, LENGTH)[1])


def test_a_long_batch_lets_other_threads_run(library: Library) -> None:
    r, length = np.ones((400_000, 3)), np.ones(400_000)
    out = library.sphere(r, length)
    finished: list[bool] = []
    started = threading.Event()

    def evaluate() -> None:
        started.set()
        library.sphere(r, length, out=out)
        finished.append(True)

    interval = sys.getswitchinterval()
    # No thread is interrupted: the main one sees the call unfinished only if the call lets go.
    sys.setswitchinterval(1000.0)
    try:
        for _ in range(50):
            started.clear()
            finished.clear()
            thread = threading.Thread(target=evaluate)
            thread.start()
            started.wait()
            was_finished = bool(finished)
            thread.join()
            if not was_finished:
                return
    finally:
        sys.setswitchinterval(interval)
    pytest.fail("the interpreter was never free while a batch ran")


def test_a_library_survives_copying_and_pickling(library: Library) -> None:
    for twin in (copy.deepcopy(library), pickle.loads(pickle.dumps(library))):
        assert twin.target == library.target
        np.testing.assert_array_equal(twin.sphere(R, LENGTH)[0], C)


def test_a_kernel_shows_its_signature(library: Library) -> None:
    assert repr(library.sphere) == (
        "<tiny.sphere: r (3,) [m], length () [m] -> C (1,) [m3], C_q (1, 4) [m2]>"
    )


@pytest.mark.usefixtures("warm_cache", "compiler")
def test_more_arrays_than_the_extension_holds_still_work(
    warm_package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def too_many(*_: object) -> None:
        raise ValueError("too many arrays")

    monkeypatch.setattr("kousoku.runtime.plan.plan_type", lambda _: too_many)
    library = load(warm_package, target="c")
    np.testing.assert_array_equal(library.sphere(R, LENGTH)[0], C)
