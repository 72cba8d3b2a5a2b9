"""Orientations in the forms that people use, each with its convention written beside it."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from math import hypot
from typing import ClassVar, Literal

import msgspec

from kousoku.model.errors import SceneError
from kousoku.model.records.design import LARGEST, NumberOrAngle, Turns

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Sequence = Literal[
    "xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"
]

FORMS = {
    "quaternion": ("order",),
    "rotation_vector": (),
    "axis": ("angle",),
    "angles": ("sequence", "about"),
    "matrix": (),
}
"""Forms of an orientation, and the keys that each needs beside its own."""

RIGHT_ANGLES = 1e-6
"""Largest deviation of the columns of a matrix from perpendicular unit vectors."""


class Orientation(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Orientation of a frame in another: of a body in frame O, of a box in its body.

    It is the rotation A that takes components in the first frame to components in the second, in
    one of five forms: `quaternion`, `rotation_vector`, `axis` and `angle`, `angles`, `matrix`.

    Parameters
    ----------
    quaternion : (4,), optional
        Euler parameters of A, of any length but zero.
    order : {"wxyz", "xyzw"}, optional
        With `quaternion`, where its scalar part stands: first (w x y z) or last (x y z w).
    rotation_vector : (3,) [rad], optional
        The axis of A times its angle.
    axis : (3,), optional
        The axis of A, of any length but zero; its components are the same in both frames.
    angle : float [rad], optional
        With `axis`, the angle about it, counter-clockwise seen against the axis.
    angles : (3,) [rad], optional
        Euler or Tait-Bryan angles: three turns, one after the other.
    sequence : str, optional
        With `angles`, the axes of the turns in their order, such as ``zxz`` or ``zyx``.
    about : {"body", "fixed"}, optional
        With `angles`, whose axes these are: those that turn with the body from turn to turn, or
        those of the fixed frame. About ``body`` it is A = A1 A2 A3, about ``fixed`` A3 A2 A1.
    matrix : (3, 3), optional
        A itself, row by row; its columns are the axes of the first frame.
    """

    EXAMPLE: ClassVar[str] = '{ quaternion = [1, 0, 0, 0], order = "wxyz" }'

    quaternion: Quaternion | None = None
    order: Literal["wxyz", "xyzw"] | None = None
    rotation_vector: Turns | None = None
    axis: Vector | None = None
    angle: NumberOrAngle | None = None
    angles: Turns | None = None
    sequence: Sequence | None = None
    about: Literal["body", "fixed"] | None = None
    matrix: tuple[Vector, Vector, Vector] | None = None


def check_orientation(orientation: Orientation, key: str) -> None:
    """Refuse an orientation in no form or in two, and one that is no rotation.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    forms = [form for form in FORMS if getattr(orientation, form) is not None]
    if len(forms) != 1:
        got = " and ".join(forms) or "none of them"
        raise SceneError(f"wanted one of {', '.join(FORMS)}; got {got}", key=key)
    (form,) = forms
    for name in (name for names in FORMS.values() for name in names):
        has, needs = getattr(orientation, name) is not None, name in FORMS[form]
        if needs and not has:
            raise SceneError(f"is missing; wanted {MEANINGS[name]}", key=f"{key}.{name}")
        if has and not needs:
            raise SceneError(f"does not belong to {form}; leave it out", key=f"{key}.{name}")
    value = getattr(orientation, form)
    if form in ("quaternion", "axis") and not hypot(*value) >= 1 / LARGEST:
        wanted = "Euler parameters of a rotation" if form == "quaternion" else "an axis"
        raise SceneError(f"has zero length; wanted {wanted}", key=f"{key}.{form}")
    if orientation.matrix is not None:
        _check_matrix(orientation.matrix, f"{key}.matrix")


MEANINGS = {
    "order": "one of 'wxyz', 'xyzw'",
    "angle": "the angle about the axis, in radians or such as '30 deg'",
    "sequence": "the axes of the three turns in their order, such as 'zyx'",
    "about": "'body' (axes that turn with the body) or 'fixed' (axes that stay)",
}


def _check_matrix(matrix: tuple[Vector, Vector, Vector], key: str) -> None:
    (a, b, c), (d, e, f), (g, h, i) = matrix
    columns = (a, d, g), (b, e, h), (c, f, i)
    worst = max(
        abs(sum(x * y for x, y in zip(columns[k], columns[m], strict=True)) - int(k == m))
        for k in range(3)
        for m in range(k + 1)
    )
    if worst > RIGHT_ANGLES:
        raise SceneError(
            "is no rotation: its columns differ from perpendicular unit vectors by "
            f"{worst:.3g}; wanted at most {RIGHT_ANGLES:g}",
            key=key,
        )
    if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0:
        raise SceneError(
            "is a reflection: its determinant is −1; wanted a rotation, with +1", key=key
        )
