"""Motion of a scene of bodies: the result of a run, made of the rows of a solver."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..messages import listed, missing, not_generated, scene_key
from .assembled_start import WrittenBody
from .body_tables import BodyPlaces, body_tables, written_state
from .euler_parameters import crossed, rotated
from .events import EventLog, EventOccurrences
from .result import Column, Coordinates, Named, Result

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array
    from .result import Ledger
    from .trust import Trust

#: The tables of a body, of a joint, of a coordinate, and the letters of their columns.
BODY = {
    "position": ("x", "y", "z"),
    "orientation": ("e0", "e1", "e2", "e3"),
    "velocity": ("vx", "vy", "vz"),
    "angular_velocity": ("omega_x", "omega_y", "omega_z"),
    "acceleration": ("ax", "ay", "az"),
    "angular_acceleration": ("alpha_x", "alpha_y", "alpha_z"),
}
JOINT = {"force": ("fx", "fy", "fz"), "torque": ("mx", "my", "mz")}
COORDINATE = {"coordinate": "", "coordinate_rate": "_dot", "coordinate_acceleration": "_ddot"}
#: For each table its unit, u standing for that of the scene, and which output it comes with.
UNITS = {
    **{"position": "u", "velocity": "u/s", "acceleration": "u/s²"},
    **{"orientation": "-", "angular_velocity": "rad/s", "angular_acceleration": "rad/s²"},
    **{"force": "kg u/s²", "torque": "kg u²/s²", "energy": "kg u²/s²", "work": "kg u²/s²"},
    **{"coordinate": "u", "coordinate_rate": "u/s", "coordinate_acceleration": "u/s²"},
}
OUTPUTS = {
    **dict.fromkeys(("acceleration", "angular_acceleration"), "accelerations"),
    **dict.fromkeys(JOINT, "reactions"),
    **dict.fromkeys(("energy", "work"), "energies"),
    **dict.fromkeys(COORDINATE, "coordinates"),
    "coordinate_acceleration": "accelerations",
}
#: Outputs, and the part of a row that has them.
PARTS_OF_ROWS = {
    "accelerations": "v_dot",
    "coordinates": "coordinates",
    "reactions": "reactions",
    "energies": "energies",
}
#: Units with a name of their own in metres.
IN_METRES = {"force": "N", "torque": "N m", "energy": "J", "work": "J"}


@dataclass(frozen=True, slots=True)
class ReactionPlaces:
    """Places of the force and torque of a joint among the reactions of a row.

    Parameters
    ----------
    joint : str
        As in the scene; of a driver its name.
    body : int
        The body that they act on, at its centre of mass.
    j : int
        Body j of the joint, -1 for the ground; if it is the ground they act on body i.
    point_b : (3,) [m]
        The joint's point in the principal frame of body j, or in frame O.
    columns : (6,) tuple of int
        Places of force (frame O) and torque (principal frame), -1 where there is no coordinate.
    """

    joint: str
    body: int
    j: int
    point_b: tuple[int | float, ...]
    columns: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Layout:
    """Layout of a row, as ``motion.json`` says.

    Parameters
    ----------
    name : str
        The scene.
    unit, unit_name : float [m], str
        Its unit of length.
    bodies : tuple of BodyPlaces
        In the order of the scene.
    sizes : dict of str to int
        How many numbers a row has of each part, in order: t, q, v, then what is wanted.
    reactions : tuple of ReactionPlaces
        Where the forces of joints and drivers stand.
    not_unique : tuple of str
        Joints whose forces the motion does not determine.
    undetermined : tuple of (str, tuple of str)
        Of these the components that it does not determine, all of those left out here.
    checked : tuple of str
        All joints, and drivers with ``drivers.`` before their names.
    coordinates : tuple of (str, bool, list of int)
        Name, whether it is a length, places of value, rate and maybe second derivative.
    works : tuple of (str, int)
        Forces and drivers that do work that is no potential energy, and where it stands in q.
    is_flat : bool
        Whether all lies in one plane, so that no force leads out of it.
    length : float [m]
        A length of the scene: corrections are compared with it, and torques weighed by it.
    closure_tolerance : float
        What rows that are left out may miss, relative to that length, or in radians.
    notes : tuple of str
        What the user of the scene may not expect, such as what assembly changed.
    duration : float [s], optional
        How long the scene moves unless a run says so.
    jumps : tuple of str
        Keys of forces that jump where a ``sign`` in their formula changes.
    events : tuple of (str, str)
        Name and action of each event.
    whens : tuple of str
        Their formulas.
    led : tuple of str
        Drivers whose laws are no polynomials.
    drawn : tuple of str
        Drivers of distances.
    poles : tuple of str
        For each function that is zero where a force may be infinite the key of that force.
    given : tuple of WrittenBody
        Where the scene has its bodies and how they move, where parameters may change its start.
    driven : tuple of str
        Coordinates that drivers determine, alone or by gears, screws and couplings.
    """

    name: str
    unit: float
    unit_name: str
    bodies: tuple[BodyPlaces, ...]
    sizes: dict[str, int]  # a saved run is read by these annotations
    reactions: tuple[ReactionPlaces, ...]
    not_unique: tuple[str, ...]
    checked: tuple[str, ...]
    coordinates: tuple[tuple[str, bool, list[int]], ...]
    works: tuple[tuple[str, int], ...]
    is_flat: bool
    length: float
    closure_tolerance: float
    notes: tuple[str, ...] = ()
    duration: float | None = None
    jumps: tuple[str, ...] = ()
    events: tuple[tuple[str, str], ...] = ()
    whens: tuple[str, ...] = ()
    led: tuple[str, ...] = ()
    drawn: tuple[str, ...] = ()
    poles: tuple[str, ...] = ()
    undetermined: tuple[tuple[str, tuple[str, ...]], ...] = ()
    given: tuple[WrittenBody, ...] = ()
    driven: tuple[str, ...] = ()

    @property
    def has_drivers(self) -> bool:
        """Whether anything is driven."""
        return any(name.startswith("drivers.") for name in self.checked)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Layout:
        """Layout of a motion, from ``motion.json``."""
        return cls(
            name=data["name"],
            unit=data["unit"],
            unit_name=data["unit_name"],
            bodies=tuple(map(BodyPlaces.from_data, data["bodies"])),
            sizes={"t": 1, "q": len(data["q"]), "v": len(data["v"]), **dict(data["parts"])},
            reactions=tuple(
                ReactionPlaces(**entry | {k: tuple(entry[k]) for k in ("point_b", "columns")})
                for entry in data["reactions"]
            ),
            not_unique=tuple(data["not_unique"]),
            undetermined=tuple((name, tuple(columns)) for name, columns in data["undetermined"]),
            checked=tuple(data["checked"]),
            coordinates=tuple(
                (item["name"], item["is_length"], item["columns"]) for item in data["coordinates"]
            ),
            works=tuple((name, index) for name, index in data["works"]),
            is_flat=data["is_flat"],
            length=data["length"],
            closure_tolerance=data["closure_tolerance"],
            notes=tuple(data["notes"]),
            duration=data["duration"],
            jumps=tuple(data["jumps"]),
            events=tuple((name, action) for name, action in data["events"]),
            whens=tuple(data["whens"]),
            led=tuple(data["led"]),
            drawn=tuple(data["drawn"]),
            poles=tuple(data["poles"]),
            given=tuple(map(WrittenBody.from_data, data.get("given", ()))),
            driven=tuple(data.get("driven", ())),
        )

    def at(self, design: Array) -> Layout:
        """Layout with numbers of the design (n,) [SI] in place of their indices."""

        def fixed(numbers: Sequence[float]) -> tuple[float, ...]:
            return tuple(float(design[x]) if isinstance(x, int) else x for x in numbers)

        return replace(
            self,
            bodies=tuple(
                replace(body, origin_b=fixed(body.origin_b), axes_b=fixed(body.axes_b))
                for body in self.bodies
            ),
            reactions=tuple(replace(r, point_b=fixed(r.point_b)) for r in self.reactions),
            given=tuple(
                replace(body, mass_properties=fixed(body.mass_properties)) for body in self.given
            ),
        )

    def parts(self, rows: Array) -> dict[str, Array]:
        """Parts (n, size) of rows (n, row_size) by name, in SI units: views."""
        columns, first = {}, 0
        for name, size in self.sizes.items():
            columns[name] = rows[:, first : first + size]
            first += size
        return columns

    def of_joint(self, joint: ReactionPlaces, q: Array, reactions: Array) -> tuple[Array, Array]:
        """Force F and torque A M′ + (r − s) × F on body j at the joint's point s, in frame O.

        Parameters
        ----------
        joint : ReactionPlaces
            Where F (frame O) and M′ (principal frame), which act at the centre of mass r, stand.
        q : (n, nq) array
            Coordinates, in SI units.
        reactions : (n, m) array [N, N m]
            What rows have of reactions.

        Returns
        -------
        force, torque : (n, 3) array [N, N m]
            The opposite of what acts on body i where body j is the ground.
        """
        body, sign = self.bodies[joint.body], -1.0 if joint.j < 0 else 1.0
        wrench = [reactions[:, k] if k >= 0 else np.zeros(len(reactions)) for k in joint.columns]
        force, torque = sign * np.stack(wrench[:3]), sign * np.stack(wrench[3:])
        if body.p:
            torque = rotated(_columns(body.p, q), torque)
        torque = torque + crossed(_columns(body.r, q) - self.point_of(joint, q), force)
        if not self.is_flat:  # of a planar body, what leads out of the plane is not computed
            force[[k < 0 for k in joint.columns[:3]]] = np.nan
            if body.p:
                torque[[k < 0 for k in joint.columns[3:]]] = np.nan
        return force.T, torque.T

    def point_of(self, joint: ReactionPlaces, q: Array) -> Array:
        """Point r + A s′ (3, n) [m] at which force and torque of a joint are taken, in frame O.

        q (n, nq) is in SI units; of the ground s′ is in frame O itself.
        """
        point = np.broadcast_to(np.array([joint.point_b]).T, (3, len(q)))
        if joint.j < 0:
            return point
        body = self.bodies[joint.j]
        arm = rotated(_columns(body.p, q), point) if body.p else 0.0
        return _columns(body.r, q) + arm


def _columns(places: Sequence[int | float], q: Array) -> Array:
    return np.stack([q[:, k] if isinstance(k, int) else np.full(len(q), k) for k in places])


class Motion(Result):
    """Positions and velocities of bodies at the times that were asked for.

    Parameters
    ----------
    layout : Layout
        What stands where in a row.
    rows : (n, ·) array
        The rows: time, q, v, then what is wanted.
    target : {"c", "numpy"}
        What computed.
    method : str
        How it was integrated.
    ledger : callable or RunLedger, optional
        What the run cost, or what returns it when it is read.
    parameters : mapping of str to float, optional
        All parameters of the scene, with their values in this run.
    is_complete : bool
        Whether all times are there.
    trust : Trust, optional
        The verdict where there is no ledger, which has it.
    told : EventLog, optional
        What is told of events.

    Attributes
    ----------
    position : mapping of str to (n, 3) array
        Origin of each body's frame.
    orientation : mapping of str to (n, 4) array
        Euler parameters of each body's frame, scalar first; points have none.
    velocity : mapping of str to (n, 3) array
        Of the origin.
    angular_velocity : mapping of str to (n, 3) array [rad/s]
        Components in the body's frame.
    acceleration, angular_acceleration : mapping of str to (n, 3) array
        Their time derivatives; empty unless wanted.
    force, torque : mapping of str to (n, 3) array
        What each joint and driver does to its body j, at its point of body j [kg unit/s²,
        kg unit²/s²]; body i gets the opposite. A body that hangs on its joint j is pulled upward:
        the force is against gravity. Empty unless wanted. In a scene that moves in a plane, and
        does not lie in it, what leads out of the plane is not computed, and NaN.
    energy : mapping of str to (n,) array
        ``kinetic``, ``potential`` and their sum ``total`` [kg unit²/s²]; empty unless wanted.
    work : mapping of str to (n,) array
        What each force without potential and each driver has done since the start, and the damper
        of each spring [kg unit²/s²]; empty unless energies are wanted. The total energy changes by
        their sum.
    coordinate, coordinate_rate : mapping of str to (n,) array
        Value and rate of each coordinate of the scene: lengths, or angles [rad] with the turns that
        they have made; empty unless wanted.
    coordinate_acceleration : mapping of str to (n,) array
        Their second derivatives; empty unless accelerations are wanted, too.
    """

    PARTS: ClassVar = {
        "body": {name: name for name in BODY},
        "joint": {name: name for name in JOINT},
        "driver": {name: name for name in JOINT},
    }

    def __init__(
        self,
        layout: Layout,
        rows: Array,
        *,
        target: str,
        method: str,
        ledger: Any = None,
        parameters: Mapping[str, float] | None = None,
        is_complete: bool = True,
        trust: Trust | None = None,
        told: Any = None,
    ) -> None:
        self.layout, self.rows, self._ledger, self._trust = layout, rows, ledger, trust
        self._parameters = dict(parameters or {})
        self._tables: dict[str, Any] = {}
        self._told = told
        self.name, self.unit = layout.name, layout.unit_name
        self.target, self.method, self.is_complete = target, method, is_complete

    def __getstate__(self) -> dict[str, Any]:
        """State to pickle: rows, not the tables that are made of them."""
        ledger = None if self._ledger is None else self.ledger
        state = {key: value for key, value in self.__dict__.items() if key != "places"}
        return state | {"_tables": {}, "_ledger": ledger, "_told": self.told}

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def time(self) -> Array:
        """Times (n,) [s]."""
        return self.rows[:, 0]

    @property
    def told(self) -> EventLog:
        """Log of events: how often each came to pass, and the rows of those that are recorded."""
        if self._told is None:
            self._told = EventLog((), np.empty((0, 1 + self.rows.shape[1])))
        if callable(self._told):
            self._told = self._told()
        log: EventLog = self._told
        return log

    @property
    def ledger(self) -> Ledger:
        """Ledger of the run, its cost and how far it can be trusted: a ``RunLedger``."""
        if self._ledger is None:
            raise missing(f"{self.name}: no ledger: install kousoku, which keeps it")
        if callable(self._ledger):
            self._ledger = self._ledger()
        ledger: Ledger = self._ledger
        return ledger

    @property
    def parameters(self) -> Mapping[str, float]:
        """The parameters of the run."""
        return Named(self._parameters, f"{self.name}: no parameter")

    @property
    def events(self) -> Mapping[str, EventOccurrences]:
        """The events of the scene: how often each was, when, and the states there."""
        occurrences = {}
        for k, (name, action) in enumerate(self.layout.events):
            rows = self.told.rows[self.told.rows[:, 0] == k, 1:]
            states = Motion(
                self.layout,
                rows,
                target=self.target,
                method=self.method,
                parameters=self._parameters,
            )
            count = self.told.counts[k] if self.told.counts else 0
            occurrences[name] = EventOccurrences(name, action, count, states)
        return Named(occurrences, f"{self.name}: no event", f"{self.name}: it has no events")

    @property
    def stopped_by(self) -> str:
        """The event that ended the run; empty where none did."""
        if not len(self.told.rows):
            return ""
        name, action = self.layout.events[int(self.told.rows[-1, 0])]
        return name if action == "stop" else ""

    def _end(self) -> str:
        """Line on the event that ended the run, empty where none did."""
        by = self.stopped_by
        return f"ended at t = {self.time[-1]:.9g} s by events.{by}" if by else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for a reader before he trusts the numbers, a line each."""
        return tuple(filter(None, [*self.layout.notes, self.note(), self._end()]))

    def main_columns(self, of: str | None = None) -> list[str]:
        """Columns that are shown where none are named.

        Coordinates and their rates, else what moves of the last body that does; of a body what
        moves of it.
        """
        shown = [name + ending for name, *_ in self.layout.coordinates for ending in ("", "_dot")]
        if shown and of is None:
            return shown
        bodies = [of] if of else self._names("body")[::-1]
        groups = [[f"{body}.{letter}" for letter in BODY["position"]] for body in bodies]
        groups += [[x for x in self.places if x.startswith(f"{body}.")] for body in bodies]
        moving = (self._moving(group, self.reaction_length) for group in groups)
        return next(filter(None, moving), groups[0])

    @property
    def not_unique(self) -> tuple[str, ...]:
        """Joints whose force and torque the motion does not determine.

        Constraints depend on each other there. What they have is the least that moves all bodies
        so: Σ |force|² + |torque|²/ℓ² over the joints of such constraints is as small as can be.
        """
        return self.layout.not_unique

    @property
    def undetermined(self) -> dict[str, tuple[str, ...]]:
        """Columns of force and torque that the motion does not determine, by such joints."""
        known, every = dict(self.layout.undetermined), (*JOINT["force"], *JOINT["torque"])
        return {name: known.get(name, every) for name in self.not_unique}

    @property
    def reaction_length(self) -> float:
        """ℓ, a length of the scene, in its unit."""
        return self.layout.length / self.layout.unit

    def _names(self, sort: str) -> Sequence[str]:
        if sort == "body":
            return [body.name for body in self.layout.bodies]
        drivers = [name[8:] for name in self.layout.checked if name.startswith("drivers.")]
        joints = [name for name in self.layout.checked if not name.startswith("drivers.")]
        if self.layout.reactions:  # those too of several bodies: gear.wheel
            named = [reaction.joint for reaction in self.layout.reactions]
            both = [[x for x in named if x.partition(".")[0] in own] for own in (joints, drivers)]
            joints, drivers = both
        return joints if sort == "joint" else drivers

    def __getattr__(self, name: str) -> Any:
        """Table, made of the rows when it is first read."""
        if name.startswith("_") or name not in UNITS:
            is_column = "layout" in vars(self) and name in self.places
            hint = f"; it is a column: run[{name!r}]" if is_column else ""
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}{hint}")
        if name not in self._tables:
            self._make(name)
        values = self._tables[name]
        for table in values.values():
            table.flags.writeable = False  # nobody can write to what others read
        sort = "bodies" if name in BODY else "joints" if name in JOINT else "the scene"
        label, output = f"{name.replace('_', ' ')} of {sort}", OUTPUTS.get(name)
        if output is None or PARTS_OF_ROWS[output] in self.layout.sizes:
            return Named(values, f"{self.name}: no {label}")
        return Named(values, advice=f"{self.name}: {not_generated(label, output)}")

    def _make(self, name: str) -> None:
        layout, tables = self.layout, self._tables
        parts = layout.parts(self.rows)
        if name in BODY:
            tables |= {key: {} for key in BODY}
            v_dot = parts.get("v_dot")
            tables |= body_tables(layout.bodies, parts["q"], parts["v"], v_dot, layout.unit)
        elif name in JOINT:
            pairs = {
                joint.joint: layout.of_joint(joint, parts["q"], parts["reactions"])
                for joint in layout.reactions
            }
            tables["force"] = {name: force / layout.unit for name, (force, _) in pairs.items()}
            tables["torque"] = {name: m / layout.unit**2 for name, (_, m) in pairs.items()}
        elif name in COORDINATE:
            k = [*COORDINATE].index(name)
            tables[name] = {
                key: parts["coordinates"][:, columns[k]] / (layout.unit if is_length else 1.0)
                for key, is_length, columns in layout.coordinates
                if k < len(columns)
            }
        else:
            tables |= {"energy": {}, "work": {}}
            if "energies" in parts:
                kinetic, potential = parts["energies"].T / layout.unit**2
                total = kinetic + potential
                tables["energy"] = {"kinetic": kinetic, "potential": potential, "total": total}
                tables["work"] = {
                    name: parts["q"][:, index] / layout.unit**2 for name, index in layout.works
                }

    @cached_property
    def places(self) -> dict[str, Column]:
        """Places of the columns, in order."""
        layout, by_name = self.layout, {"time": Column("time", "", None, "s")}

        def unit_of(table: str) -> str:
            si_unit = IN_METRES.get(table) if self.unit == "m" else None
            return si_unit or UNITS[table].replace("u", self.unit, 1)

        def add(table: str, owner: str, letters: Sequence[str]) -> None:
            for k, letter in enumerate(letters):
                by_name[f"{owner}.{letter}"] = Column(table, owner, k, unit_of(table))

        for body in layout.bodies:
            for table, letters in BODY.items():
                turns = bool(body.p) or table in {"position", "velocity", "acceleration"}
                if turns and ("v_dot" in layout.sizes or table not in OUTPUTS):
                    add(table, body.name, letters)
        for joint in layout.reactions:
            for table, letters in JOINT.items():
                add(table, joint.joint, letters)
        if "energies" in layout.sizes:
            for name in ("kinetic", "potential", "total"):
                by_name[f"energy.{name}"] = Column("energy", name, None, unit_of("energy"))
            for name, _ in layout.works:
                by_name[f"work.{name}"] = Column("work", name, None, unit_of("work"))
        for name, is_length, columns in layout.coordinates:
            for (table, ending), _ in zip(COORDINATE.items(), columns, strict=False):
                unit = unit_of(table) if is_length else UNITS[table].replace("u", "rad")
                by_name[name + ending] = Column(table, name, None, unit)
        return by_name

    def _no_column(self, name: object) -> str:
        """Say which output has a column that is not there, or which columns there are."""
        owner, _, letter = str(name).rpartition(".")
        for table, letters in (BODY | JOINT).items():
            sort = "body" if table in BODY else "joint"
            if letter in letters and owner in (*self._names(sort), *self._names("driver")):
                try:
                    getattr(self, table)[owner]
                except KeyError as error:
                    return str(error).removeprefix(f"{self.name}: ")
        if owner == "energy" and not self.energy:
            return not_generated("energies", "energies")
        advice = (
            "" if "coordinates" in self.layout.sizes else not_generated("coordinate", "coordinates")
        )
        return super()._no_column(name) + f"; {advice}" * bool(advice)

    @property
    def drivers(self) -> Sequence[str]:
        """The drivers."""
        return self._names("driver")

    def center_of_mass(self, body: str) -> Array | None:
        """Path of the centre of mass of a body, None where it is one with others.

        Returns
        -------
        (n, 3) array [unit], frame O
            The path.
        """
        bodies = self.layout.bodies
        chosen = next(candidate for candidate in bodies if candidate.name == body)
        if sum(candidate.r == chosen.r for candidate in bodies) > 1:
            return None
        return _columns(chosen.r, self.layout.parts(self.rows)["q"]).T / self.layout.unit

    def _state(self, k: int) -> tuple[Array, Array]:
        """Coordinates q and velocities v of a row: of bodies in their own frames."""
        parts = self.layout.parts(self.rows[k : k + 1 or None])
        inner = parts["q"][0]
        q, v = written_state(self.layout.bodies, inner, parts["v"][0], self.layout.unit)
        return Coordinates(q, self.parameters, inner), v

    def _first(self) -> Motion:
        """Motion of the first row alone."""
        return Motion(self.layout, self.rows[:1], target=self.target, method=self.method)

    def summary(self) -> dict[str, object]:
        """Summary for programs, ready for JSON."""
        return {
            "scene": self.name,
            "target": self.target,
            "rows": len(self),
            "bodies": self._names("body"),
            "is_complete": self.is_complete,
            "stopped_by": self.stopped_by,
            "events": {
                name: {"action": event.action, "count": event.count, "times": event.time.tolist()}
                for name, event in self.events.items()
            },
            "not_unique": list(self.not_unique),
            "undetermined": {name: list(columns) for name, columns in self.undetermined.items()},
            "reaction_length": self.reaction_length,
            "notes": list(self.notes),
            "trust": self.ledger.trust.as_data(),
            "ledger": self.ledger.as_data(),
        }

    def note(self) -> str:
        """Line on forces that are not unique, empty where all are."""
        if not self.not_unique:
            return ""
        joints: dict[tuple[str, ...], list[str]] = {}
        for name, columns in self.undetermined.items():
            joints.setdefault(columns, []).append(scene_key(name))
        texts = [
            f"{'force and torque' if len(columns) == 6 else ', '.join(columns)} of {listed(names)}"
            for columns, names in joints.items()
        ]
        return (
            f"not unique: {'; '.join(texts)}; those with the least Σ|F|² + |M|²/ℓ² are"
            f" given, ℓ = {self.reaction_length:.6g} in the unit of the scene"
        )

    @property
    def verdict(self) -> str:
        """Verdict on the run in a line, the first of its ledger; empty if unknown."""
        trust = self._trust if self._ledger is None else self.ledger.trust
        return "" if trust is None else str(trust)

    def _verdict(self) -> list[str]:
        """Line on how far the run can be trusted, where it is known."""
        return [self.verdict] if self.verdict else []

    def _extent(self) -> str:
        if not len(self):
            return "no rows"
        stopped = "" if self.is_complete else ", stopped before its end"
        stopped = f", {self._end()}" if self.stopped_by else stopped
        return (
            f"{len(self)} row{'s' * (len(self) > 1)} from {self.time[0]:g} to"
            f" {self.time[-1]:g} s{stopped}; {self.unit}, kg, s, rad;"
            f" {self.method} in {self.target}"
        )
