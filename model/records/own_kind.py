"""Kinds of one's own as types of joints: their inputs in a scene, and the names of their kernels.

The kernels themselves are the business of :mod:`kousoku.codegen.kernel_json`; a scene knows them by
a name that their content gives them, so that a kind that is derived anew with a change is another.
"""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from collections.abc import Mapping
from typing import Literal

import msgspec

from kousoku.model.records.design import Design, DesignVector

PREFIX = "own:"
"""Prefix of the names of kernels of one's own; no shipped kind has it."""

ORIGINS, FRAMES = ("origin_i", "origin_j"), ("frame_i", "frame_j")
"""Inputs of their kernels in a scene: the origin of the body frame of the scene in the principal
frame [m], and Euler parameters from the former to the latter."""

KEYS = ("type", "bodies")
"""Keys of a joint that cannot be names of inputs of a kind."""


class OwnInput(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A number or a vector that each joint of a kind of one's own gives.

    Parameters
    ----------
    unit : {"-", "rad", "m"}
        Its unit in the kernels; lengths are given in the unit of the scene.
    vector : bool
        Whether it is a vector: one without unit is a direction, of any length but zero.
    body : str
        Of a vector that is fixed in a body ``i`` or ``j``, else empty.
    meaning : str
        What it is, in a few words.
    """

    unit: Literal["-", "rad", "m"]
    vector: bool = False
    body: Literal["", "i", "j"] = ""
    meaning: str = ""

    @property
    def type(self) -> object:
        """The type of its value in a scene."""
        return DesignVector if self.vector else Design

    @property
    def is_direction(self) -> bool:
        """Whether only its direction counts."""
        return self.vector and self.unit == "-"


class OwnKind(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A constraint of one's own between two bodies, as the type of joints.

    Parameters
    ----------
    kernels : str
        What its kernels are found by.
    unit : {"m", "rad"}
        The unit of its rows: lengths, or what is compared with angles.
    turns : (bool, bool)
        Whether it keeps something of the orientation of body i, and of body j, also where points
        of the body are its origin.
    inputs : mapping of str to OwnInput
        What a joint gives, by name, in the order of the kernels.
    """

    kernels: str
    unit: Literal["m", "rad"]
    turns: tuple[bool, bool]
    inputs: Mapping[str, OwnInput] = {}

    def point_of(self, body: str) -> str:
        """Input that is the first point of body ``i`` or ``j``, empty of none."""
        points = (name for name, q in self.inputs.items() if q.body == body and q.unit == "m")
        return next(points, "")


class OwnKinds(msgspec.Struct, frozen=True):
    """The table ``kinds`` of a scene alone.

    Parameters
    ----------
    kinds : mapping of str to OwnKind
        By the types of joints.
    """

    kinds: Mapping[str, OwnKind] = {}


def is_own(kind: str) -> bool:
    """Whether an instance is of a kind of one's own."""
    return kind.startswith(PREFIX)


def kind_name(kind: str) -> str:
    """Kind as people call it: of one's own without the digest of its content."""
    return kind.split(":")[1] if is_own(kind) else kind


def input_name(name: str) -> str:
    """Name of an own input among those of the kernels in a scene.

    No other input of a kernel, and no element or parameter of a scene, has such a name.
    """
    return f"{PREFIX}{name}"
