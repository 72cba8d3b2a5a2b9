"""What dynamics wants of the masses of a system."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from kousoku.model.mechanism import System


def require_inertia(system: System, *, is_planar: bool) -> None:
    """Refuse bodies that forces would accelerate without limit.

    Parameters
    ----------
    system : System
        A system.
    is_planar : bool
        Whether its bodies turn about z only, so that one moment is enough.

    Raises
    ------
    SceneError
        A body has no mass, or no moment of inertia about an axis that it may turn about.
    """
    for body in system.bodies:
        if not body.mass > 0:
            raise SceneError(
                "is missing; dynamics wants a mass for every body that moves",
                key=f"bodies.{body.name}.mass",
            )
        if body.is_point:
            continue
        without = [
            name
            for k, name in enumerate(("first", "second", "third"))
            if not body.inertia[k] > 0 and (k == 2 or not is_planar)
        ]
        if without:
            shown = ", ".join(f"{moment:.6g}" for moment in body.inertia)
            raise SceneError(
                f"has no moment of inertia about its {' and '.join(without)} principal axis "
                f"(they are {shown} kg m²); wanted one about every axis that it may turn about: "
                "give it a thickness, as a cylinder has, or make it a point",
                key=f"bodies.{body.name}",
            )
