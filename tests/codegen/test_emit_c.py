"""Emitted C: it compiles without a warning, and gives the bits that the NumPy text gives."""

from __future__ import annotations

import ctypes
import itertools
import shutil
import subprocess
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.emit import emit
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel, Package
from kousoku.runtime.importing import import_source
from tests.programs import STRICT

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from kousoku.model.numbers.real import Array
    from kousoku.runtime.toolchain import Toolchain

    Wanted = tuple[int, ...]

SIZES = (1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 24)
LANES = (1, 2, 4, 8)


def mixed() -> Kernel:
    """Build a kernel that no swap of two elements or two arrays leaves as it is."""
    graph = Graph()
    inputs = tuple(
        Quantity("gamma" if size == 2 else f"x_{size}", (size,) if size > 1 else (), "-", "some")
        for size in SIZES
    )
    outputs, results = [], []
    for q in inputs:
        row = [graph.input(q.name, k) for k in range(q.size)]
        shared = graph.mul(row[0], row[-1])
        factors = [graph.const(Fraction(k + 2, 7)) for k in range(q.size)]
        values = [graph.sub(graph.mul(f, x), shared) for f, x in zip(factors, row, strict=True)]
        if q.size > 4:
            values[1:4] = [graph.const(0), graph.const(Fraction(1, 3)), row[2]]
        outputs.append(Quantity(f"y_{q.size}", (q.size,), "-", "some more"))
        results.append(tuple(values))
    return Kernel(
        name="mixed",
        title="elements of many sizes",
        formula="y = k x / 7 − x_1 x_n",
        source="",
        inputs=inputs,
        outputs=tuple(outputs),
        nodes=tuple(graph.nodes),
        results=tuple(results),
    )


def called() -> Kernel:
    """Build a kernel with every operation that there is, and an input that nothing needs."""
    graph = Graph()
    x, y = graph.input("x", 0), graph.input("x", 1)
    length = graph.sqrt(graph.add(graph.mul(x, x), graph.mul(y, y)))
    angle = graph.atan2(y, x)
    around = (graph.sin(angle), graph.neg(graph.cos(graph.const(Fraction(1, 2)))), angle)
    decay = (graph.exp(graph.neg(graph.abs(y))), graph.log(length), graph.max(x, y))
    inverse = (graph.div(x, length), graph.div(graph.const(1), y), *decay)
    return Kernel(
        name="called",
        title="functions of the math library",
        formula="length = √(x² + y²)",
        source="nowhere",
        inputs=(
            Quantity("x", (2,), "m", "a point"),
            Quantity("unused", (3,), "m", "nothing"),
        ),
        outputs=(
            Quantity("length", (), "m", "distance of the point"),
            Quantity("around", (3,), "-", "sine, a number, angle"),
            Quantity("inverse", (5,), "-", "quotients, exponential, logarithm, maximum"),
        ),
        nodes=tuple(graph.nodes),
        results=((length,), around, inverse),
    )


PACKAGE = Package("mix", "kernels for a test", "kousoku generate mix", (mixed(), called()))
KERNELS = {kernel.name: kernel for kernel in PACKAGE.kernels}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Emitted folder."""
    path = tmp_path_factory.mktemp("mix")
    for name, text in emit(PACKAGE, {}).items():
        (path / name).write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def module(folder: Path) -> Any:
    """Emitted NumPy module."""
    files = {path.name: path.read_bytes() for path in folder.glob("*.py")}
    return import_source(folder, files, "kernels.py")


def build(
    compiler: Toolchain, folder: Path, extra: list[str], name: str = "mix.so"
) -> subprocess.CompletedProcess[str]:
    """Compile the folder with all warnings as errors."""
    sources = [str(folder / "kernels.c"), str(folder / "kernels_batch.c")]
    command = compiler.compile_command(sources, str(folder / name), [*STRICT, *extra])
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module", params=LANES)
def library(request: pytest.FixtureRequest, compiler: Toolchain, folder: Path) -> ctypes.CDLL:
    """Compiled library for each width of the lanes."""
    name = f"mix{request.param}.so"
    done = build(compiler, folder, [f"-DKOUSOKU_LANES={request.param}"], name)
    assert done.returncode == 0, done.stderr
    loaded = ctypes.CDLL(str(folder / name))
    loaded.kousoku_mix_lanes.restype = ctypes.c_size_t
    assert loaded.kousoku_mix_lanes() == request.param
    return loaded


def pointers(arrays: Sequence[Array | None]) -> Any:
    """Array of pointers; None is NULL."""
    addresses = [None if array is None else array.ctypes.data for array in arrays]
    return (ctypes.c_void_p * len(arrays))(*addresses)


def draw(rng: np.random.Generator, kernel: Kernel, n: int) -> list[Array]:
    """Random inputs with a batch axis."""
    return [rng.normal(size=(n, q.size)) for q in kernel.inputs]


def blank(kernel: Kernel, n: int, wanted: Wanted | None = None) -> list[Any]:
    """Outputs full of NaN, None where not wanted."""
    chosen = range(len(kernel.outputs)) if wanted is None else wanted
    return [
        np.full((n, q.size), np.nan) if k in chosen else None for k, q in enumerate(kernel.outputs)
    ]


def run_single(
    library: ctypes.CDLL,
    kernel: Kernel,
    inputs: Sequence[Array],
    outputs: Sequence[Array | None],
) -> None:
    """Evaluate row after row."""
    call = getattr(library, f"kousoku_mix_{kernel.name}_call")
    for k in range(len(inputs[0])):
        rows = [None if array is None else array[k] for array in outputs]
        call(pointers([array[k] for array in inputs]), pointers(rows))


def run_batch(
    library: ctypes.CDLL,
    kernel: Kernel,
    inputs: Sequence[Array],
    outputs: Sequence[Array | None],
    n: int,
) -> None:
    """Evaluate all rows at once; an input with one row is shared."""
    strides = [array.strides[0] // 8 if len(array) == n else 0 for array in inputs]
    getattr(library, f"kousoku_mix_{kernel.name}_batch")(
        ctypes.c_size_t(n),
        pointers(inputs),
        (ctypes.c_size_t * len(strides))(*strides),
        pointers(outputs),
    )


def bits(arrays: Sequence[Array | None]) -> list[bytes]:
    """Bytes to compare, with one NaN for all."""
    return [np.where(np.isnan(a), np.nan, a).tobytes() for a in arrays if a is not None]


def numpy_results(
    module: Any, kernel: Kernel, inputs: Sequence[Array], wanted: Wanted | None = None
) -> list[Array]:
    """Results of the NumPy text, flat for each evaluation."""
    shaped = [a.reshape(len(a), *q.shape) for a, q in zip(inputs, kernel.inputs, strict=True)]
    chosen = range(len(kernel.outputs)) if wanted is None else wanted
    names = [kernel.outputs[k].name for k in chosen]
    results = getattr(module, kernel.name)(*shaped, outputs=names)
    return [np.ascontiguousarray(a).reshape(len(inputs[0]), -1) for a in results]


def test_single_calls_give_the_bits_of_numpy(
    library: ctypes.CDLL, module: Any, rng: np.random.Generator
) -> None:
    inputs = draw(rng, KERNELS["mixed"], 20)
    outputs = blank(KERNELS["mixed"], 20)
    run_single(library, KERNELS["mixed"], inputs, outputs)
    assert bits(outputs) == bits(numpy_results(module, KERNELS["mixed"], inputs))


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("n", [0, 1, 2, 3, 4, 5, 7, 8, 9, 16, 17, 1000])
def test_batches_give_the_bits_of_single_calls(
    library: ctypes.CDLL, rng: np.random.Generator, name: str, n: int
) -> None:
    kernel = KERNELS[name]
    inputs, single, batch = draw(rng, kernel, n), blank(kernel, n), blank(kernel, n)
    run_single(library, kernel, inputs, single)
    run_batch(library, kernel, inputs, batch, n)
    assert bits(batch) == bits(single)


@pytest.mark.parametrize("name", KERNELS)
def test_lanes_give_the_bits_of_single_calls(
    library: ctypes.CDLL, rng: np.random.Generator, name: str
) -> None:
    kernel, width = KERNELS[name], library.kousoku_mix_lanes()
    n = 5 * width
    inputs, single = draw(rng, kernel, n), blank(kernel, n)
    run_single(library, kernel, inputs, single)

    def packed(array: Any) -> Array:
        return np.ascontiguousarray(array.reshape(5, width, -1).swapaxes(1, 2))

    blocks, out = [packed(array) for array in inputs], [packed(array) for array in single]
    for array in out:
        array.fill(np.nan)
    getattr(library, f"kousoku_mix_{name}_lanes")(
        ctypes.c_size_t(5), pointers(blocks), pointers(out)
    )
    assert bits(out) == bits([packed(array) for array in single])


@pytest.mark.parametrize("gap", [0, 1, 5])
def test_inputs_may_be_shared_or_lie_apart(
    library: ctypes.CDLL, rng: np.random.Generator, gap: int
) -> None:
    kernel, n = KERNELS["mixed"], 19
    whole = [rng.normal(size=(n, q.size + gap)) for q in kernel.inputs]
    inputs = [array[:, : q.size] for array, q in zip(whole, kernel.inputs, strict=True)]
    for k in range(0, len(inputs), 2):
        inputs[k] = inputs[k][:1]
    full = [np.repeat(array, n, axis=0) if len(array) == 1 else array for array in inputs]
    single, batch = blank(kernel, n), blank(kernel, n)
    run_single(library, kernel, full, single)
    run_batch(library, kernel, inputs, batch, n)
    assert bits(batch) == bits(single)


@pytest.mark.parametrize(
    "wanted", [w for r in range(4) for w in itertools.combinations(range(3), r)]
)
def test_every_choice_of_outputs_gives_the_same_bits(
    library: ctypes.CDLL, module: Any, rng: np.random.Generator, wanted: Wanted
) -> None:
    kernel, n = KERNELS["called"], 11
    inputs, whole = draw(rng, kernel, n), blank(kernel, n)
    run_batch(library, kernel, inputs, whole, n)
    chosen = [whole[k] for k in wanted]
    ways: tuple[Callable[..., None], ...] = (run_single, partial(run_batch, n=n))
    for evaluate in ways:
        outputs = blank(kernel, n, wanted)
        evaluate(library, kernel, inputs, outputs)
        assert bits(outputs) == bits(chosen)
    results = numpy_results(module, kernel, inputs, wanted)
    for array, result in zip(chosen, results, strict=True):
        np.testing.assert_allclose(result, array, rtol=1e-15, atol=1e-16)


def test_infinite_subnormal_and_signed_zero_inputs_agree_bit_for_bit(
    library: ctypes.CDLL, module: Any
) -> None:
    kernel = KERNELS["mixed"]
    hard = np.array([0.0, -0.0, 5e-324, -1e-310, np.inf, -np.inf, np.nan, 1e308, -1e308, 1.5, -3.0])
    inputs = [np.resize(np.roll(hard, 3 * k), (23, q.size)) for k, q in enumerate(kernel.inputs)]
    single, batch = blank(kernel, 23), blank(kernel, 23)
    run_single(library, kernel, inputs, single)
    run_batch(library, kernel, inputs, batch, 23)
    assert bits(batch) == bits(single) == bits(numpy_results(module, kernel, inputs))


def test_the_library_tells_its_signature(library: ctypes.CDLL) -> None:
    for kernel in PACKAGE.kernels:
        signature = library[f"kousoku_mix_{kernel.name}_signature"]
        signature.restype = ctypes.c_char_p
        inputs = [f"{q.name}[{q.size}]" for q in kernel.inputs]
        outputs = [f"{q.name}[{q.size}]" for q in kernel.outputs]
        assert signature().decode() == " ".join([*inputs, "->", *outputs])


@pytest.mark.parametrize(
    "flag", ["-ffast-math", "-fassociative-math -fno-signed-zeros -fno-trapping-math"]
)
def test_a_build_with_unsafe_mathematics_is_refused(
    compiler: Toolchain, folder: Path, flag: str
) -> None:
    done = build(compiler, folder, flag.split(), "fast.so")
    assert done.returncode != 0
    assert "verified numbers need IEEE arithmetic" in done.stderr


def test_the_header_compiles_as_cpp(compiler: Toolchain, folder: Path) -> None:
    cpp = shutil.which("c++")
    if cpp is None:
        pytest.skip("no C++ compiler")
    (folder / "main.cpp").write_text('#include "kernels.h"\nint main() { return 0; }\n')
    command = [cpp, "-std=c++11", "-Wall", "-Wpedantic", "-Werror", "-fsyntax-only", "main.cpp"]
    subprocess.run(command, cwd=folder, check=True)


MAIN = """
#include "kernels.h"
#include <stdio.h>
#include <stdlib.h>

/* arrays of exactly the size that is allowed, so that the sanitizer sees one step too far */
static double *numbers(size_t count)
{
    double *x = malloc(count ? count * sizeof *x : 1);
    for (size_t k = 0; k < count; ++k) x[k] = (double)(k % 17) * 0.25 - 2.0;
    return x;
}

int main(void)
{
    static const size_t size_in[] = {SIZES_IN}, size_out[] = {SIZES_OUT};
    for (size_t n = 0; n < 20; ++n) {
        for (size_t only = 0; only <= N_OUT; ++only) {
            for (size_t shared = 0; shared < 2; ++shared) {
                double *in[N_IN], *out[N_OUT];
                size_t stride[N_IN];
                for (size_t k = 0; k < N_IN; ++k) {
                    const size_t size = size_in[k];
                    stride[k] = shared && k % 2 ? 0 : size;
                    in[k] = numbers(stride[k] ? n * size : size);
                }
                for (size_t k = 0; k < N_OUT; ++k) {
                    out[k] = only == N_OUT || only == k ? numbers(n * size_out[k]) : NULL;
                }
                BATCH(n, (const double *const *)in, stride, out);
                for (size_t k = 0; k < N_IN; ++k) free(in[k]);
                for (size_t k = 0; k < N_OUT; ++k) free(out[k]);
            }
        }
    }
    return 0;
}
"""


@pytest.mark.release
@pytest.mark.parametrize(("name", "lanes"), [("mixed", 8), ("called", 4)])
def test_batches_stay_in_bounds_and_have_no_undefined_behaviour(
    compiler: Toolchain, folder: Path, lanes: int, name: str
) -> None:
    kernel = KERNELS[name]
    (folder / "main.c").write_text(MAIN)
    prefix = f"kousoku_mix_{name}"
    program = folder / f"sanitized_{name}_{lanes}"
    command = [
        *compiler.command,
        *(flag for flag in compiler.flags if flag != "-O3"),
        *("-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"),
        "-Dalways_inline=noinline",  # gcc takes 20 s for checks in each of the copies
        *(f"-DKOUSOKU_LANES={lanes}", f"-DN_IN={len(kernel.inputs)}"),
        *(f"-DN_OUT={len(kernel.outputs)}", f"-DBATCH={prefix}_batch"),
        f"-DSIZES_IN={','.join(str(q.size) for q in kernel.inputs)}",
        f"-DSIZES_OUT={','.join(str(q.size) for q in kernel.outputs)}",
        *("main.c", "kernels.c", "kernels_batch.c", "-lm", "-o", str(program)),
    ]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if "sanitize" in done.stderr:
        pytest.skip("this compiler has no sanitizers")
    assert done.returncode == 0, done.stderr
    subprocess.run([program], check=True)
