"""A force that is not shipped, as a scene and a system know it: quadratic drag on a point."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.force import ForceKind, require_one, scalars
from kousoku.model.elements.inputs import ElementInput
from kousoku.model.errors import SceneError
from kousoku.model.mechanics.multibody import GROUND_INDEX, ForceElement
from kousoku.model.records.design import DesignVector
from kousoku.model.records.dotted_keys import require_known
from kousoku.model.records.spatial import Value

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Lowering
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class Drag(ForceElement):
    """Drag F = −c |v| v on a point ``s_j_b`` [m] of body j; ``coefficient`` [kg/m] is c."""

    kind: str = field(init=False, default="quadratic_drag")


class QuadraticDrag(ForceKind):
    """Drag against the velocity of a point, by its square."""

    title = "drag by the square of the velocity of a point"
    keys = ("body",)
    inputs: ClassVar = {
        "centre": ElementInput(DesignVector | None, "where it acts, in the body frame"),
        "coefficient": ElementInput(
            Value, "c of F = -c |v| v [kg/unit of the scene]", "parameters"
        ),
    }

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse a drag on no body, and one without a coefficient."""
        if force.body is None:
            raise SceneError("is missing; wanted the body that it brakes", key=f"{key}.body")
        require_known("body", force.body, scene.bodies, f"{key}.body")
        require_one(force.input("coefficient"), f"{key}.coefficient")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Drag as an element."""
        from kousoku.model.numbers import precise

        frame = lowering.frames[force.body or ""]
        point = precise.triple(force.input("centre") or (0.0, 0.0, 0.0))
        numbers, formulas = scalars(
            {"coefficient": (force.input("coefficient"), 1 / lowering.unit)}
        )
        constants = (("s_j_b", frame.point(point, lowering.unit)), *numbers)
        yield Drag(name, GROUND_INDEX, frame.index, constants, formulas=formulas)
