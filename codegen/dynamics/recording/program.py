"""A program: kernels that are called one after the other on one flat workspace of doubles.

A place in the workspace is a slot. A task is one call of a kernel: it reads runs of consecutive
slots and writes runs of consecutive slots. The length of each run belongs to the kernel, so that a
task is a few numbers, and many tasks of one kernel are a loop over a short table.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.design import DesignNumbers
from kousoku.model.errors import EmitError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from fractions import Fraction

    from kousoku.model.operations.kernel import Kernel


@dataclass(frozen=True, slots=True)
class Region:
    """A named part of the workspace.

    Parameters
    ----------
    name : str
        ``q``, ``v``, ``C``, ``lam`` … as in :data:`REGIONS`.
    base, size : int
        First slot, and count of slots.
    """

    name: str
    base: int
    size: int


@dataclass(frozen=True, slots=True)
class Task:
    """One call of a kernel.

    Parameters
    ----------
    kernel : int
        Its index in :attr:`Program.kernels`.
    inputs, outputs : tuple of int
        First slot of each run, one for each input and output of the kernel. All inputs are read
        before any output is written.
    owner : str
        The body, joint, force or driver that it belongs to; empty where that is no single one.
    """

    kernel: int
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    owner: str = ""


@dataclass(frozen=True, slots=True)
class Segment:
    """Tasks that run together.

    Parameters
    ----------
    name : str
        ``geometry``, ``position`` … as in :data:`SEGMENTS`; of a linkage ``position_1`` ….
    tasks : tuple of Task
        In an order in which they can run.
    contents : tuple of str
        Titles of the tasks that were inlined into it, by their owners.
    meaning : str
        What it computes, of a segment that is none of :data:`SEGMENTS`.
    """

    name: str
    tasks: tuple[Task, ...]
    contents: tuple[str, ...] = ()
    meaning: str = ""


@dataclass(frozen=True, slots=True)
class CoordinatePlace:
    """Slot of a coordinate, or the value of one that has none.

    Parameters
    ----------
    slot : int
        In the workspace, -1 of a coordinate that does not change.
    value : float
        Its constant value, or its value at the start.
    """

    slot: int
    value: float


@dataclass(frozen=True, slots=True)
class BodyCoordinates:
    """Slots of the position and velocity of a body.

    Parameters
    ----------
    body : str
        As in the scene.
    r, p, v, omega_b : tuple of CoordinatePlace
        Centre of mass and its velocity in frame O, Euler parameters, angular velocity in the frame
        of the body. A point has constant p; in a planar program r along the normal and the two
        parameters across it are constant.
    """

    body: str
    r: tuple[CoordinatePlace, ...]
    p: tuple[CoordinatePlace, ...]
    v: tuple[CoordinatePlace, ...]
    omega_b: tuple[CoordinatePlace, ...]


@dataclass(frozen=True, slots=True)
class Auxiliary:
    """An entry of q that belongs to no body; see ``composition.auxiliary``.

    Parameters
    ----------
    kind : str
        ``turns`` of an angle [rad], ``work`` of a force or a driver [J].
    name : str
        Of the coordinate, the force or the driver.
    place : CoordinatePlace
        Its slot, and its value at the start.
    """

    kind: str
    name: str
    place: CoordinatePlace


@dataclass(frozen=True, slots=True)
class ConservedMomenta:
    """Momenta that a part of a system conserves; see ``composition.momentum``.

    Parameters
    ----------
    bodies : tuple of int
        The bodies of the part.
    linear, angular : tuple of (3,)
        Directions in frame O along which its linear momentum is constant, and its angular momentum.
    about : (3,) [m], optional
        The point of the ground that the angular momentum is about; its centre of mass unless given.
    """

    bodies: tuple[int, ...]
    linear: tuple[tuple[float, float, float], ...]
    angular: tuple[tuple[float, float, float], ...]
    about: tuple[float, float, float] | None = None

    @property
    def count(self) -> int:
        """Count of components that stay constant."""
        return len(self.linear) + len(self.angular)


@dataclass(frozen=True, slots=True)
class RowIndex:
    """One row of a constraint.

    Parameters
    ----------
    joint : str
        As in the scene.
    instance : int
        Its index in :attr:`kousoku.model.mechanics.multibody.System.constraints`.
    row : int
        Its index in the kind.
    """

    joint: str
    instance: int
    row: int


@dataclass(frozen=True, slots=True)
class Program:
    """Kernels and the tasks that call them, in segments, on one workspace.

    One has the motion of a scene, another all equations of a system as it stands, or a linkage.

    Parameters
    ----------
    name : str
        The scene.
    kernels : tuple of Kernel
        Each input and each output is one run of slots; names are ``x0``, ``x1`` … and ``y0`` ….
    segments : tuple of Segment
        No two tasks of a segment write the same slot. What ``geometry`` leaves in the workspace is
        read by those in :data:`AFTER_GEOMETRY`; segments share nothing else but the regions.
    regions : tuple of Region
        By name; the rest of the workspace is scratch.
    constants : tuple of Fraction
        The numbers in the region ``constants``: they are put there once.
    size : int
        Count of slots.
    bodies : tuple of BodyCoordinates
        In the order of the system.
    rows : tuple of RowIndex
        In the order of the regions ``C`` and ``lam``.
    is_planar : bool
        Whether all bodies move in parallel coordinate planes.
    left_out : tuple of RowIndex
        Rows that depend on others, in the order of the region ``C_left_out``.
    has_misses : bool
        Whether these may be violated by more than rounding.
    satisfied : tuple of RowIndex
        Rows that hold by themselves, in the order of the region ``C_left_out``: those of joints
        that bodies are put onto. Where there are some no row is left out.
    placed : tuple of int
        Bodies whose centre of mass follows from all else where they are put onto a joint.
    not_unique : tuple of str
        Joints whose reactions are not unique.
    undetermined : tuple of (str, tuple of str)
        Of these the components of force and torque that are not unique, all of those left out here.
    unique_in_plane : tuple of str
        Joints of whose reactions only components out of the plane of motion are not unique.
    only_in_plane : str
        Why components of reactions out of the plane are not computed; empty where none is left out.
    has_masses : bool
        Whether masses are those of the scene; else its energies and works mean nothing.
    parameters : tuple of float
        Values in the region ``parameters`` unless a run has others.
    auxiliary : tuple of Auxiliary
        Entries of q after the coordinates of the bodies.
    conserved : tuple of ConservedMomenta
        The momenta of the region ``momenta``.
    on_demand : tuple of Segment
        Segments that a run calls where it must: those of :data:`ON_DEMAND`.
    design : DesignNumbers
        The numbers of the region ``design``, which depend on parameters.
    is_inlined : bool
        Whether each kernel is one function of the whole workspace, called once.
    """

    name: str
    kernels: tuple[Kernel, ...]
    segments: tuple[Segment, ...]
    regions: tuple[Region, ...]
    constants: tuple[Fraction, ...]
    size: int
    bodies: tuple[BodyCoordinates, ...]
    rows: tuple[RowIndex, ...]
    is_planar: bool
    auxiliary: tuple[Auxiliary, ...] = ()
    conserved: tuple[ConservedMomenta, ...] = ()
    left_out: tuple[RowIndex, ...] = ()
    has_misses: bool = False
    satisfied: tuple[RowIndex, ...] = ()
    placed: tuple[int, ...] = ()
    not_unique: tuple[str, ...] = ()
    undetermined: tuple[tuple[str, tuple[str, ...]], ...] = ()
    unique_in_plane: tuple[str, ...] = ()
    only_in_plane: str = ""
    has_masses: bool = True
    parameters: tuple[float, ...] = ()
    on_demand: tuple[Segment, ...] = ()
    design: DesignNumbers = field(default_factory=DesignNumbers)
    is_inlined: bool = False

    @property
    def shares_out(self) -> bool:
        """Whether forces of joints that are not unique are found by loops over all rows."""
        has_regions = any(region.name == "reactions" for region in self.regions)
        return has_regions and all(segment.name != "reaction" for segment in self.segments)

    def region(self, name: str) -> Region:
        """Region by its name."""
        for region in self.regions:
            if region.name == name:
                return region
        known = ", ".join(region.name for region in self.regions)
        raise EmitError(f"the program of {self.name} has no region {name}; it has {known}")

    def segment(self, name: str) -> Segment:
        """Segment by its name."""
        for segment in (*self.segments, *self.on_demand):
            if segment.name == name:
                return segment
        known = ", ".join(segment.name for segment in (*self.segments, *self.on_demand))
        raise EmitError(f"the program of {self.name} has no segment {name}; it has {known}")


#: What the regions hold. In the workspace they are in the order in which they are set aside.
REGIONS = {
    "t": "time, s",
    "parameters": "what formulas depend on and a run may vary, in the order of the scene",
    "q": "r (frame O) and Euler parameters p of each body in turn, then the auxiliary entries",
    "v": "velocity (frame O) and angular velocity (body frame) of each body in turn",
    "dq": "correction of the coordinates, in the order of v: lengths and virtual rotations",
    "q_moved": "q after dq, Euler parameters of norm one",
    "C": "residuals, joint by joint",
    "C_left_out": "residuals of rows that depend on others, or hold by themselves; right behind C",
    "pivots": "D^-1 of the factors, in the order of C: very large where the rank is nearly lost",
    "dv": "correction of v",
    "q_dot": "time derivative of q",
    "v_dot": "time derivative of v",
    "lam": "multipliers, in the order of C",
    "free": "M^-1 f of each body that is put onto a joint with the ground",
    "reactions": "force (frame O) and torque (body frame) of each joint on body j, or on i if j is"
    " the ground, at the centre of mass; the columns of that body only",
    "coordinates": "value and rate of each coordinate that is shown, and its acceleration where"
    " accelerations are wanted: m or rad",
    "energies": "kinetic and potential energy, J",
    "momenta": "linear and angular momenta that should not change, part by part: kg m/s, kg m^2/s",
    "C_dot": "C_q v - nu, in the order of C and C_left_out",
    "C_ddot": "C_q v_dot - gamma, in the order of C and C_left_out",
    "more_lam": "correction of lam",
    "more_power": "correction of the power of each driver",
    "all_lam": "multipliers, in the order of C and C_left_out",
    "wrenches": "force and torque of each joint at its point, the torque relative to a length",
    "span": "two times, s",
    "switches": "of each switching function of time least and most between these times, then those"
    " of its rate",
    "features": "of each part of a formula that varies with time, likewise",
    "gaps": "of what drivers prescribe of distances, less what counts as none, likewise",
    "law_span": "two times, s",
    "laws": "of each driver's law that is no polynomial, and of two derivatives, likewise",
    "measures": "value and rate of what formulas read of a state, in their units",
    "ranges": "two times, s; least and most of each measure between them, of its rate, of the next",
    "crossings": "of each event, then each switching function of the state, as of switches",
    "breaks": "of each of these that is zero where a force jumps, likewise; right behind them",
    "poles": "of what is zero where forces may be infinite, likewise",
    "narrow": "of each part of a formula that varies with the state, likewise",
    "infinite": "of each part of a formula that may be infinite, likewise",
    "lengths": "squares of lengths along which forces act",
    "distances": "squares of distances in formulas that may come down to zero; right behind these",
    "design": "numbers of the scene that depend on parameters",
    "constants": "the scene's numbers",
}

#: The regions that only segments of ``ON_DEMAND`` write.
ON_DEMAND_REGIONS = (
    *("more_lam", "more_power", "all_lam", "wrenches"),
    *("span", "switches", "features", "gaps", "law_span", "laws"),
    *("ranges", "crossings", "breaks", "poles", "narrow", "infinite"),
    *("lengths", "distances"),
)

#: What the segments read and write, in the order in which they can run.
SEGMENTS = {
    "geometry": "q, t -> C, pivots of C_q M^-1 C_q^T, the Jacobian and more of q alone",
    "position": "C -> dq = -M^-1 C_q^T (C_q M^-1 C_q^T)^-1 C",
    "move": "q, dq, t -> q_moved",
    "velocity": "v, t -> dv = -M^-1 C_q^T (C_q M^-1 C_q^T)^-1 (C_q v - nu)",
    "acceleration": "v, t -> q_dot, v_dot, lam, free",
    "reaction": "lam, v_dot, free -> reactions",
    "coordinate": "q, v, v_dot -> coordinates",
    "energy": "q, v -> energies",
    "momentum": "q, v -> momenta",
    "check": "v, v_dot, t -> C_left_out, C_dot, C_ddot",
    "measure": "q, v -> measures",
}

#: Segments that a run calls and no evaluation: where the pivot monitor finds that many digits or
#: all were lost, where a run begins, and for events and kinks.
ON_DEMAND = {
    "refinement": "v, v_dot, t -> dv, the correction of v_dot, more_lam, more_power",
    "wrench": "all_lam -> wrenches, reactions",
    "setup": "parameters -> design: once, where a run begins",
    "switching": "span, parameters -> switches, features",
    "bending": "law_span, parameters -> laws",
    "distance": "t, measures, parameters -> lengths, distances",
    "crossing": "ranges, parameters -> crossings, breaks, poles, narrow, infinite",
}

#: The segments that read what ``geometry`` left; the others need regions only.
AFTER_GEOMETRY = frozenset(
    {
        *("position", "velocity", "acceleration", "reaction", "coordinate", "momentum", "check"),
        *("refinement", "wrench"),
    }
)


def meaning_of(program: Program, segment: Segment) -> str:
    """Regions that a segment reads and writes in this program."""
    if segment.meaning:
        return segment.meaning
    sides = []
    meanings = (SEGMENTS | ON_DEMAND)[segment.name].split(" -> ")
    for text, runs in zip(meanings, (_used, writes), strict=True):
        ranges = [range(base, base + n) for x in segment.tasks for base, n in runs(program, x)]
        slots = {slot for run in ranges for slot in run}
        used = {
            region.name
            for region in program.regions
            if not slots.isdisjoint(range(region.base, region.base + region.size))
        }
        idle = REGIONS.keys() - used
        sides.append(", ".join(part for part in text.split(", ") if part.split()[0] not in idle))
    return " -> ".join(filter(None, sides))


def reads(program: Program, task: Task) -> Iterator[tuple[int, int]]:
    """First slot and length of each run that a task reads."""
    lengths = (quantity.size for quantity in program.kernels[task.kernel].inputs)
    return zip(task.inputs, lengths, strict=True)


def _used(program: Program, task: Task) -> Iterator[tuple[int, int]]:
    """Runs that a task reads; of the whole workspace only the slots that it computes with."""
    if not program.is_inlined:
        return reads(program, task)
    nodes = program.kernels[task.kernel].nodes
    return ((node.symbol[1], 1) for node in nodes if node.symbol is not None)


def writes(program: Program, task: Task) -> Iterator[tuple[int, int]]:
    """First slot and length of each run that a task writes."""
    lengths = (quantity.size for quantity in program.kernels[task.kernel].outputs)
    return zip(task.outputs, lengths, strict=True)


def levels(program: Program, segment: Segment) -> tuple[tuple[int, ...], ...]:
    """Tasks of a segment by level: those of one level do not need each other.

    Returns
    -------
    tuple of tuple of int
        For each level the indices of its tasks in the segment, in the order of the segment.
    """
    level_of_slot: dict[int, int] = {}
    by_level: list[list[int]] = []
    for index, task in enumerate(segment.tasks):
        level = 0
        for base, length in reads(program, task):
            for slot in range(base, base + length):
                level = max(level, level_of_slot.get(slot, 0))
        for base, length in writes(program, task):
            for slot in range(base, base + length):
                level_of_slot[slot] = level + 1
        if level == len(by_level):
            by_level.append([])
        by_level[level].append(index)
    return tuple(tuple(tasks) for tasks in by_level)
