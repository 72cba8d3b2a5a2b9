"""A scene as its solver knows it: sizes, tables, and the segments that compute on a workspace."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, rounding_of_sum
from .methods import METHODS
from .state import State, size_of_state
from .tasks import TaskKernel, numbers, places, run_tasks, segment_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array
    from .tasks import Function, Segment, Slots

#: Stages of the longest method, and coefficients of the longest interpolating polynomial.
STAGES = max(method.all for method in METHODS)
DENSE = 3 + max(len(method.dense) for method in METHODS)
#: Coefficients of a polynomial through the places of a step; memory.h has it, too.
WAY = 12


@dataclass(frozen=True)
class SceneTables:
    """Tables of a scene in its solver: what the scene lacks is not given, and zero or empty.

    Parameters
    ----------
    name, digest : str
        Of the scene, and of all that its solver was made of.
    key : float
        What a state of this solver begins with.
    length : float [m]
        A length of the scene: corrections are compared with it.
    closure_tolerance : float
        What rows that are left out may miss, relative to that length, or in radians.
    mass : float [kg]
        Of all bodies: the error of work is compared with the energy that they have in motion.
    regions : mapping of str to (int, int)
        First slot and size of each named part of the workspace.
    work_size : int
        Count of slots in the workspace.
    kernels : sequence of (callable, int, str, str)
        What tasks call, as :meth:`integrate.tasks.TaskKernel.read` takes it.
    tasks : mapping of str to str
        The table of each segment, as :func:`integrate.tasks.segment_of` reads it.
    tables : mapping of str to str
        The tables below, as text.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    constants : sequence of float
        The numbers of the scene.
    parameters : (n,) array
        Values of the parameters, unless a run is given others.
    lengths : (nv,) array
        What corrections are compared with: the length [m] where a velocity moves, 1 where it turns.
    floors : (nq,) array
        What changes of coordinates are compared with, where drivers leave no freedom or the rank of
        rows is looked at; else empty.
    shifts : (n, 2) array
        Of each length that changes: its place in q and in v; first those that corrections are
        added to.
    added : int
        How many those are.
    orientations : (n, 3) array
        Of each orientation: the place of its Euler parameters in q, of its turn in v, and how many
        parameters vary.
    works : int
        Entries at the end of q that are works [J].
    unwrapped_angles : (int, int)
        The first entry of q that counts turns, and the one behind the last.
    has_joint_coordinates : bool
        Whether bodies are put onto joints with the ground.
    has_drivers : bool
        Whether constraints depend on time.
    has_fractional_powers : bool
        Whether a force goes with a fractional power of what may be zero, as sqrt(x).
    has_misses : bool
        Whether rows of the constraints that are left out may miss more than rounding.
    has_row_switch : bool
        Whether rows of the constraints that are left out take over where others lose rank.
    inverse_masses, mass_places : (nv,) array
        The diagonal of M⁻¹, and where its elements are in the design, -1 of those that are fixed;
        needed for the row switch-over.
    drivers : (n, 2) array
        Of each row of a driver: which row it is, and the place of its work in q.
    starts : (n, 2) array
        What depends on parameters at the start: its place in y, and in the design.
    positive : (n,) array
        Places of the design with numbers that must be positive.
    rank_rows : (n, 2) array
        Of each row whose rank is looked at where parameters are given: which, and whether it is
        left out.
    row_lengths : (n,) array
        What residuals of rows are compared with, as corrections are.
    inverse_pivot_factors : (n,) array
        What makes masses [kg] of inverse pivots of rows, 1 or 1/m²: the inverse of an angle's pivot
        is a moment of inertia, which is compared with masses at the length of the scene.
    measure_sizes : (n,) array
        What errors are compared with of what formulas read.
    feature_scales, narrow_scales : (n, 2) array
        What variations of features, and of narrow parts, are compared with, and 1 where that is
        over the square of times.
    events : (n, 3) array
        Of each event the direction, the place of what a run does then in ``ACTIONS``, and 1 where
        its formula may jump.
    """

    name: str
    digest: str
    key: float
    length: float
    closure_tolerance: float
    mass: float
    regions: Mapping[str, tuple[int, int]]
    work_size: int
    kernels: Sequence[tuple[Function, int, str, str]]
    tasks: Mapping[str, str]
    tables: Mapping[str, str]
    parts: Sequence[str] = ()
    added: int = 0
    works: int = 0
    unwrapped_angles: tuple[int, int] = (0, 0)
    has_joint_coordinates: bool = False
    has_drivers: bool = False
    has_misses: bool = False
    has_fractional_powers: bool = False
    has_row_switch: bool = False
    segments: Mapping[str, Segment] = field(init=False, repr=False)
    constants: list[float] = field(init=False, repr=False)
    parameters: Array = field(init=False, repr=False)
    lengths: Array = field(init=False, repr=False)
    floors: Array = field(init=False, repr=False)
    inverse_masses: Array = field(init=False, repr=False)
    mass_places: Slots = field(init=False, repr=False)
    shifts: Slots = field(init=False, repr=False)
    orientations: Slots = field(init=False, repr=False)
    drivers: Slots = field(init=False, repr=False)
    starts: Slots = field(init=False, repr=False)
    positive: Slots = field(init=False, repr=False)
    rank_rows: Slots = field(init=False, repr=False)
    row_lengths: Array = field(init=False, repr=False)
    inverse_pivot_factors: Array = field(init=False, repr=False)
    measure_sizes: Array = field(init=False, repr=False)
    feature_scales: Array = field(init=False, repr=False)
    narrow_scales: Array = field(init=False, repr=False)
    events: Slots = field(init=False, repr=False)

    def __post_init__(self) -> None:
        kernels = [TaskKernel.read(*kernel) for kernel in self.kernels]
        tables = defaultdict(str, self.tables)
        values: dict[str, object] = {
            "segments": {name: segment_of(kernels, text) for name, text in self.tasks.items()},
            "constants": numbers(tables["constants"]),
        }
        for name in ("parameters", "floors", "inverse_masses", "measure_sizes"):
            values[name] = np.array(numbers(tables[name]))
        widths = {
            "shifts": 2,
            "orientations": 3,
            "drivers": 2,
            "starts": 2,
            "events": 3,
            "rank_rows": 2,
        }
        for name, width in widths.items():
            values[name] = places(tables[name], width)
        for name in ("feature_scales", "narrow_scales"):
            values[name] = np.array(numbers(tables[name])).reshape(-1, 2)
        for name in ("mass_places", "positive"):
            values[name] = places(tables[name], 1)[:, 0]
        for name, table in (("lengths", "is_length"), ("row_lengths", "row_is_length")):
            values[name] = np.where(numbers(tables[table]), self.length, 1.0)
        values["inverse_pivot_factors"] = (np.asarray(values["row_lengths"]) / self.length) ** 2
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def size(self, region: str) -> int:
        """Size of a region, 0 where the scene has none of that name."""
        return self.regions.get(region, (0, 0))[1]

    @property
    def nq(self) -> int:
        """Count of coordinates."""
        return self.size("q")

    @property
    def nv(self) -> int:
        """Count of velocities."""
        return self.size("v")

    @property
    def ny(self) -> int:
        """Count of coordinates and velocities."""
        return self.nq + self.nv

    @property
    def nc(self) -> int:
        """Count of rows of the constraints that are solved for."""
        return self.size("C")

    @property
    def is_driven(self) -> bool:
        """Whether drivers and joints leave no freedom."""
        # where bodies are put onto joints, the rows of these are checked only
        rows = self.nc + (self.size("C_left_out") if self.has_joint_coordinates else 0)
        return self.has_drivers and rows == self.nv

    @property
    def has_design(self) -> bool:
        """Whether numbers of the scene depend on parameters."""
        return "design" in self.regions

    @property
    def has_continuation(self) -> bool:
        """Whether parameters may change where bodies or drivers begin."""
        return self.has_design or (self.has_drivers and self.size("parameters") > 0)

    @property
    def has_switches(self) -> bool:
        """Whether formulas have a kink or a jump at certain times."""
        return "switches" in self.regions

    @property
    def has_laws(self) -> bool:
        """Whether drivers have laws that are no polynomials, and may bend in no time."""
        return "laws" in self.regions

    @property
    def has_features(self) -> bool:
        """Whether formulas vary with time beyond polynomials."""
        return "features" in self.regions

    @property
    def has_functions(self) -> bool:
        """Whether steps are searched for events, and for formulas that switch or vary in them."""
        return "ranges" in self.regions

    @property
    def is_searched(self) -> bool:
        """Whether steps are searched for these, or for distances that come down to zero."""
        return self.has_functions or self.n_distances > 0

    @property
    def n_breaks(self) -> int:
        """Count of functions that are zero where forces jump."""
        return self.size("breaks") // 4

    @property
    def breaks(self) -> slice:
        """Places of these among all functions that cross."""
        last = self.size("crossings") // 4 + self.n_breaks
        return slice(last - self.n_breaks, last)

    @property
    def n_poles(self) -> int:
        """Count of functions that are zero where forces may be infinite."""
        return self.size("poles") // 4

    @property
    def n_distances(self) -> int:
        """Count of lengths along which forces act, and of distances in formulas."""
        return self.size("lengths") + self.size("distances")

    @property
    def has_narrow(self) -> bool:
        """Whether formulas vary with the state beyond polynomials."""
        return "narrow" in self.regions

    @property
    def has_refinement(self) -> bool:
        """Whether accelerations may be refined.

        Rows are left out, joints close loops, or masses are very unequal.
        """
        return "refinement" in self.tasks

    @property
    def shares_out(self) -> bool:
        """Whether forces of joints that are not unique are found by loops over all rows."""
        return "reactions" in self.parts and "reaction" not in self.tasks

    @property
    def accelerates(self) -> bool:
        """Whether a row takes what geometry and accelerations leave."""
        return any(part in self.parts for part in ("v_dot", "coordinates", "reactions"))

    @property
    def per_shown(self) -> int:
        """Count of numbers that a row has of a coordinate that it shows."""
        return 3 if "v_dot" in self.parts else 2

    @property
    def state_sizes(self) -> dict[str, int]:
        """Sizes that the layout of a state depends on."""
        return {
            "NY": self.ny,
            "DENSE": DENSE,
            "N_PARAMETERS": self.size("parameters"),
            "MOMENTA": self.size("momenta"),
            "NCHECK": self.nc + self.size("C_left_out"),
            "N_CROSSINGS": sum(map(self.size, ("crossings", "breaks", "poles"))) // 4,
            "EVENTS": len(self.events),
            "RANGED": self.nq + self.size("coordinates") // self.per_shown,
        }

    @property
    def state_size(self) -> int:
        """Count of numbers in a state."""
        return size_of_state(self.state_sizes)

    @property
    def row_size(self) -> int:
        """Count of numbers in a row: time, y, and the parts."""
        return 1 + self.ny + sum(map(self.size, self.parts))


class Workspace:
    """The workspace of a scene, region by region; those that it lacks are empty.

    Parameters
    ----------
    scene : SceneTables
        What it belongs to.
    slots : array
        Where it is.
    """

    t: Array
    parameters: Array
    q: Array
    v: Array
    dq: Array
    q_moved: Array
    C: Array
    C_left_out: Array
    pivots: Array  # D⁻¹ of C_q M⁻¹ C_qᵀ
    dv: Array
    q_dot: Array
    v_dot: Array
    lam: Array
    energies: Array
    momenta: Array
    C_dot: Array
    C_ddot: Array
    more_lam: Array
    more_power: Array
    all_lam: Array
    coordinates: Array
    wrenches: Array
    design: Array
    span: Array
    law_span: Array
    switches: Array
    features: Array
    gaps: Array
    laws: Array
    measures: Array
    ranges: Array
    crossings: Array
    breaks: Array
    poles: Array
    narrow: Array
    infinite: Array
    lengths: Array
    distances: Array
    constants: Array

    def __init__(self, scene: SceneTables, slots: Array) -> None:
        self.scene = scene
        self.slots = slots
        for name in Workspace.__annotations__:
            base, size = scene.regions.get(name, (0, 0))
            setattr(self, name, slots[base : base + size])
        # the rows that are left out stand behind those that are solved for
        base = scene.regions.get("C", scene.regions.get("C_left_out", (0, 0)))[0]
        rows = scene.nc + scene.size("C_left_out")
        self.all_C = slots[base : base + rows]
        # those that vary with the state behind those that cross
        names = ("crossings", "breaks", "poles", "narrow", "infinite")
        base, size = scene.regions.get("ranges", (0, 0))
        base += size
        self.functions = slots[base : base + sum(map(scene.size, names))]

    def run(self, segment: str) -> None:
        """Compute a segment; one that the scene lacks does nothing."""
        run_tasks(self.slots, self.scene.segments.get(segment, []))

    def prepare(self, parameters: Array) -> None:
        """Write what no step changes: the numbers of the scene, and parameters (n,) of the run."""
        self.constants[:] = self.scene.constants
        self.parameters[:] = parameters
        self.run("setup")

    def place(self, t: float, y: Array) -> None:
        """Put a state y (ny,) at a time t [s] into the workspace: q, then v, in SI units."""
        self.t[0] = t
        self.q[:] = y[: self.scene.nq]
        self.v[:] = y[self.scene.nq :]

    def displace(self, low: Array | None) -> None:
        """Move q by the correction dq (nv,) [m, rad], Euler parameters back to norm one.

        What rounding leaves over of lengths is added to low (ny,) [m] if it is not None.
        """
        self.run("move")
        if low is not None:
            slots, change = self.scene.shifts[: self.scene.added].T
            low[slots] += rounding_of_sum(self.q[slots], self.dq[change], self.q_moved[slots])
        self.q[:] = self.q_moved

    def size_of(self, u: Array) -> float:
        """Largest element of a correction u (nv,) [-], lengths relative to that of the scene."""
        return float(np.max(np.abs(u) / self.scene.lengths))  # a NaN stays

    def way_of(self, h: float, y: Array, end: Array) -> float:
        """Distance [-] that bodies move in a step of length h [s], in lengths and radians.

        It is the larger of h |v| at y (ny,) and at the end (ny,).
        """
        nq = self.scene.nq
        return h * larger(self.size_of(y[nq:]), self.size_of(end[nq:]))


class Work:
    """The memory for work: the workspace, derivatives of the stages, three states, misses.

    Parameters
    ----------
    scene : SceneTables
        What it belongs to.
    slots : array
        The workspace.
    """

    def __init__(self, scene: SceneTables, slots: Array) -> None:
        self.scene = scene
        self.w = Workspace(scene, slots)
        self.k = np.zeros((STAGES, scene.ny))
        self.y, self.low, self.scratch = np.zeros((3, scene.ny))
        self.missed = np.zeros(scene.has_misses * scene.size("C_left_out"))
        self.row_switch = RowSwitch(scene) if scene.has_row_switch else None


class RowSwitch:
    """Rows of the constraints, all of them, where they take over: see ``row_switch``.

    Parameters
    ----------
    scene : SceneTables
        What it belongs to.
    """

    def __init__(self, scene: SceneTables) -> None:
        count = scene.nc + scene.size("C_left_out")
        self.is_active = False  # whether all rows were factorised
        self.ratio = 0.0  # their pivot ratio
        self.tried = 0.0  # that of the rows kept where all were no better, or 0
        self.rows = np.zeros((count, scene.nv))  # C_q
        self.matrix = np.zeros((count, count))  # C_q M⁻¹ C_qᵀ, then its factors
        self.order = np.arange(count)  # in which rows are solved for
        self.lam = np.zeros(count)  # multipliers
        self.rates = np.zeros(count)  # of the rows at rest, −ν


def state_of(scene: SceneTables, numbers: Array) -> State:
    """State (state_size,) with its fields by name."""
    return State(numbers, scene.state_sizes)
