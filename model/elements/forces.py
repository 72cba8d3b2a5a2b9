"""All kinds of forces: the one table that reading, checking, systems, schema and catalog share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.along import Along
from kousoku.model.elements.bushing import Bushing
from kousoku.model.elements.friction import Friction
from kousoku.model.elements.load import ForceOnBody, TorqueOnBody
from kousoku.model.elements.rotational_spring_damper import RotationalSpringDamper
from kousoku.model.elements.spring_damper import SpringDamper

if TYPE_CHECKING:
    from kousoku.model.elements.force import ForceKind
    from kousoku.model.elements.inputs import Dependence

FORCES: dict[str, ForceKind] = {
    "force": ForceOnBody(),
    "torque": TorqueOnBody(),
    "spring_damper": SpringDamper(),
    "rotational_spring_damper": RotationalSpringDamper(),
    "along": Along(),
    "friction": Friction(),
    "bushing": Bushing(),
}
"""Forces of a scene by their types."""

DEPENDS_ON: dict[str, Dependence] = {
    **dict.fromkeys(("stiffness", "damping", "free_length", "free_angle"), "parameters"),
    **dict.fromkeys(("tension", "moment"), "law"),
    **dict.fromkeys(("force", "force_b", "torque", "torque_b"), "motion"),
}
"""What formulas of the keys of forces may depend on."""
