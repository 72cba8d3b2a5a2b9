"""Move a scene of bodies with the package that was generated from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import LoadError, SolveError
from kousoku.model.files.manifest import MOTION_FILE
from kousoku.runtime.design import DesignPlaces, with_parameters
from kousoku.runtime.integrate.assembled_start import Moved
from kousoku.runtime.integrate.motion import Layout
from kousoku.runtime.integrate.run_arguments import (
    numbers_of,
    require_callable,
    require_numbers,
    require_options,
    require_shape,
    times_of,
)
from kousoku.runtime.integrate.state import fields_of
from kousoku.runtime.momenta import ConservedPlaces
from kousoku.runtime.options import ALL_OPTIONS, options_of, with_values
from kousoku.runtime.run import Run
from kousoku.runtime.saved import SavedRun, checked_run
from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from kousoku.runtime.choice import Target
    from kousoku.runtime.dynamics_targets import SolverTarget
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.body_tables import BodyPlaces
    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.integrate.state import Field

#: Counts that are named only where there are some.
SAID_IF_ANY = ("driver", "dependent row")


@dataclass(frozen=True, slots=True)
class DynamicsSolver:
    """A loaded scene of bodies.

    Parameters
    ----------
    name : str
        The scene.
    layout : Layout
        Columns of a row.
    q, v : array
        Coordinates and velocities at the start.
    target : SolverTarget
        Target that computes.
    rows : tuple of (str, str)
        Joint or driver of each constraint, and the unit of its residual: m or rad.
    left_out : tuple of (str, str)
        Joint and unit of constraints that depend on others and are not solved for.
    satisfied : tuple of (str, str)
        Joint and unit of constraints that hold by themselves: bodies are put onto their joints.
    conserved : tuple of ConservedPlaces
        Parts of the scene that conserve some momentum.
    parameters : tuple of (str, float)
        Name of each parameter, and its value in the scene.
    is_driven : bool
        Whether drivers determine the whole motion.
    has_masses : bool
        Whether the scene gives all masses; else no energy or work of it is known.
    places : mapping of str to (int, int)
        First index in the workspace of each output of :meth:`evaluate`, and its size.
    state : mapping of str to Field
        Fields of the state of a run.
    moved : mapping of str to Moved
        Changes of bodies by assembly, the largest first.
    design : DesignPlaces, optional
        Numbers of the scene that depend on parameters, where it has some. Then ``q`` and ``v`` are
        the start with the parameters of the scene, and :meth:`at` has that with others.
    base : DynamicsSolver, optional
        Of a solver with other parameters: the solver with those of the scene.
    """

    name: str
    layout: Layout
    q: Array
    v: Array
    target: SolverTarget
    rows: tuple[tuple[str, str], ...]
    left_out: tuple[tuple[str, str], ...]
    satisfied: tuple[tuple[str, str], ...]
    conserved: tuple[ConservedPlaces, ...]
    parameters: tuple[tuple[str, float], ...]
    is_driven: bool
    has_masses: bool
    places: Mapping[str, tuple[int, int]]
    state: Mapping[str, Field]
    moved: Mapping[str, Moved]
    design: DesignPlaces | None = None
    base: DynamicsSolver | None = None

    def __repr__(self) -> str:
        return f"<DynamicsSolver {self.name}: {len(self.q)} coordinates; in {self.target.name}>"

    @property
    def sources(self) -> Sources:
        """The generated files."""
        return self.target.sources

    @property
    def unit(self) -> float:
        """Unit of length of the scene [m]."""
        return self.layout.unit

    @property
    def length(self) -> float:
        """A length of the scene [m], with which corrections are compared."""
        return self.layout.length

    @property
    def checked(self) -> tuple[tuple[str, str], ...]:
        """Joint or driver, and unit, of all rows: those that are solved for first."""
        return (*self.rows, *self.left_out, *self.satisfied)

    @property
    def bodies(self) -> tuple[BodyPlaces, ...]:
        """Places of the bodies in q and v, in the order of the scene."""
        return self.layout.bodies

    @property
    def counts(self) -> tuple[tuple[int, str, str], ...]:
        """Counts of bodies, joints and others: number, noun, and its plural."""
        drivers = sum(name.startswith("drivers.") for name in self.layout.checked)
        degrees = len(self.v) - len(self.rows) - len(self.satisfied)
        counts = (
            (len(self.bodies), "body", "bodies"),
            (len(self.layout.checked) - drivers, "joint", "joints"),
            (drivers, "driver", "drivers"),
            (degrees, "degree of freedom", "degrees of freedom"),
            (len(self.left_out), "dependent row", "dependent rows"),
        )
        return tuple(count for count in counts if count[0] or count[1] not in SAID_IF_ANY)

    def of_bodies(self, what: str) -> DynamicsSolver:
        """Solver itself: scenes of bodies have what is asked for."""
        return self

    def along_inputs(
        self, times: Callable[[int | None], Sequence[float]], options: Mapping[str, Any]
    ) -> Motion:
        """Motion at the divisions of the inputs, position by position.

        Parameters
        ----------
        times : callable
            Returns when the inputs are at their divisions (n,) [s], given how many these are.
        options : mapping
            ``divisions`` and ``parameters``.

        Raises
        ------
        MotionError, SolveError
            As of :meth:`simulate`.
        """
        for name in options:
            if name not in {"divisions", "parameters"}:
                raise SolveError(
                    f"{self.name}: {name} is an option of linkages of nodes; this one is a scene of"
                    " bodies, whose options are divisions and parameters"
                )
        parameters = options.get("parameters")
        return self.simulate(
            times=times(options.get("divisions")), method="kinematics", parameters=parameters
        )

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        progress: Callable[[float, float], object] | None = None,
        **options: Any,
    ) -> Motion:
        """Integrate the motion from time 0.

        Parameters
        ----------
        end : float [s], optional
            The last time, the duration of the scene unless given; ``samples`` times from 0 on are
            written, equally far apart.
        times : sequence of float [s], optional
            The times to write, ascending, instead of ``end`` and ``samples``.
        samples : int
            How many times.
        progress : callable, optional
            Called now and then with the time reached and the last time.
        **options
            As in :meth:`begin`, such as ``tolerance=1e-12`` or ``parameters={"k": 3.0}``.

        Raises
        ------
        MotionError
            The motion cannot go on; the error has what was computed.
        SolveError
            An option is not possible, or the start is not.
        Interrupted
            The user pressed Ctrl-C; the exception has what was computed.
        """
        require_options(self.name, options, ALL_OPTIONS, "end", "times", "samples", "progress")
        require_callable(self.name, progress)
        if end is None and times is None:
            end = self.layout.duration
        chosen = times_of(self.name, end, times, samples, self.target.row_size)
        return self.begin(chosen, **options).finish(progress)

    def in_time(self, **options: Any) -> Motion:
        """Motion in time, see :meth:`simulate`; linkages say here which options are of bodies."""
        return self.simulate(**options)

    def begin(self, times: Sequence[float] | Array, **options: Any) -> Run:
        """Run at time 0 that can be stopped and go on.

        Parameters
        ----------
        times : (n,) sequence of float [s]
            The times to write, ascending.
        **options
            As in :func:`kousoku.runtime.options.options_of`: ``tolerance``, ``method``, ``step``,
            ``largest_step``, ``checks``, ``most_steps``, ``parameters``, ``initial``, ``q0``,
            ``v0``, ``strict``.

        Raises
        ------
        SolveError
            An option is not possible, or the start is not.
        """
        require_options(self.name, options, ALL_OPTIONS, "times")
        chosen = options_of(self, **options)
        return Run(self, times_of(self.name, None, times, 0), chosen)

    def at(self, parameters: Mapping[str, float | str]) -> DynamicsSolver:
        """Solver with other parameters, and with the start that the scene then has.

        Where the centre of mass or the principal axes of a body depend on parameters, ``q`` and
        ``v`` do, too: the frame of the body, and its velocity, stay as the scene has them. A run
        brings bodies from there to where they fit. A scene without formulas in place of masses,
        points and lengths has one start for all parameters.

        Raises
        ------
        SolveError
            There is no such parameter, or a number of the scene is not possible with them.
        """
        values = with_values(self, parameters)
        adapted = with_parameters(self, np.array([value for _, value in values]))
        return replace(adapted, parameters=values, base=self.base or self)

    def evaluate(
        self,
        time: float = 0.0,
        q: Array | None = None,
        v: Array | None = None,
        parameters: Mapping[str, float | str] | None = None,
    ) -> dict[str, Array]:
        """Outputs of the solver at a state as it is: nothing is projected.

        Parameters
        ----------
        time : float [s]
            When.
        q, v : (nq,), (nv,) array
            Coordinates and velocities as in ``solver.q`` and ``solver.v``, in SI units; those of
            ``solver.at(parameters)`` unless given. A body has its centre of mass [m], frame O, and
            the Euler parameters [-] of its principal axes, then its velocity [m/s], frame O, and
            its angular velocity [rad/s], principal frame.
        parameters : mapping of str to float or str, optional
            Those that are not as in the scene.

        Returns
        -------
        dict of str to array
            ``v_dot`` (nv,), the accelerations; ``C`` (nc,) [m, rad], what is left of the
            constraints that are solved for, and ``C_left_out`` of all others, those too of joints
            that bodies are put onto; ``C_dot`` and ``C_ddot``, the same of both, one after the
            other; ``dq`` (nv,), which brings the state onto those that are solved for, ``q_moved``
            (nq,), which is there and on all joints that bodies are put onto, and ``dv`` (nv,),
            which brings the velocities onto both; ``energies`` (2,) [J], kinetic and potential;
            ``lam`` (nc,) and ``reactions`` where these are wanted.

        Raises
        ------
        SolveError
            A number is not finite, or there are too many or too few of them.
        """
        values = np.array([value for _, value in with_values(self, parameters)])
        require_numbers(self.name, time=time)
        adapted = with_parameters(self, values)
        state = []
        for name, numbers, start in (("q", q, adapted.q), ("v", v, adapted.v)):
            array = numbers_of(self.name, name, start if numbers is None else numbers)
            require_shape(self.name, name, array, start)
            state.append(array)
        work = np.zeros(self.target.work_size)
        if self.target.evaluate(float(time), state[0], state[1], values, work) != 0:
            raise SolveError(f"{self.name}: time, coordinates and velocities must be finite")
        return {name: work[base : base + size] for name, (base, size) in self.places.items()}

    def resume(self, saved: SavedRun) -> Run:
        """Run that goes on where another one was saved, with the same bits.

        Raises
        ------
        SolveError
            It belongs to another solver, or is no saved run, or was cut, forged or damaged.
        """
        checked = checked_run(self, saved)
        return Run(self, checked.times, checked.options, checked)


def load_dynamics(folder: str | Path, *, target: Target = "auto") -> DynamicsSolver:
    """Load the folder that was generated from a scene of bodies.

    Parameters
    ----------
    folder : path
        A folder that the generator wrote.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.

    Raises
    ------
    LoadError
        It is not such a folder, or a file of it was edited.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: neither the cache nor a temporary folder can be written.
    """
    return open_dynamics(Sources.read(folder), target)


def open_dynamics(sources: Sources, target: Target) -> DynamicsSolver:
    """Solver of files that were read.

    Raises
    ------
    LoadError, CompilerError, CacheError
        As of :func:`load_dynamics`.
    """
    from kousoku.runtime.dynamics_targets import open_target

    data = sources.data
    if "bodies" not in data:
        raise LoadError(
            f"{sources.folder} is not made from a scene of bodies: its {MOTION_FILE} has none"
        )
    return DynamicsSolver(
        name=sources.manifest.package,
        layout=Layout.from_data(data),
        q=np.array(data["q"], dtype=np.float64),
        v=np.array(data["v"], dtype=np.float64),
        target=open_target(sources, target),
        rows=tuple((joint, unit) for joint, unit in data["rows"]),
        left_out=tuple((joint, unit) for joint, unit in data["left_out"]),
        satisfied=tuple((joint, unit) for joint, unit in data["satisfied"]),
        conserved=tuple(map(ConservedPlaces.from_data, data["kept"])),
        parameters=tuple((name, value) for name, value in data["parameters"]),
        is_driven=data["is_driven"],
        has_masses=data["has_masses"],
        places={name: (base, size) for name, (base, size) in data["places"].items()},
        state={field.name: field for field in fields_of(data["state"])},
        moved={name: Moved(*sizes) for name, *sizes in data["moved"]},
        design=DesignPlaces.from_data(data["design"]) if "design" in data else None,
    )
