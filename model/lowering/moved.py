"""Points and directions that parameters move, seen in the frames of the user."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import is_point
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.numbers.traced import Traced
from kousoku.model.numbers.varying import is_varying
from kousoku.model.records.own_kind import is_own

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System


def moved_by_parameters(system: System, constraint: Instance) -> bool:
    """Whether parameters move points or axes of a constraint, seen in the frames of the user.

    Where only a centre of mass moves in its body, they do not.
    """
    if not system.parameters:
        return False
    parts: list[Instance | RelativeCoordinate] = [constraint]
    parts += [system.coordinates[term.coordinate] for term in constraint.terms]
    return is_varying((constraint.offset, *(term.factor for term in constraint.terms))) or any(
        _moves(system, part.i if "_i_" in name else part.j, name, values)
        for part in parts
        for name, values in part.constants
    )


def _moves(system: System, index: int, name: str, values: tuple[float, ...]) -> bool:
    """Whether a point or a direction moves in the frame of the user, or a number changes."""
    if not name.endswith("_b") or index == GROUND_INDEX or is_own(name):
        return is_varying(values)
    body = system.bodies[index]
    if not is_varying((*values, *body.origin_b, *body.axes_b)):
        return False
    axes = precise.quadruple(body.axes_b)
    seen = precise.triple(values)
    if is_point(name):
        seen = precise.subtract(seen, precise.triple(body.origin_b))
    return any(isinstance(number, Traced) for number in precise.rotate_back(axes, seen))
