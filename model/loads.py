"""What acts on the bodies of a spatial mechanism beside gravity, as a scene describes it."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
import msgspec

from kousoku.model.spatial import Components, Value, Vector


class Force(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A force, a torque, or a spring and damper between two points.

    Forces are in kg times the unit of the scene per s², torques in kg times its square per s².
    Components may be formulas of time ``t``, parameters, coordinates and their rates, such as
    ``"-0.1*hinge_dot"``; what belongs to a spring may be a formula of parameters.

    Parameters
    ----------
    type : str
        ``force``, ``torque`` or ``spring_damper``.
    body : str, optional
        The body that a force or torque acts on.
    point : (3,) [unit of the scene], optional
        Where a force acts, in the body frame; its origin when left out.
    force : (3,) [kg unit/s²], optional
        A force in frame O.
    force_b : (3,) [kg unit/s²], optional
        A force that turns with the body, in the body frame.
    torque : (3,) [kg unit²/s²], optional
        A torque in frame O.
    torque_b : (3,) [kg unit²/s²], optional
        A torque that turns with the body, in the body frame.
    bodies : (str, str), optional
        Of a spring: body i and body j; ``ground`` is the fixed body.
    points : ((3,), (3,)) [unit of the scene], optional
        The ends of a spring in the frame of body i and in that of body j.
    stiffness : float or str [kg/s²]
        Tension of a spring by its elongation; the same number as in N/m.
    damping : float or str [kg/s]
        Tension of a damper by the rate of elongation; the same number as in N s/m.
    tension : str, optional
        Tension of a spring as a formula of its elongation ``x``, the rate ``v`` of its length, time
        ``t`` and parameters, in the unit of the scene, instead of stiffness and damping; a positive
        tension draws the ends together.
    free_length : float or str [unit of the scene], optional
        Length of a spring without tension; the distance of its ends, as the positions are written,
        when left out.
    """

    type: str
    body: str | None = None
    point: Vector | None = None
    force: Components | None = None
    force_b: Components | None = None
    torque: Components | None = None
    torque_b: Components | None = None
    bodies: tuple[str, str] | None = None
    points: tuple[Vector, Vector] | None = None
    stiffness: Value | None = None
    damping: Value | None = None
    tension: str | None = None
    free_length: Value | None = None
