"""Forces and torques on the bodies of a spatial mechanism beside gravity, as in a scene."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from collections.abc import Mapping
from typing import Any, ClassVar

import msgspec

from kousoku.model.records.design import DesignVector
from kousoku.model.records.spatial import Components, Free, Value

Six = tuple[Value, Value, Value, Value, Value, Value]
"""Six numbers: along three directions, then about them."""


class Force(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A force, a torque, or a spring and damper.

    Forces are in kg times the unit of the scene per s², torques in kg times its square per s².
    Components may be formulas of time ``t``, parameters, coordinates and their rates, such as
    ``"-0.1*hinge_dot"``; what belongs to a spring may be a formula of parameters.

    Parameters
    ----------
    type : str
        ``force``, ``torque``, ``spring_damper``, ``rotational_spring_damper``, ``along``,
        ``friction`` or ``bushing``.
    body : str, optional
        The body that a force or torque acts on.
    point : (3,) [unit of the scene], optional
        Where a force acts, in the body frame; its origin when left out.
    force : (3,) [kg unit/s²], or str, optional
        A force in frame O; of ``along`` one formula, which drives the coordinate: a force in
        kg unit/s², of an angle a moment in kg unit²/s².
    force_b : (3,) [kg unit/s²], optional
        A force that turns with the body, in the body frame.
    torque : (3,) [kg unit²/s²], optional
        A torque in frame O.
    torque_b : (3,) [kg unit²/s²], optional
        A torque that turns with the body, in the body frame.
    bodies : (str, str), optional
        Of a spring or a bushing: body i and body j; ``ground`` is the fixed body.
    points : ((3,), (3,)) [unit of the scene], optional
        The ends of a spring, or the middle of a bushing, in the frame of body i and of body j.
    at : (3,) [unit of the scene], optional
        The middle of a bushing in frame O, the same of both bodies as they are written.
    axes : ((3,), (3,)), optional
        Of a bushing, its first direction in frame O and one that its second is nearest to; the axes
        of frame O when left out. They are fixed in body i.
    joint : str, optional
        The joint whose angle a rotational spring acts on; of friction the joint that it is in.
    coordinate : str, optional
        The coordinate that a force acts along; of a rotational spring instead of its joint.
    of : {"angle", "second_angle", "displacement", "second_displacement"}, optional
        Of a rotational spring, which angle of its joint; of friction, where the joint leaves more
        than one free and only one of them has it.
    stiffness : float or str [kg/s², of angles kg unit²/s²], or six of them, optional
        Tension of a spring by its elongation, the same number as in N/m; moment by angle; of a
        bushing along its three directions, then about them.
    damping : float or str [kg/s, of angles kg unit²/s], or six of them, optional
        The same by the rate; of friction the force or moment by the rate.
    tension : str, optional
        Tension of a spring as a formula of its elongation ``x``, the rate ``v`` of its length, time
        ``t`` and parameters, in the unit of the scene, instead of stiffness and damping; a positive
        tension draws the ends together.
    moment : str, optional
        Of a rotational spring, the moment against its angle as a formula of the angle ``x`` beyond
        the free one, its rate ``v``, time ``t`` and parameters, instead of stiffness and damping.
    free_length : float or str [unit of the scene], optional
        Length of a spring without tension; the distance of its ends, as the positions are written,
        when left out.
    free_angle : float or str [rad], optional
        Angle of a rotational spring without moment; the one as the orientations are written when
        left out.
    inputs : mapping of str to object, optional
        What its type alone has, by name; in a file they are keys of the force.
    """

    FLAT: ClassVar = "inputs"

    type: str
    body: str | None = None
    point: DesignVector | None = None
    force: Value | Components | None = None
    force_b: Components | None = None
    torque: Components | None = None
    torque_b: Components | None = None
    bodies: tuple[str, str] | None = None
    points: tuple[DesignVector, DesignVector] | None = None
    at: DesignVector | None = None
    axes: tuple[DesignVector, DesignVector] | None = None
    joint: str | None = None
    coordinate: str | None = None
    of: Free | None = None
    stiffness: Value | Six | None = None
    damping: Value | Six | None = None
    tension: str | None = None
    moment: str | None = None
    free_length: Value | None = None
    free_angle: Value | None = None
    inputs: Mapping[str, Any] | None = None

    def input(self, name: str) -> Any:
        """Value of a key that its type alone has, None where it is left out."""
        return (self.inputs or {}).get(name)
