"""The segments of a solver, alone and counted: what an evaluation is made of.

The solver's own source is compiled a second time, with a counter at each call of a segment and with
loops that run one segment again and again. In a loop each call waits for a number of the one
before, as the stages of a step do; else a processor would do several at once.
"""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.generate import compose_scene
from kousoku.codegen.dynamics.recording.counts import counts
from kousoku.runtime.dynamics_targets import CompiledSolver
from kousoku.runtime.toolchain import EXTENSION, find_toolchain
from tests.benchmarks.kit import seconds_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.mechanism import Mechanism
    from kousoku.runtime.dynamics import DynamicsSolver

#: The segments that steps run, with a number of the workspace that each reads and one that it
#: writes.
SEGMENTS = {
    "geometry": ("W_Q", "NC ? W_PIVOTS + NC - 1 : W_SCRATCH"),
    "position": ("NC ? W_C : W_SCRATCH", "W_DQ"),
    "move": ("W_DQ", "W_Q_MOVED"),
    "velocity": ("W_V", "W_DV"),
    "acceleration": ("W_V", "W_V_DOT"),
    "refinement": ("W_V_DOT", "W_DV"),
    "switching": ("W_Q", "W_SWITCHES"),
    "measure": ("W_Q", "W_MEASURES"),
    "energy": ("W_Q", "W_ENERGIES"),
    "check": ("W_V", "W_C_DOT"),
}
#: Which part of an evaluation they are; what is left over is the integrator.
PARTS = {
    "projection": ("geometry", "position", "move", "velocity"),
    "equations": ("acceleration", "refinement"),
    "others": ("switching", "measure", "energy", "check"),
}
#: Kinds of tasks that factorise, in the geometry.
FACTORISES = ("eliminate", "couple")
#: How often a loop runs its segment in its trial, and how long it is then [s].
FEW, LONG = 10, 2e-3
END_OF_SOURCE = '#include "integrate/integrate.h"'

_COUNTED = "#define {name}(w) (++counted[{k}], {name}(w))"
_ALONE = """
void alone_{name}(size_t rounds, double *w);
void alone_{name}(size_t rounds, double *w)
{{
    const size_t in = {reads}, out = {writes};
    const double x = w[in];
    for (size_t k = 0; k < rounds; ++k) {{
        ({name})(w);
        w[in] = x + 0.0 * w[out];
        KEEP
    }}
    w[in] = x;
}}
"""
#: The segments that a scene lacks are functions before any of them is a macro.
_LACKING = '#include <string.h>\n#include "integrate/lacking.h"'
#: Nothing of a segment is left out of its loop because its inputs are the same as before.
_KEEP = """
#ifdef __GNUC__
#define KEEP __asm__ volatile("" ::: "memory");
#else
#define KEEP
#endif
"""
_PREPARE = """
void alone_begin(double t, const double *y, const double *parameters, double *w);
void alone_begin(double t, const double *y, const double *parameters, double *w)
{
    prepare(parameters, w);
    place(t, y, w);
    (geometry)(w);
    (position)(w);
    (move)(w);
    (velocity)(w);
    (acceleration)(w);
}
"""


@dataclass(frozen=True, slots=True)
class Segments:
    """A solver whose segments are counted, and run alone.

    Parameters
    ----------
    solver : DynamicsSolver
        It counts.
    library : ctypes.CDLL
        What it is compiled to.
    """

    solver: DynamicsSolver
    library: ctypes.CDLL

    @classmethod
    def of(cls, solver: DynamicsSolver, folder: Path) -> Segments:
        """Compile the source of a solver into a folder, with counters and loops."""
        for name, data in solver.target.sources.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
        source, library = folder / "segments.c", folder / f"segments{EXTENSION}"
        text = (folder / "solver.c").read_text(encoding="utf-8")
        source.write_text(instrumented(text), encoding="utf-8")
        command = find_toolchain().compile_command([str(source)], str(library), (f"-I{folder}",))
        subprocess.run(command, check=True, capture_output=True)
        loaded = ctypes.CDLL(str(library))
        target = CompiledSolver(loaded, solver.target.sources)
        return cls(replace(solver, target=target), loaded)

    def counted(self) -> dict[str, int]:
        """Number of runs of each segment since this was asked last."""
        array = (ctypes.c_size_t * len(SEGMENTS)).in_dll(self.library, "counted")
        found = dict(zip(SEGMENTS, array, strict=True))
        for k in range(len(SEGMENTS)):
            array[k] = 0
        return found

    def alone(self, name: str, time: float, y: np.ndarray, parameters: np.ndarray) -> SegmentLoop:
        """Loop over a segment at a state, some milliseconds long."""
        work = np.zeros(self.solver.target.work_size)
        addresses = [ctypes.c_void_p(array.ctypes.data) for array in (y, parameters, work)]
        self.library.alone_begin(ctypes.c_double(time), *addresses)
        function = self.library[f"alone_{name}"]
        function.restype = None
        loop = SegmentLoop(function, work, FEW)
        about = min(seconds_of(loop) for _ in range(3)) / FEW
        return replace(loop, rounds=max(FEW, int(LONG / about)))


@dataclass(frozen=True, slots=True)
class SegmentLoop:
    """A segment, again and again.

    Parameters
    ----------
    function : callable
        Runs it so often on a workspace.
    work : array
        The workspace.
    rounds : int
        How often.
    """

    function: Callable[..., object]
    work: np.ndarray
    rounds: int

    def __call__(self) -> None:
        """Run it so often."""
        self.function(ctypes.c_size_t(self.rounds), ctypes.c_void_p(self.work.ctypes.data))


def instrumented(source: str) -> str:
    """Source of a solver with counters and loops.

    Raises
    ------
    ValueError
        It does not end as a solver's source does.
    """
    text, found, rest = source.partition(END_OF_SOURCE)
    if not found or rest.strip():
        raise ValueError(f"a solver's source ends with {END_OF_SOURCE}")
    names = enumerate(SEGMENTS)
    counters = [_COUNTED.format(name=name, k=k) for k, name in names]
    loops = [
        _ALONE.format(name=name, reads=reads, writes=writes)
        for name, (reads, writes) in SEGMENTS.items()
    ]
    head = f"size_t counted[{len(SEGMENTS)}];{_KEEP}"
    return "\n".join([text, _LACKING, head, *counters, found, _PREPARE, *loops])


def share_of_factors(mechanism: Mechanism) -> float:
    """Part of the operations of the geometry that factorises C_q M⁻¹ C_qᵀ."""
    program = compose_scene(mechanism.scene, mechanism.outputs).program
    own = [one for one in counts(program) if one.segment == "geometry"]
    factors = sum(one.operations for one in own if one.title.startswith(FACTORISES))
    return factors / max(1, sum(one.operations for one in own))


def seconds_of_parts(
    calls: dict[str, float], alone: dict[str, float], share: float, whole: float
) -> dict[str, float]:
    """Seconds of each part of an evaluation.

    Parameters
    ----------
    calls : dict of float
        How often an evaluation runs each segment.
    alone : dict of float [s]
        What each of them takes alone.
    share : float
        The part of the geometry that factorises.
    whole : float [s]
        What an evaluation takes in a run: what no segment takes is the integrator's.
    """
    own = {name: calls[name] * alone[name] for name in SEGMENTS if calls[name]}
    found = {part: sum(own.get(name, 0.0) for name in names) for part, names in PARTS.items()}
    factors = share * own.get("geometry", 0.0)
    found["projection"] -= factors
    return {"factorisation": factors, **found, "integrator": whole - sum(found.values()) - factors}
