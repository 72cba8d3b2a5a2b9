"""System of bodies that a spatial scene becomes: numbered bodies, instances of kinds, forces.

Everything is in SI units. The frame of a body has its origin at the centre of mass and principal
axes, so that the mass matrix is constant and diagonal; the user's own frame is kept beside it.
The ground is body :data:`GROUND_INDEX`; its frame is frame O and it has no coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import COMBINATION, COORDINATES, is_length
from kousoku.model.records.design import CLOSURE_TOLERANCE

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Quaternion, Vector

GROUND_INDEX = -1


@dataclass(frozen=True, slots=True)
class MovingBody:
    """A rigid body, or a point.

    Parameters
    ----------
    name : str
        As in the scene.
    mass : float [kg]
        Its mass; zero where the scene gives none.
    inertia : (3,) [kg m²]
        Principal moments about the centre of mass; zeros of a point, and one zero of a rod without
        thickness.
    is_point : bool
        Whether it has a position only.
    r : (3,) [m]
        Centre of mass at the start, frame O.
    p : (4,) [-]
        Euler parameters of the principal frame at the start, of norm one, scalar first.
    v : (3,) [m/s]
        Velocity of the centre of mass at the start, frame O.
    omega_b : (3,) [rad/s]
        Angular velocity at the start, principal frame.
    origin_b : (3,) [m]
        Origin of the user's body frame, in the principal frame.
    axes_b : (4,) [-]
        Euler parameters that take components in the user's body frame to the principal frame.
    spins_in_o : bool
        Whether the scene gives the angular velocity in frame O, so that assembly keeps it there
        where it turns the body.
    """

    name: str
    mass: float
    inertia: Vector
    is_point: bool
    r: Vector
    p: Quaternion
    v: Vector
    omega_b: Vector
    origin_b: Vector
    axes_b: Quaternion
    spins_in_o: bool = False


@dataclass(frozen=True, slots=True)
class RelativeCoordinate:
    """A scalar quantity of two bodies: an angle or displacement, a distance, the place of a point.

    Parameters
    ----------
    name : str
        As in the scene; of a coordinate that a joint needs for itself the joint and its sort,
        such as ``screw.angle``.
    kind : str
        A shipped package whose residual is the value: ``angle`` [rad], which counts turns, ``n2``
        [m], a displacement along an axis of body i, ``length`` [m], the distance of two points, or
        ``n1``, the cosine between two axes.
    i, j : int
        Indices of the bodies, :data:`GROUND_INDEX` for the ground.
    constants : tuple of (str, tuple of float)
        The inputs of the kernels that are fixed, as of an :class:`Instance`.
    near : float
        Of an angle, a value within half a turn of the one that it has at the start [rad]; after
        assembly the value itself.
    """

    name: str
    kind: str
    i: int
    j: int
    constants: tuple[tuple[str, tuple[float, ...]], ...]
    near: float = 0.0

    @property
    def counts_turns(self) -> bool:
        """Whether it is an angle, which kernels know up to whole turns only."""
        return COORDINATES[self.kind].counts_turns

    @property
    def is_distance(self) -> bool:
        """Whether it is the distance of two points, which has no direction at zero."""
        return COORDINATES[self.kind].is_distance


@dataclass(frozen=True, slots=True)
class Term:
    """One coordinate in a linear combination.

    Parameters
    ----------
    coordinate : int
        Its index in :attr:`System.coordinates`.
    factor : float
        Its factor, in SI units and radians.
    """

    coordinate: int
    factor: float


@dataclass(frozen=True, slots=True)
class Instance:
    """A constraint of a kind between two bodies, or a linear combination of coordinates.

    The residual of a combination is Σ factor · coordinate + offset − law_unit · law(t): a gear has
    two terms and no law, a driver one term and a law.

    Parameters
    ----------
    joint : str
        The joint that it belongs to, as in the scene.
    kind : str
        A shipped package such as ``point``, ``n1``, ``p1_z``: its kernels ``constraint``, ``rates``
        and ``reaction`` are specialised. Of a kind of one's own the name of its kernels.
    i, j : int
        Indices of the bodies, :data:`GROUND_INDEX` for the ground.
    constants : tuple of (str, tuple of float)
        The inputs of the kernels that are fixed: ``a_i_b``, ``s_i_b``, ``a_j_b``, ``s_j_b`` in the
        principal frames (frame O for the ground), ``length``. Axes have norm one. Of a kind of
        one's own ``s_i_b`` and ``s_j_b`` are the points of its force, and its kernels take the
        frames that it is stated in, and its own inputs: see :mod:`kousoku.model.records.own_kind`.
    terms : tuple of Term
        Of a combination, its terms; i and j are then the bodies of the first.
    others : tuple of int
        Of a combination, the further bodies of its terms, each once.
    offset : float
        Of a combination, a number that is added, in its unit.
    law : str
        Of a driver, a formula of the time ``t`` and of parameters, in rad or the unit of the scene.
    law_unit : float
        Factor that takes the formula to ``unit``.
    unit : str
        Of a combination or a kind of one's own ``m`` or ``rad``: the unit of its residual.
    scale : float
        Of a combination, the ratio of its factors to those of the scene.
    """

    joint: str
    kind: str
    i: int
    j: int
    constants: tuple[tuple[str, tuple[float, ...]], ...] = ()
    terms: tuple[Term, ...] = ()
    others: tuple[int, ...] = ()
    offset: float = 0.0
    law: str = ""
    law_unit: float = 1.0
    unit: str = ""
    scale: float = 1.0

    @property
    def bodies(self) -> tuple[int, ...]:
        """The bodies that it connects, each once, the ground too: first i, then j."""
        return tuple(dict.fromkeys((self.i, self.j, *self.others)))

    @property
    def is_combination(self) -> bool:
        """Whether it combines coordinates, and has no kernels."""
        return self.kind == COMBINATION

    @property
    def row_unit(self) -> str:
        """Unit of its residual, ``m`` or ``rad``."""
        return self.unit or ("m" if is_length(self.kind) else "rad")

    @property
    def is_driver(self) -> bool:
        """Whether it depends on time."""
        return bool(self.law)


@dataclass(frozen=True, slots=True)
class ForceElement:
    """Force or torque beside gravity; :mod:`kousoku.model.elements` has a class for each kind.

    Its facets in a program, such as its equations and whether it leaves a plane, are in
    :mod:`kousoku.codegen.dynamics.elements`.

    Parameters
    ----------
    name : str
        As in the scene; a bushing is several elements of one name.
    kind : str
        Its name, that of the package of its kernels where it has one; each class has its own.
    i, j : int
        The two bodies; a force on one body alone acts on j, and i is the ground.
    constants : tuple of (str, tuple of float)
        Numbers, by names that its class knows. ``s_i_b`` and ``s_j_b`` [m] are points of bodies i
        and j in the principal frames, frame O for the ground; three numbers are a vector.
    law : str
        Tension, or the force against a coordinate, as a formula of
        :data:`~kousoku.model.expressions.formulas.LAW_NAMES` and parameters, in the unit of the
        scene; empty where linear.
    formulas : tuple of (str, str)
        Constants that are multiplied by a formula: name, and text. Of a spring it depends on
        parameters only, of a force or torque also on time ``t``, coordinates, and their rates with
        ``_dot`` behind the name, in the unit of the scene and rad.
    coordinate : int
        Index in :attr:`System.coordinates` of the one that it acts along or against.
    """

    name: str
    kind: str = field(init=False, default="")
    i: int
    j: int
    constants: tuple[tuple[str, tuple[float, ...]], ...]
    law: str = ""
    formulas: tuple[tuple[str, str], ...] = ()
    coordinate: int = -1

    @property
    def has_potential(self) -> bool:
        """Whether work of it is potential energy."""
        return False

    @property
    def is_nonconservative(self) -> bool:
        """Whether it does work that is no potential energy: dampers, and forces that change."""
        damping = dict(self.constants).get("damping", (0.0,))
        return not self.has_potential or damping != (0.0,)

    @property
    def is_torque(self) -> bool:
        """Whether it is a torque on a body."""
        return False

    @property
    def needs_direction(self) -> bool:
        """Whether it acts along the distance of its own points, and has no direction at zero."""
        return False


@dataclass(frozen=True, slots=True)
class Carried:
    """A body of the scene, and the body that carries it: bodies joined rigidly are one.

    Parameters
    ----------
    name : str
        As in the scene.
    carrier : int
        The body of the system that it moves with, :data:`GROUND_INDEX` where it stands still.
    is_point : bool
        Whether it has a position only.
    origin_b : (3,) [m]
        Origin of the user's body frame, in the principal frame of the carrier.
    axes_b : (4,) [-]
        Euler parameters that take components in the user's body frame to that principal frame.
    """

    name: str
    carrier: int
    is_point: bool
    origin_b: Vector
    axes_b: Quaternion


@dataclass(frozen=True, slots=True)
class WrittenStart:
    """A body of the scene at the start, as it is written.

    Parameters
    ----------
    position : (3,) [unit of the scene], or (0,)
        Of the origin of the user's body frame, frame O; empty where assembly holds positions.
    orientation : (4,) [-]
        Euler parameters of that frame.
    velocity : (3,) [unit of the scene per s]
        Of that origin, frame O.
    spin : (3,) [rad/s]
        Angular velocity.
    is_in_o : bool
        Whether its components are in frame O, not in the user's body frame.
    mass_properties : (11,)
        Mass [kg], principal moments [kg m²], and of its own principal frame ``origin_b`` [m] and
        ``axes_b`` as of a :class:`MovingBody`, also where another body carries it.
    """

    position: tuple[float, ...]
    orientation: Quaternion
    velocity: Vector
    spin: Vector
    is_in_o: bool
    mass_properties: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SystemEvent:
    """A formula that passes zero, and the action of a run then.

    Parameters
    ----------
    name : str
        As in the scene.
    when : str
        The formula: of time, parameters, coordinates and their rates, in the unit of the scene.
    direction : int
        1 where it must rise, -1 where it must fall, 0 where either counts.
    action : str
        ``record``, ``count`` or ``stop``.
    """

    name: str
    when: str
    direction: int
    action: str


@dataclass(frozen=True, slots=True)
class System:
    """A spatial scene, ready to be specialised.

    Parameters
    ----------
    name : str
        The scene.
    unit : float [m]
        Length of the scene's unit; results are given in it.
    bodies : tuple of MovingBody
        In the order of the scene; their coordinates stand in this order.
    constraints : tuple of Instance
        Joint by joint, in the order of the scene.
    gravity : (3,) [m/s²]
        Acceleration of free fall, frame O.
    gravity_law : (3,) str
        Components that are formulas of parameters, in the unit of the scene; the others are empty.
    held : tuple of Instance
        Positions that assembly keeps, as constraints with the ground that hold at the start;
        ``joint`` is the key in the scene.
    held_rates : tuple of Instance
        Velocities that it keeps: constraints whose rates do not change.
    forces : tuple of ForceElement
        Forces and torques beside gravity, in the order of the scene.
    coordinates : tuple of RelativeCoordinate
        Those that constraints, forces or outputs need, then those that are only held.
    shown : tuple of int
        Indices of the coordinates that are outputs, in the order of the scene.
    parameters : tuple of (str, float)
        Names that formulas may use, and their values unless a run gives others.
    carried : tuple of Carried
        All bodies of the scene, in its order, where some of them were joined to one body; empty
        where each is a body of its own.
    static_potential : float [J]
        Potential energy of bodies and forces that stand still, and are left out.
    only_held : int
        Count of the coordinates, the last ones, that only held values need.
    positive : tuple of (str, float)
        Keys of the scene whose numbers depend on parameters and must be positive, and the numbers.
    closure_tolerance : float [lengths of the scene, rad]
        Rows of joints that others imply within it are redundant.
    events : tuple of SystemEvent
        In the order of the scene.
    written_starts : tuple of WrittenStart
        All bodies of the scene, in its order, where the start depends on parameters; else empty.
    """

    name: str
    unit: float
    bodies: tuple[MovingBody, ...]
    constraints: tuple[Instance, ...]
    gravity: Vector = (0.0, 0.0, 0.0)
    held: tuple[Instance, ...] = ()
    held_rates: tuple[Instance, ...] = ()
    forces: tuple[ForceElement, ...] = ()
    coordinates: tuple[RelativeCoordinate, ...] = ()
    shown: tuple[int, ...] = ()
    parameters: tuple[tuple[str, float], ...] = ()
    gravity_law: tuple[str, str, str] = ("", "", "")
    carried: tuple[Carried, ...] = ()
    static_potential: float = 0.0
    only_held: int = 0
    positive: tuple[tuple[str, float], ...] = ()
    closure_tolerance: float = CLOSURE_TOLERANCE
    events: tuple[SystemEvent, ...] = ()
    written_starts: tuple[WrittenStart, ...] = ()

    def has_gravity(self, axis: int) -> bool:
        """Whether gravity has a component along an axis, or may have one."""
        return self.gravity[axis] != 0.0 or bool(self.gravity_law[axis])
