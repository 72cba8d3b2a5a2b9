"""Single calls in a loop: each program in its own compilation units, all with the same flags."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kousoku.runtime.library import LANES
from kousoku.runtime.toolchain import find_toolchain
from tests.benchmarks.kernel_peers import casadi_source, symforce_header, sympy_source
from tests.benchmarks.kit import PeerMissingError, end_group, required
from tests.benchmarks.p2 import SIZES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    import numpy as np

_STEPS = [f"in[{k}] + {size} * i" for k, size in enumerate(SIZES.values())]
_OUT = ["out[0] + 2 * i", "out[1] + 24 * i"]
_LOOP = """
void loop(size_t n, const double *const *in, double *const *out)
{
    for (size_t i = 0; i < n; ++i) {
        BODY
    }
}
"""
INCLUDES = ("/usr/include", "/usr/local/include", "/opt/homebrew/include", "/opt/local/include")


class CallLoop:
    """n single calls of one program.

    Parameters
    ----------
    library : Path
        Exports ``loop``.
    """

    def __init__(self, library: Path) -> None:
        self._loop = ctypes.CDLL(str(library)).loop
        self._loop.restype = None

    def bind(
        self, inputs: Sequence[np.ndarray], outputs: Sequence[np.ndarray]
    ) -> Callable[[], None]:
        """Function without arguments that evaluates all rows."""
        n = ctypes.c_size_t(len(inputs[0]))
        return _Bound(self._loop, (n, _pointers(inputs), _pointers(outputs)), (inputs, outputs))


def kousoku_loop(folder: Path, package: Path) -> CallLoop:
    """Build the loop over the emitted C."""
    text = '#include "kernels.h"\n' + _LOOP.replace(
        "BODY", f"kousoku_p2_constraint_z({', '.join([*_STEPS, *_OUT])});"
    )
    return _build(folder / "kousoku_loop.c", text, [package / "kernels.c"], [f"-I{package}"])


def casadi_loop(folder: Path, *, cse: bool) -> CallLoop:
    """Build the loop over CasADi's C; its matrices are column-major."""
    source = casadi_source(folder, cse=cse)
    call = (
        f"const double *arguments[] = {{{', '.join(_STEPS)}}};\n"
        f"        double *results[] = {{{', '.join(_OUT)}}};\n"
        f"        {source.stem}(arguments, results, 0, 0, 0);"
    )
    text = f'#include <stddef.h>\n#include "{source.stem}.h"\n' + _LOOP.replace("BODY", call)
    return _build(folder / f"{source.stem}_loop.c", text, [source], [])


def sympy_loop(folder: Path, *, cse: bool) -> CallLoop:
    """Build the loop over the C of SymPy's code generation, whose arguments are not const."""
    source = sympy_source(folder, cse=cse)
    steps = [f"(double *)({step})" for step in _STEPS]
    text = f'#include <stddef.h>\n#include "{source.stem}.h"\n' + _LOOP.replace(
        "BODY", f"{source.stem}({', '.join([*steps, *_OUT])});"
    )
    return _build(folder / f"{source.stem}_loop.c", text, [source], [])


def symforce_loop(folder: Path) -> CallLoop:
    """Build the loop over SymForce's C++; its matrices are column-major.

    Raises
    ------
    PeerMissingError
        SymForce, Eigen or a C++ compiler is not there.
    """
    header = symforce_header(folder)
    headers = eigen()
    types = [f"Eigen::Matrix<double, {size}, 1>" for size in SIZES.values()]
    parameters = [f"const {kind} &{name}" for kind, name in zip(types, SIZES, strict=True)]
    declaration = (
        f"void symforce_once({', '.join(parameters)}, "
        "Eigen::Matrix<double, 2, 1> *C, Eigen::Matrix<double, 2, 12> *C_q)"
    )
    unit = folder / "symforce_once.cpp"
    unit.write_text(
        f'#include "{header.name}"\n{declaration}\n'
        f"{{\n    sym::SymforceP2<double>({', '.join(SIZES)}, C, C_q);\n}}\n"
    )
    steps = [
        f"*reinterpret_cast<const {kind} *>({step})"
        for kind, step in zip(types, _STEPS, strict=True)
    ]
    call = (
        f"symforce_once({', '.join(steps)}, "
        f"reinterpret_cast<Eigen::Matrix<double, 2, 1> *>({_OUT[0]}), "
        f"reinterpret_cast<Eigen::Matrix<double, 2, 12> *>({_OUT[1]}));"
    )
    text = (
        f"#include <Eigen/Core>\n#include <cstddef>\nusing std::size_t;\n{declaration};\n"
        'extern "C"' + _LOOP.replace("BODY", call)
    )
    return _build(folder / "symforce_loop.cpp", text, [unit], [f"-I{headers}"])


class Batch:
    """The emitted batch entry points, built with the same flags.

    Parameters
    ----------
    folder, package : Path
        Where to build, and the generated folder.
    """

    def __init__(self, folder: Path, package: Path) -> None:
        library = folder / "batch.so"
        sources = [str(package / name) for name in ("kernels.c", "kernels_batch.c")]
        include = f"-I{LANES.parent}"
        command = find_toolchain().compile_command(sources, str(library), [include])
        subprocess.run(command, check=True)
        exported = ctypes.CDLL(str(library))
        exported.kousoku_p2_lanes.restype = ctypes.c_size_t
        self.width = int(exported.kousoku_p2_lanes())
        self._rows = exported.kousoku_p2_constraint_z_batch
        self._lanes = exported.kousoku_p2_constraint_z_lanes

    def rows(
        self, inputs: Sequence[np.ndarray], outputs: Sequence[np.ndarray]
    ) -> Callable[[], None]:
        """Function that evaluates arrays with the batch axis first."""
        strides = (ctypes.c_size_t * len(inputs))(*SIZES.values())
        n = ctypes.c_size_t(len(inputs[0]))
        arguments = (n, _pointers(inputs), strides, _pointers(outputs))
        return _Bound(self._rows, arguments, (inputs, outputs))

    def lanes(
        self, inputs: Sequence[np.ndarray], outputs: Sequence[np.ndarray]
    ) -> Callable[[], None]:
        """Function that evaluates arrays laid out [block][element][lane]."""
        n_blocks = ctypes.c_size_t(len(inputs[0]))
        arguments = (n_blocks, _pointers(inputs), _pointers(outputs))
        return _Bound(self._lanes, arguments, (inputs, outputs))


@dataclass(frozen=True, slots=True)
class _Bound:
    """A call with its arguments, and the arrays that these point into."""

    function: Callable[..., object]
    arguments: tuple[object, ...]
    arrays: tuple[Sequence[np.ndarray], ...]

    def __call__(self) -> None:
        self.function(*self.arguments)


def _pointers(arrays: Sequence[np.ndarray]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))


def _build(loop: Path, text: str, sources: Sequence[Path], extra: Sequence[str]) -> CallLoop:
    """Compile the loop and the program, each a unit of its own, into one library."""
    loop.write_text(text)
    library = loop.with_suffix(".so")
    toolchain = find_toolchain()
    files = [str(path) for path in (loop, *sources)]
    command = list(toolchain.compile_command(files, str(library), [f"-I{loop.parent}", *extra]))
    if loop.suffix == ".cpp":
        command[: len(toolchain.command)] = cpp_compiler(toolchain.command)
        command[command.index("-std=c99")] = "-std=c++17"
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise PeerMissingError(f"{loop.name} does not compile:\n{done.stderr}")
    return CallLoop(library)


@contextmanager
def started(command: Sequence[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Give a process that is ended in the end, with all processes that it started."""
    pipe = subprocess.PIPE
    process = subprocess.Popen(
        command, stdout=pipe, stderr=pipe, text=True, start_new_session=True, **options
    )
    try:
        yield process
    finally:
        end_group(process)


def eigen() -> Path:
    """Headers of Eigen: the system's, or those that CasADi brings.

    Raises
    ------
    PeerMissingError
        There are none.
    """
    places = [Path(base) for base in INCLUDES]
    with suppress(PeerMissingError):
        places.append(Path(required("casadi").__file__).parent / "include")
    for place in places:
        if (place / "eigen3" / "Eigen").is_dir():
            return place / "eigen3"
    raise PeerMissingError("headers of Eigen are missing; apt-get install libeigen3-dev")


def cpp_compiler(command: Sequence[str]) -> list[str]:
    """C++ compiler that goes with a C compiler."""
    *before, last = command
    name = Path(last).name
    for c, cpp in (("clang", "clang++"), ("gcc", "g++"), ("cc", "c++")):
        if c in name:
            other = str(Path(last).with_name(name.replace(c, cpp)))
            found = other if before else shutil.which(other)
            if found:
                return [*before, found]
    raise PeerMissingError(f"no C++ compiler beside {' '.join(command)}; SymForce's code is C++")
