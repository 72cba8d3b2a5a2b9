"""All kinds of drivers: the one table that checking, systems and catalog share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.driven_coordinate import DrivenCoordinate
from kousoku.model.elements.driven_joint import DrivenJoint
from kousoku.model.elements.driven_point import DrivenPoint
from kousoku.model.elements.inputs import key_value

if TYPE_CHECKING:
    from kousoku.model.elements.driver import DriverKind
    from kousoku.model.elements.inputs import ElementInput
    from kousoku.model.records.spatial import Driver

DRIVERS: dict[str, DriverKind] = {
    "coordinate": DrivenCoordinate(),
    "joint": DrivenJoint(),
    "body": DrivenPoint(),
}
"""Kinds of drivers by the key that selects them."""


def kind_of(driver: Driver) -> DriverKind:
    """Kind of a driver, by the one of these keys that it has."""
    return next(kind for key, kind in DRIVERS.items() if key_value(driver, key) is not None)


def own_inputs() -> dict[str, ElementInput]:
    """Inputs of all kinds of drivers: keys that one kind alone has."""
    return {name: entry for kind in DRIVERS.values() for name, entry in kind.inputs.items()}
