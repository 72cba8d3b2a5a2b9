"""Rows that no coordinate of a program changes: they hold at the start, or the scene is refused."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.combinations import fixed_law
from kousoku.codegen.dynamics.design import with_other_parameters
from kousoku.codegen.dynamics.length import characteristic_length
from kousoku.codegen.dynamics.residuals import Residuals
from kousoku.codegen.dynamics.violations import key_of
from kousoku.model.errors import SceneError
from kousoku.model.varying import fixed_system

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.codegen.dynamics.program import Program
    from kousoku.model.mechanism import System

#: Other values of the parameters that numbers are traced with, beside those of the scene.
OTHERS = (1, 2)
#: The largest residual that is rounding, in lengths of the scene or radians.
HOLDS = 1e-11


def require_unmoved_rows_hold(system: System, program: Program) -> None:
    """Refuse constraints that were not composed, because nothing changes them, and do not hold.

    Parameters
    ----------
    system : System
        The scene, assembled.
    program : Program
        What it was composed to, with all rows that anything changes.

    Raises
    ------
    SceneError
        The message names the joint or driver, and by how much it is violated.
    """
    composed = dict.fromkeys((row.instance, row.row) for row in program.rows)
    written, system = system, fixed_system(system)
    rows = Residuals.of(system, system.constraints)
    if len(composed) == rows.rows:
        return
    _require_unmoved_by_parameters(written, composed)
    names = [name for name, _ in system.parameters]
    length = characteristic_length(system)
    values, _ = rows.fast(system.bodies)
    for place, (instance, first) in enumerate(zip(system.constraints, rows.first, strict=False)):
        for row in range(rows.count(instance)):
            if (place, row) in composed:
                continue
            if not isfinite(fixed_law(instance, names)):
                raise SceneError(
                    "prescribes a motion of what cannot move; leave it out", key=key_of(instance)
                )
            is_length = bool(rows.in_metres[first + row])
            size, unit = abs(float(values[first + row])), "m" if is_length else "rad"
            if not size <= HOLDS * (length if is_length else 1.0):
                raise SceneError(
                    f"is violated by {size:.3g} {unit}, and no body that it connects can change"
                    " that; give points and axes that fit",
                    key=key_of(instance),
                )


def _require_unmoved_by_parameters(written: System, composed: Collection[tuple[int, int]]) -> None:
    """Refuse constraints that parameters violate, and that no body can follow."""
    for other in OTHERS if written.parameters else ():
        system = with_other_parameters(written, other)
        if system is written:
            return
        rows = Residuals.of(system, system.constraints)
        length = characteristic_length(system)
        values, _ = rows.fast(system.bodies)
        for place, instance in enumerate(system.constraints):
            for row in range(rows.count(instance)):
                at = rows.first[place] + row
                limit = HOLDS * (length if rows.in_metres[at] else 1.0)
                if (place, row) not in composed and not abs(float(values[at])) <= limit:
                    raise SceneError(
                        "is violated with other parameters than those of the scene, and no body"
                        " that it connects can change that; write formulas that fit each other, or"
                        " numbers in place of them",
                        key=key_of(instance),
                    )
