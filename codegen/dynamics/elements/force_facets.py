"""The facets of each force: the one table that analyses, composition and the check share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.codegen.dynamics.elements.along import AlongFacets
from kousoku.codegen.dynamics.elements.coordinate_spring import CoordinateSpringFacets
from kousoku.codegen.dynamics.elements.load import LoadFacets
from kousoku.codegen.dynamics.elements.spring_damper import SpringFacets
from kousoku.model.elements.along import CoordinateForce
from kousoku.model.elements.coordinate_spring import CoordinateSpring
from kousoku.model.elements.load import Load
from kousoku.model.elements.spring_damper import PointSpring

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.elements.facets import ForceFacets
    from kousoku.model.mechanics.multibody import ForceElement

#: By the class of the element of a system.
FORCE_FACETS: dict[type[ForceElement], type[ForceFacets[Any]]] = {
    Load: LoadFacets,
    PointSpring: SpringFacets,
    CoordinateForce: AlongFacets,
    CoordinateSpring: CoordinateSpringFacets,
}


def facets_of(force: ForceElement) -> ForceFacets[Any]:
    """Facets of a force of a system."""
    return FORCE_FACETS[type(force)](force)
