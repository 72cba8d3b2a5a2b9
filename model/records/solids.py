"""Solids and points of mass that a body is made of, as a scene describes them."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from typing import ClassVar

import msgspec

from kousoku.model.records.design import Design, DesignVector
from kousoku.model.records.orientation import Orientation


class Inertia(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Inertia tensor in the axes of the body frame, about the centre of mass or another point.

    Parameters
    ----------
    xx, yy, zz : float [kg unit²]
        Moments of inertia.
    xy, yz, zx : float [kg unit²]
        Elements of the tensor off the diagonal: xy = −∫ x y dm.
    about : (3,) [unit of the scene], optional
        The point that the moments belong to, in the body frame; the centre of mass when left out.
    """

    EXAMPLE: ClassVar[str] = "{ xx = 1, yy = 1, zz = 1 }"

    xx: Design
    yy: Design
    zz: Design
    xy: Design = 0.0
    yz: Design = 0.0
    zx: Design = 0.0
    about: DesignVector | None = None


class MassPoint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A point mass that is fixed in a body.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    at : (3,) [unit of the scene]
        Its position in the body frame.
    """

    mass: Design
    at: DesignVector


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A uniform box.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    size : (3,) [unit of the scene]
        Its three edges.
    at : (3,) [unit of the scene]
        Its middle in the body frame.
    orientation : Orientation, optional
        Orientation of its edges in the body frame; along the axes of the body when left out.
    """

    mass: Design
    size: DesignVector
    at: DesignVector = (0.0, 0.0, 0.0)
    orientation: Orientation | None = None


class Rod(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A uniform rod without thickness: it has no moment of inertia about itself.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    ends : ((3,), (3,)) [unit of the scene]
        Its two ends in the body frame.
    """

    mass: Design
    ends: tuple[DesignVector, DesignVector]


class Cylinder(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A uniform solid cylinder.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    radius : float [unit of the scene]
        Its radius.
    ends : ((3,), (3,)) [unit of the scene]
        The middles of its two faces in the body frame.
    """

    mass: Design
    radius: Design
    ends: tuple[DesignVector, DesignVector]


class Sphere(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A uniform solid sphere.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    radius : float [unit of the scene]
        Its radius.
    at : (3,) [unit of the scene]
        Its middle in the body frame.
    """

    mass: Design
    radius: Design
    at: DesignVector = (0.0, 0.0, 0.0)
