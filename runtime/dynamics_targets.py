"""Targets that compute the motion of a scene: the compiled solver, or the one in NumPy."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, get_type_hints

from kousoku.runtime.choice import choose
from kousoku.runtime.integrate.settings import Settings
from kousoku.runtime.notice import say_once

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.choice import ChosenTarget, Target
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.scene_solver import SceneSolver
    from kousoku.runtime.sources import Sources

#: The files of a scene's folder.
C_SOURCE, NUMPY_SOURCE = "solver.c", "solver.py"
#: Scenes with more coordinates than three bodies have are slow.
SLOW = 21

Opened = TypeVar("Opened")


@dataclass(frozen=True, slots=True)
class Memory:
    """Memory that the caller owns.

    Parameters
    ----------
    state : array
        Numbers that last from call to call.
    work : array
        Memory for work.
    """

    state: Array
    work: Array


class SolverTarget(Protocol):
    """The functions of ``solver.h`` on arrays; the caller owns all of them.

    Parameters
    ----------
    name : {"c", "numpy"}
        Target that computes.
    state_size, work_size, row_size : int
        Counts of numbers in a state, in the memory for work, and in a row of results.
    sources : Sources
        The generated files.
    """

    name: str
    sources: Sources
    state_size: int
    work_size: int
    row_size: int

    def starter(
        self, time: float, q: Array, v: Array, parameters: Array, memory: Memory
    ) -> Callable[[], int]:
        """Start of a run: takes a position and velocity, and projects them onto the constraints.

        Each call takes the arrays as they are then: they are looked up once, calls cost little.

        Parameters
        ----------
        time : float [s]
            Where the motion begins.
        q, v : (nq,), (nv,) array
            Coordinates and velocities, in SI units.
        parameters : (n,) array
            In the order of the scene and in their units.
        memory : Memory
            State and scratch.
        """

    def runner(
        self, settings: Settings, times: Array, memory: Memory
    ) -> Callable[[int, Array], int]:
        """Runner: moves on by at most some steps, and writes as many rows as there are.

        Times (n,) [s] ascend; rows (m, row_size) are in SI units.
        """

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at a state as it is; it is left in the work (work_size,).

        Arguments as of :meth:`starter`, the time in [s].
        """

    def residuals(self, memory: Memory, out: Array) -> None:
        """Write C(q) to ``out`` (nc,) [m, rad] where it was evaluated last."""

    def pivots(self, memory: Memory, out: Array) -> int:
        """Write D (nc,) [1/kg] of C_q M⁻¹C_qᵀ = L D Lᵀ at the state, of angles at the length."""


#: The types of C for those of Python.
_TYPES: dict[type, type[ctypes.c_double | ctypes.c_int]] = {
    float: ctypes.c_double,
    int: ctypes.c_int,
}


#: Empty type, to take the address of an array.
_NOTHING = ctypes.c_char * 0


class _Settings(ctypes.Structure):
    """The record ``settings`` of ``solver.h``, field by field as in Python."""

    _fields_ = tuple((name, _TYPES[kind]) for name, kind in get_type_hints(Settings).items())


def exported(library: ctypes.CDLL, sources: Sources, name: str, result: Any = ctypes.c_int) -> Any:
    """Function that the compiled solver of a scene exports, and what it returns."""
    function = library[f"kousoku_{sources.manifest.package}_{name}"]
    function.restype = result
    return function


class CompiledSolver:
    """The compiled solver of a scene of bodies.

    Parameters
    ----------
    library : ctypes.CDLL
        The loaded library.
    sources : Sources
        Its sources.
    """

    name = "c"

    def __init__(self, library: ctypes.CDLL, sources: Sources) -> None:
        self._function = partial(exported, library, sources)
        self.sources = sources
        self.state_size, self.work_size, self.row_size = (
            self._function(f"{part}_size", ctypes.c_size_t)() for part in ("state", "work", "row")
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return open_same, (self.sources, self.name)

    def starter(
        self, time: float, q: Array, v: Array, parameters: Array, memory: Memory
    ) -> Callable[[], int]:
        """Start of a run: takes q (nq,) and v (nv,), SI units, as they are then; projects them."""
        arrays = map(_address, (q, v, parameters, memory.state, memory.work))
        return partial(self._function("start"), ctypes.c_double(time), *arrays)

    def runner(
        self, settings: Settings, times: Array, memory: Memory
    ) -> Callable[[int, Array], int]:
        """Runner to times (n,) [s]: at most some steps, and rows (m, row_size), a call."""
        steps, count, place = ctypes.c_size_t(), ctypes.c_size_t(), ctypes.c_void_p()
        call = partial(
            self._function("run"),
            ctypes.byref(_Settings(*settings)),
            _address(times),
            *(ctypes.c_size_t(len(times)), steps, count),
            *(_address(memory.state), _address(memory.work), place),
            ctypes.byref(ctypes.c_size_t()),
        )

        def run(max_steps: int, rows: Any) -> int:
            steps.value, count.value = max_steps, len(rows)
            place.value = ctypes.addressof(_NOTHING.from_buffer(rows))  # less than rows.ctypes
            return int(call())

        return run

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at q (nq,) and v (nv,), in SI units; the work has it."""
        arrays = map(_address, (q, v, parameters, work))
        return int(self._function("evaluate")(ctypes.c_double(time), *arrays))

    def residuals(self, memory: Memory, out: Array) -> None:
        """Write C(q) to ``out`` (nc,) [m, rad] where it was evaluated last."""
        self._function("residuals", None)(_address(memory.work), _address(out))

    def pivots(self, memory: Memory, out: Array) -> int:
        """Write D (nc,) [1/kg] of C_q M⁻¹C_qᵀ = L D Lᵀ at the state, of angles at the length."""
        arrays = map(_address, (memory.state, memory.work, out))
        return int(self._function("pivots")(*arrays))


def _address(array: Array) -> ctypes.c_void_p:
    """Pointer that keeps its array alive."""
    return array.ctypes.data_as(ctypes.c_void_p)


class NumpySolver:
    """Solver of ``solver.py``, with the methods of :class:`CompiledSolver`.

    Parameters
    ----------
    solver : SceneSolver
        Solver of the imported ``solver.py``, with the integrator of its folder.
    """

    name = "numpy"

    def __init__(self, solver: SceneSolver, sources: Sources) -> None:
        self.solver = solver
        self.sources = sources
        self.state_size = solver.scene.state_size
        self.work_size = solver.scene.work_size
        self.row_size = solver.scene.row_size

    def __reduce__(self) -> tuple[Any, ...]:
        return open_same, (self.sources, self.name)

    def starter(
        self, time: float, q: Array, v: Array, parameters: Array, memory: Memory
    ) -> Callable[[], int]:
        """Start of a run: takes q (nq,) and v (nv,), in SI units, and projects them."""
        return partial(self.solver.start, time, q, v, parameters, memory.state, memory.work)

    def runner(
        self, settings: Settings, times: Array, memory: Memory
    ) -> Callable[[int, Array], int]:
        """Runner to times (n,) [s]: at most some steps, and rows (m, row_size), a call."""
        return lambda max_steps, rows: self.run(settings, times, max_steps, memory, rows)

    def run(
        self, settings: Settings, times: Array, max_steps: int, memory: Memory, rows: Array
    ) -> int:
        """Move on to times (n,) [s], and write rows (m, row_size), in SI units.

        An interrupt can come anywhere: what the call had done is undone then, so that the state
        is one from which a run goes on.
        """
        before = memory.state.copy()
        arguments = (settings, times, max_steps, memory.state, memory.work, rows)
        try:
            status, _ = self.solver.run(*arguments)
        except BaseException:
            memory.state[:] = before
            raise
        return int(status)

    def evaluate(self, time: float, q: Array, v: Array, parameters: Array, work: Array) -> int:
        """Compute all that the scene has at q (nq,) and v (nv,), in SI units; the work has it."""
        return int(self.solver.evaluate(time, q, v, parameters, work))

    def residuals(self, memory: Memory, out: Array) -> None:
        """Write C(q) to ``out`` (nc,) [m, rad] where it was evaluated last."""
        self.solver.residuals(memory.work, out)

    def pivots(self, memory: Memory, out: Array) -> int:
        """Write D (nc,) [1/kg] of C_q M⁻¹C_qᵀ = L D Lᵀ at the state, of angles at the length."""
        return int(self.solver.pivots(memory.state, memory.work, out))


def open_target(sources: Sources, target: Target) -> SolverTarget:
    """Solver of a scene of bodies for a target, see :func:`open_either`."""
    in_c: Callable[[ctypes.CDLL, Sources], SolverTarget] = CompiledSolver
    return open_either(sources, target, in_c, load_numpy)


def load_numpy(sources: Sources, reason: Exception | None = None) -> NumpySolver:
    """Load the solver in NumPy, and say in one line what it costs.

    Parameters
    ----------
    sources : Sources
        The files of the scene's folder.
    reason : Exception, optional
        Why there is no compiled solver.

    Raises
    ------
    LoadError
        The module is not the manifest's.
    """
    solver: SceneSolver = sources.module(NUMPY_SOURCE).SOLVER
    is_slow = solver.scene.nq > SLOW
    if reason is not None:
        cost = ", which takes 100 to 200 times as long" if is_slow else ""
        say_once(f"kousoku uses the NumPy solver{cost}: {reason}")
    elif is_slow:
        say_once(
            f"{sources.folder.name}: the NumPy solver takes 100 to 200 times as long as the"
            " compiled one"
        )
    return NumpySolver(solver, sources)


def open_either(
    sources: Sources,
    target: Target,
    in_c: Callable[[ctypes.CDLL, Sources], Opened],
    in_numpy: Callable[[Sources, Exception | None], Opened],
) -> Opened:
    """Solver of a scene for a target.

    Parameters
    ----------
    sources : Sources
        The files of the folder.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler and a cache can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.
    in_c : callable
        Makes it of the compiled library.
    in_numpy : callable
        Makes it of ``solver.py``, given the reason if C was tried first.

    Raises
    ------
    TargetError
        The folder was generated without this target.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: the library cannot be kept.
    """

    def compiled_here() -> Opened:
        from kousoku.runtime.library import compiled
        from kousoku.runtime.toolchain import find_toolchain

        library, _ = compiled(sources, find_toolchain())
        return in_c(library, sources)

    numpy = (NUMPY_SOURCE, lambda reason: in_numpy(sources, reason))
    return choose(target, sources, (C_SOURCE, compiled_here), numpy)


def open_same(sources: Sources, target: ChosenTarget) -> SolverTarget:
    """Open the target that another process had, see :func:`on_this_machine`."""
    return open_target(*on_this_machine(sources, target))


def on_this_machine(sources: Sources, target: ChosenTarget) -> tuple[Sources, Target]:
    """Files and target of another process as they can be had here: NumPy where is no compiler."""
    return sources.placed(), target if target == "numpy" else "auto"
