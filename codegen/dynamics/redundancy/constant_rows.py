"""Rows that no velocity of a system changes: they hold at the start, or the scene is refused."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.driver_laws import fixed_law
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.assembly.violations import key_of
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.redundancy.branch import BRANCH_TOLERANCE
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.simplification.outline import Outline
    from kousoku.model.mechanics.multibody import System


def require_constant_rows_hold(system: System, outline: Outline) -> None:
    """Refuse constraints that do not hold and that no velocity changes, so that none is solved.

    Parameters
    ----------
    system : System
        The scene, assembled.
    outline : Outline
        Outline, whose rows are those that some velocity changes.

    Raises
    ------
    SceneError
        The message names the joint or driver, and by how much it is violated.
    """
    rows = Residuals.of(system, system.constraints)
    solved = dict.fromkeys((row.instance, row.row) for row in outline.rows)
    if len(solved) == rows.rows:
        return
    names = [name for name, _ in system.parameters]
    length = characteristic_length(system)
    values, _ = rows.at_start(system.bodies)
    for index, (instance, first) in enumerate(zip(system.constraints, rows.first, strict=False)):
        for row in range(rows.count(instance)):
            if (index, row) in solved:
                continue
            if not isfinite(fixed_law(instance, names)):
                raise SceneError(
                    "prescribes a motion of what cannot move; leave it out", key=key_of(instance)
                )
            is_length = bool(rows.in_metres[first + row])
            size, unit = abs(float(values[first + row])), "m" if is_length else "rad"
            if not size <= BRANCH_TOLERANCE * (length if is_length else 1.0):
                raise SceneError(
                    f"is violated by {size:.3g} {unit}, and no body that it connects can change"
                    " that; give points and axes that fit",
                    key=key_of(instance),
                )
