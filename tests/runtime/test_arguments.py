"""Wrong arguments: the same message for every target, and never a crash."""

from __future__ import annotations

from contextlib import suppress
from decimal import Decimal
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.arguments import Signature
from kousoku.runtime.sources import read_manifest

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime import Library

R, LENGTH = np.array([1.0, 2.0, 3.0]), np.array(2.0)


def read_only(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    ("inputs", "error", "message"),
    [
        ((), TypeError, "tiny.sphere: got 0 inputs, wanted 2: r, length; missing: r, length"),
        ((R,), TypeError, "tiny.sphere: got 1 inputs, wanted 2: r, length; missing: length"),
        ((R, 1, 2), TypeError, "tiny.sphere: got 3 inputs, wanted 2: r, length"),
        (
            (None, 1),
            TypeError,
            "tiny.sphere: input r: got dtype object, wanted real numbers that convert to float64",
        ),
        (
            (R, "2"),
            TypeError,
            "tiny.sphere: input length: got dtype <U1, wanted real numbers that convert to float64",
        ),
        ((R + 1j, 1), TypeError, "tiny.sphere: input r: got dtype complex128, wanted real"),
        ((R, Decimal(2)), TypeError, "tiny.sphere: input length: got dtype object, wanted real"),
        ((R, np.timedelta64(1, "s")), TypeError, "input length: got dtype timedelta64"),
        ((R, np.zeros(2, "f8,f8")), TypeError, "input length: got dtype"),
        (([[1, 2], [3]], 1), ValueError, "tiny.sphere: input r: cannot be read as an array: "),
        (
            (R[:2], 1),
            ValueError,
            "tiny.sphere: input r: got shape (2,), wanted (3,) after any leading batch axes",
        ),
        ((1.0, 1), ValueError, "tiny.sphere: input r: got shape (), wanted (3,) after any"),
        ((np.ones((3, 2)), 1), ValueError, "tiny.sphere: input r: got shape (3, 2), wanted (3,)"),
        (
            (np.ones((4, 3)), np.ones(5)),
            ValueError,
            "tiny.sphere: the leading batch axes do not broadcast: r (4,), length (5,)",
        ),
    ],
    ids=str,
)
def test_wrong_inputs_are_named(
    library: Library, inputs: tuple[Any, ...], error: type[Exception], message: str
) -> None:
    with pytest.raises(error) as raised:
        library.sphere(*inputs)
    assert message in str(raised.value)


def test_wrong_names_are_named(library: Library) -> None:
    with pytest.raises(TypeError, match="no input 'radius'; they are r, length"):
        library.sphere(R, radius=1)
    with pytest.raises(TypeError, match="input r is given twice"):
        library.sphere(R, r=R, length=1)
    with pytest.raises(TypeError, match="missing: r"):
        library.sphere(length=1)
    with pytest.raises(ValueError, match="no output 'X'; outputs= takes names out of C, C_q"):
        library.sphere(R, LENGTH, outputs=("C", "X"))


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: 1, TypeError, "out: got int, wanted a tuple of 2: C, C_q (None for an output"),
        (lambda: np.empty((2, 4)), TypeError, "out: got ndarray, wanted a tuple of 2"),
        (lambda: (np.empty(1),), TypeError, "out: got 1 entries, wanted a tuple of 2"),
        (lambda: ([0.0], None), TypeError, "out C: got list, wanted a NumPy array or None"),
        (lambda: (np.empty(2), None), ValueError, "out C: got shape (2,), wanted (1,)"),
        (lambda: (None, np.empty(4)), ValueError, "out C_q: got shape (4,), wanted (1, 4)"),
        (lambda: (np.empty(1, np.float32), None), TypeError, "out C: got dtype float32, wanted"),
        (lambda: (np.empty(1, ">f8"), None), TypeError, "out C: got dtype >f8, wanted float64"),
        (lambda: (np.empty(1, np.int64), None), TypeError, "out C: got dtype int64, wanted"),
        (
            lambda: (None, np.empty((1, 8))[:, ::2]),
            ValueError,
            "out C_q: wanted a C-contiguous, aligned array",
        ),
        (
            lambda: (np.frombuffer(bytearray(9), np.float64, offset=1), None),
            ValueError,
            "out C: wanted a C-contiguous, aligned array",
        ),
        (lambda: (read_only(np.empty(1)), None), ValueError, "out C: the array is read-only"),
    ],
)
def test_wrong_outputs_are_named(
    library: Library, make: Callable[[], Any], error: type[Exception], message: str
) -> None:
    for call in (library.sphere, library.sphere.bind):
        with pytest.raises(error) as raised:
            call(R, LENGTH, out=make())
        assert f"tiny.sphere: {message}" in str(raised.value)


def test_the_batch_axes_of_out_are_those_of_the_inputs(library: Library) -> None:
    r = np.ones((5, 3))
    with pytest.raises(ValueError, match=r"out C: got shape \(1,\), wanted \(5, 1\)"):
        library.sphere(r, LENGTH, out=(np.empty(1), None))
    with pytest.raises(ValueError, match=r"out C: got shape \(5, 1\), wanted \(1,\)"):
        library.sphere(R, LENGTH, out=(np.empty((5, 1)), None))


def test_outputs_that_share_memory_are_refused(library: Library) -> None:
    memory = np.empty(4)
    with pytest.raises(ValueError, match="out C and out C_q share memory"):
        library.sphere(R, LENGTH, out=(memory[:1], memory.reshape(1, 4)))


def test_what_a_target_gets_is_aligned_and_apart_from_what_it_writes(warm_package: Path) -> None:
    kernel = read_manifest(warm_package).kernels[0]
    signature = Signature("tiny.sphere", kernel.inputs, kernel.outputs)
    unaligned = np.frombuffer(b"x" + R.tobytes(), np.float64, offset=1)
    call, _ = signature.prepare((unaligned, LENGTH), None, (True, True))
    assert call.inputs[0].flags.aligned
    memory = np.array([1.0, 2.0, 3.0, 9.0])
    out = (None, memory.reshape(1, 4))
    call, results = signature.prepare((memory[1:], LENGTH), out, (True, True))
    assert not np.shares_memory(call.inputs[0], memory)
    assert call.inputs[1] is LENGTH  # what needs no copy is not copied
    assert results[0] is out[1]


#: Ways to spoil an array.
SPOILERS: list[Callable[[Any], Any]] = [
    lambda a: a.T,
    lambda a: a[..., ::2],
    lambda a: a[..., ::-1],
    lambda a: a[..., None],
    lambda a: a[:0],
    lambda a: np.broadcast_to(a, (2, *a.shape)),
    lambda a: a.astype(np.float32),
    lambda a: a.astype(">f8"),
    lambda a: a.astype(complex),
    lambda a: a.astype(object),
    lambda a: a.astype("U3"),
    lambda a: read_only(a.copy()),
    lambda a: a.astype(np.int64),
    lambda a: a.view(np.ma.MaskedArray),
    lambda a: a.tolist(),
    lambda a: a.tobytes(),
    lambda a: None,
    lambda a: {1: a},
    memoryview,
]


class Strange:
    """Draw arguments that are right, nearly right, or nonsense."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.batch = [(), (1,), (4,), (2, 3), (0,)][rng.integers(5)]

    def array(self, shape: tuple[int, ...]) -> Any:
        batch = self.batch if self.rng.random() < 0.7 else ()
        array: Any = np.ones((*batch, *shape))
        if self.rng.random() < 0.3:
            with suppress(IndexError, ValueError, TypeError):
                array = SPOILERS[self.rng.integers(len(SPOILERS))](array)
        return array

    def sequence(self, *shapes: tuple[int, ...]) -> list[Any]:
        chosen = shapes[: 2 if self.rng.random() < 0.95 else 1]
        return [self.array(shape) for shape in chosen]


def test_whatever_is_passed_a_call_computes_or_raises(
    library: Library, rng: np.random.Generator
) -> None:
    computed = 0
    for _ in range(3000):
        strange = Strange(rng)
        kernel = library.sphere
        inputs = strange.sequence((3,), ())
        lane = (kernel.lane_width,) if rng.random() < 0.2 else ()
        if lane:
            inputs = strange.sequence((1, 3, *lane), (1, *lane))
        out = tuple(strange.sequence((1,), (1, 4))) if rng.random() < 0.5 else None
        call: Any = kernel.lanes if lane else [kernel, kernel.bind][rng.integers(2)]
        try:
            results = call(*inputs, out=out, outputs=[None, ("C",), "C_q"][rng.integers(3)])
            results = results if isinstance(results, tuple) else results()
        except (TypeError, ValueError) as error:
            assert str(error).startswith("tiny.sphere: ")
        else:
            computed += 1
            assert all(np.isin(array, [0.0, 2.0, 3.0]).all() for array in results)
    assert 300 < computed < 2700
