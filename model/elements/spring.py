"""Springs: their law, linear or a formula, and their free length or angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.expressions.formulas import used_names

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.records.loads import Force


def check_law(force: Force, name: str, key: str) -> None:
    """Refuse a spring with no law, or with two.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    for other in ("stiffness", "damping"):
        if isinstance(getattr(force, other), tuple):
            raise SceneError("has components; wanted one number", key=f"{key}.{other}")
    is_linear = force.stiffness is not None or force.damping is not None
    if getattr(force, name) is None and not is_linear:
        raise SceneError(
            f"is missing; wanted a stiffness, a damping or both, or a {name}",
            key=f"{key}.stiffness",
        )
    if getattr(force, name) is not None and is_linear:
        raise SceneError(
            "has a stiffness or a damping too; wanted one of them", key=f"{key}.{name}"
        )


def unused_free(force: Force, free: str, law: str) -> Iterator[tuple[str, str]]:
    """Key of a free length or angle where no force depends on the elongation, and why."""
    formula = getattr(force, law)
    counts = force.stiffness is not None if formula is None else bool(used_names(formula, "x"))
    if getattr(force, free) is not None and not counts:
        missing = "it has no stiffness" if formula is None else f"its {law} does not depend on x"
        yield free, f"changes nothing, since {missing}; leave it out"
