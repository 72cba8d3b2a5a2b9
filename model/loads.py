"""What acts on the bodies of a spatial mechanism beside gravity, as a scene describes it."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
import msgspec

from kousoku.model.spatial import Vector


class Force(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A force, a torque, or a spring and damper between two points.

    Forces are in kg times the unit of the scene per s², torques in kg times its square per s².

    Parameters
    ----------
    type : str
        ``force``, ``torque`` or ``spring_damper``.
    body : str, optional
        The body that a force or torque acts on.
    point : (3,) [unit of the scene], optional
        Where a force acts, in the body frame; its origin when left out.
    force : (3,) [kg unit/s²], optional
        A constant force in frame O.
    force_b : (3,) [kg unit/s²], optional
        A force that turns with the body, in the body frame.
    torque : (3,) [kg unit²/s²], optional
        A constant torque in frame O.
    torque_b : (3,) [kg unit²/s²], optional
        A torque that turns with the body, in the body frame.
    bodies : (str, str), optional
        Of a spring: body i and body j; ``ground`` is the fixed body.
    points : ((3,), (3,)) [unit of the scene], optional
        The ends of a spring in the frame of body i and in that of body j.
    stiffness : float [kg/s²]
        Tension of a spring by its elongation; the same number as in N/m.
    damping : float [kg/s]
        Tension of a damper by the rate of elongation; the same number as in N s/m.
    tension : str, optional
        Tension of a spring as a formula of its elongation ``x``, the rate ``v`` of its length and
        time ``t``, in the unit of the scene, instead of stiffness and damping; a positive tension
        draws the ends together.
    free_length : float [unit of the scene], optional
        Length of a spring without tension; the distance of its ends, as the positions are written,
        when left out.
    """

    type: str
    body: str | None = None
    point: Vector | None = None
    force: Vector | None = None
    force_b: Vector | None = None
    torque: Vector | None = None
    torque_b: Vector | None = None
    bodies: tuple[str, str] | None = None
    points: tuple[Vector, Vector] | None = None
    stiffness: float | None = None
    damping: float | None = None
    tension: str | None = None
    free_length: float | None = None
