"""The mechanism: a scene with its solver, which moves."""

from __future__ import annotations

import warnings
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast, overload

from kousoku.model.errors import MotionError, SolveError
from kousoku.model.text import counted
from kousoku.runtime.integrate.result import Coordinates
from kousoku.runtime.messages import listed
from kousoku.runtime.run import Interrupted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from typing import Literal, Unpack

    import numpy.typing as npt
    from matplotlib.figure import Figure

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.result import Result
    from kousoku.runtime.options import RunOptions
    from kousoku.runtime.run import Run
    from kousoku.runtime.saved import SavedRun
    from kousoku.runtime.solver import Solver
    from kousoku.state_matrices import Evaluation, Matrices


class _Files(dict[str, str]):
    """Texts of files by name, which a page or a terminal is not filled with."""

    def __repr__(self) -> str:
        return f"<{counted(len(self), 'file')}: {listed([*self])}>"


class Mechanism:
    """A mechanism: a linkage of nodes or a scene of bodies, with the solver that was made for it.

    :func:`kousoku.load` makes it. It can be copied and pickled, with the sources of its solver.

    Both are one type: which of them a file holds no type checker knows. A linkage has no masses and
    no parameters, and is not integrated; it refuses by name :meth:`begin`, :meth:`resume`,
    :meth:`evaluate`, and options of :meth:`simulate` that are of bodies, as bodies refuse those of
    linkages.

    Parameters
    ----------
    solver : DynamicsSolver or LinkageSolver
        Its solver.
    text : str
        The scene as TOML.
    file : str
        The file that it was read from, empty where it was none.
    outputs : sequence of str, optional
        What is computed; what the scene says unless given.
    """

    def __init__(
        self, solver: Solver, text: str, file: str = "", outputs: Sequence[str] | None = None
    ) -> None:
        self.solver = solver
        self.text = text
        self.file = file
        self._outputs = outputs

    @cached_property
    def scene(self) -> Scene:
        """The scene: bodies, joints, forces, as they were given."""
        from kousoku.model.reading.read import scene_from_toml

        return scene_from_toml(self.text, file=self.file)

    @property
    def name(self) -> str:
        """The name of the scene."""
        return self.solver.name

    @property
    def unit(self) -> str:
        """The unit of lengths, in which all results are."""
        return self.scene.unit

    @property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that are computed beside positions and velocities."""
        return tuple(self.scene.outputs if self._outputs is None else self._outputs)

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters that a run may change, and their values in the scene."""
        return dict(self.solver.parameters)

    @property
    def target(self) -> str:
        """Target that computes, ``c`` or ``numpy``."""
        return self.solver.target.name

    @property
    def files(self) -> dict[str, str]:
        """The emitted files by name: C and NumPy of its solver, to be read."""
        files = self.solver.sources.files
        return _Files({name: data.decode() for name, data in files.items()})

    def __repr__(self) -> str:
        facts = ", ".join(counted(*count) for count in self.solver.counts)
        return f"<Mechanism {self.name}: {facts}; in {self.target}>"

    def _repr_html_(self) -> str:
        from html import escape

        from kousoku.view import still

        return f"{still(self.scene)}<pre>{escape(repr(self))}</pre>"

    @overload
    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        progress: Callable[[float, float], object] | None = None,
        **options: Unpack[RunOptions],
    ) -> Result: ...

    @overload
    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        method: Literal["newton", "paper"] = ...,
        limit: float = ...,
    ) -> Result: ...

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        progress: Callable[[float, float], object] | None = None,
        **options: Any,
    ) -> Result:
        """Move from time 0 on.

        Bodies are integrated, or where drivers determine the motion, found position by position;
        a linkage follows its inputs in time. A type checker sees that options of bodies and of
        linkages are not mixed; those of the other are refused here.

        Parameters
        ----------
        end : float [s], optional
            The last of ``samples`` times from 0 on; the ``duration`` of the scene unless given.
        times : sequence of float [s], optional
            The times to write, ascending, instead.
        samples : int
            How many times.
        progress : callable, optional
            Called now and then with the time reached and the last time; of bodies.
        **options
            Of bodies as of :func:`kousoku.runtime.options.options_of`: ``tolerance``,
            ``parameters``, ``initial`` and others; of linkages ``method`` and ``limit`` as of
            :meth:`solve`.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed as ``result``.
        SolveError
            An option is not possible, or the start is not.
        Interrupted
            The user pressed Ctrl-C; the exception has what was computed.
        """
        if end is None and times is None:
            end = self._duration()
        options |= {"end": end, "times": times, "samples": samples, "progress": progress}
        with self._passed_on():
            return self.result_of(self.solver.in_time(**options))

    def _duration(self) -> float:
        duration = getattr(self.scene, "duration", None)
        if duration is None:
            raise SolveError(
                f"{self.name}: simulate wants a last time in seconds, as in simulate(2), or times;"
                " or give the scene a duration"
            )
        return float(duration)

    def solve(
        self,
        *,
        divisions: int | None = None,
        method: Literal["newton", "paper"] | None = None,
        turns: int | None = None,
        first_turn: int | None = None,
        from_turn: int | None = None,
        limit: float | None = None,
        parameters: Mapping[str, float | str] | None = None,
    ) -> Result:
        """Positions, velocities and accelerations at the divisions of the inputs.

        Parameters
        ----------
        divisions : int, optional
            Steps over the inputs; as in the scene unless given.
        method : {"newton", "paper"}, optional
            Of linkages: full Newton, or the iteration of the paper, (27) and (28).
        turns, first_turn, from_turn : int, optional
            Of linkages: how many turns to write, the first of them, and the one that begins as the
            scene says, 0 unless given: a turn need not lead back.
        limit : float, optional
            Of linkages: largest residual, in the unit of the scene.
        parameters : mapping of str to float or str, optional
            Of scenes of bodies: values of parameters; angles may be texts such as ``"30 deg"``.

        Raises
        ------
        MotionError
            It cannot be moved on; the error has what was computed.
        SolveError
            An option is not possible, or no inputs determine the motion.
        """
        arguments = {
            "divisions": divisions,
            "method": method,
            "turns": turns,
            "first_turn": first_turn,
            "from_turn": from_turn,
            "limit": limit,
            "parameters": parameters or None,
        }
        options = {name: value for name, value in arguments.items() if value is not None}
        with self._passed_on():
            return self.result_of(self.solver.along_inputs(self._times_of_inputs, options))

    def _times_of_inputs(self, divisions: int | None) -> list[float]:
        """Times at which the inputs of a scene of bodies take their values."""
        from math import isfinite

        import msgspec

        from kousoku.model.linkage.input_drivers import times_of

        scene = self.scene
        if divisions is not None:
            scene = msgspec.structs.replace(scene, divisions=divisions)
        times = times_of(scene)
        if times is None:
            raise SolveError(
                f"{self.name}: has no inputs, whose divisions say at which times to solve; where"
                " drivers are formulas of time, or nothing drives: simulate(end)"
            )
        if not all(map(isfinite, times)):
            raise SolveError(
                f"{self.name}: inputs.{next(iter(scene.inputs))} never reaches the end of its way:"
                " its rate and acceleration lead elsewhere"
            )
        return times

    def begin(self, times: Sequence[float] | Array, **options: Unpack[RunOptions]) -> Run:
        """Run of bodies at time 0 that can be stopped, saved and gone on with.

        Parameters
        ----------
        times : sequence of float [s]
            The times to write, ascending.
        **options
            As of :meth:`simulate`.

        Raises
        ------
        SolveError
            An option is not possible, or the start is not; or it is a linkage of nodes.
        """
        return self._knowing(self.solver.of_bodies("a run that goes on").begin(times, **options))

    def resume(self, saved: SavedRun) -> Run:
        """Run that goes on where another one was saved, with the same bits.

        Raises
        ------
        SolveError
            It belongs to another solver, or is no saved run; or this is a linkage of nodes.
        """
        return self._knowing(self.solver.of_bodies("a run that goes on").resume(saved))

    def _knowing(self, run: Run) -> Run:
        """Run whose results know the mechanism."""
        run.mechanism = self
        return run

    def matrices(
        self,
        t: float,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        parameters: Mapping[str, float | str] | None = None,
        *,
        angles: Mapping[str, float] | None = None,
    ) -> Matrices:
        """Matrices M, C_q, ν, γ, f as written, see :func:`kousoku.state_matrices.matrices`.

        ``loop.matrices(*run.state(k))`` has those of a row of a run, with its parameters and turns.
        """
        from kousoku.state_matrices import matrices

        parameters, angles = self._completed(q, parameters, angles)
        return matrices(self.scene, t, q, v, parameters, angles=angles)

    def evaluate(
        self,
        t: float,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        parameters: Mapping[str, float | str] | None = None,
        *,
        angles: Mapping[str, float] | None = None,
    ) -> Evaluation:
        """Accelerations and multipliers, see :func:`kousoku.state_matrices.evaluate`.

        Where the state leaves joints open, or velocities do not fit, by more than the closure
        tolerance of the scene, a ``UserWarning`` names them, and so do the ``notes`` of the result.

        Raises
        ------
        SolveError
            The state is not possible, or it is a linkage of nodes.
        """
        from kousoku.state_matrices import evaluate

        solver = self.solver.of_bodies("accelerations")
        parameters, angles = self._completed(q, parameters, angles)
        evaluation = evaluate(self.scene, solver, t, q, v, parameters, angles=angles)
        for note in evaluation.notes:
            warnings.warn(note, stacklevel=2)
        return evaluation

    def _completed(
        self,
        q: object,
        parameters: Mapping[str, float | str] | None,
        angles: Mapping[str, float] | None,
    ) -> tuple[Mapping[str, float | str] | None, Mapping[str, float] | None]:
        """Parameters and counted angles: those of the run where a row of one is given."""
        if not isinstance(q, Coordinates):
            return parameters, angles
        if parameters is None:
            parameters = q.parameters
        if angles is None and q.counted is not None:
            from kousoku.body_equations import equations_of

            solver = self.solver.of_bodies("counted angles")
            first, names = equations_of(self.scene).turning(solver)
            angles = dict(zip(names, q.counted[first:].tolist(), strict=False))
        return parameters, angles

    def plot(self, parameters: Mapping[str, float | str] | None = None) -> Figure:
        """Draw the mechanism where the scene puts it; needs matplotlib."""
        from kousoku.view import draw_mechanism

        return draw_mechanism(self.scene, parameters)

    @contextmanager
    def _passed_on(self) -> Iterator[None]:
        """Let results until a motion stopped know the mechanism."""
        try:
            yield
        except (MotionError, Interrupted) as error:
            self.result_of(error.result)
            if isinstance(error, Interrupted):
                self._knowing(error.run)
            raise

    def result_of(self, result: Any) -> Result:
        """Result that knows the mechanism."""
        result.mechanism = self
        return cast("Result", result)
