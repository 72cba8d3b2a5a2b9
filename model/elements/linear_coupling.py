"""A linear coupling: the sum of coordinates, each multiplied by a factor."""

from __future__ import annotations

from dataclasses import replace
from math import frexp, ldexp
from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.coupling import Coupling
from kousoku.model.errors import SceneError
from kousoku.model.records.dotted_keys import require_known

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Joint

USUAL = 8
"""Binary exponent of the largest factor, positive or negative, up to which a row is not scaled;
factors of angles are first divided by a length of the scene."""


class LinearCoupling(Coupling):
    """The sum of coordinates u, each multiplied by a factor: C = Σ c u + c₀ = 0 (1,) [m or rad]."""

    title = "the sum of coordinates, each multiplied by a factor"
    wanted: ClassVar = {
        "coordinates": "names of coordinates",
        "factors": "a number for each coordinate",
    }
    aliases = ("coupler",)

    def check(self, scene: Scene, joint: Joint, key: str) -> None:
        """Refuse coordinates that are not there or stand twice, and factors that are zero."""
        names, factors = joint.coordinates or (), joint.factors or ()
        if not names:
            raise SceneError("is empty; wanted names of coordinates", key=f"{key}.coordinates")
        if len(names) != len(factors):
            raise SceneError(
                f"has {len(factors)} numbers for {len(names)} coordinates; wanted one for each",
                key=f"{key}.factors",
            )
        for index, name in enumerate(names):
            item_key = f"{key}.coordinates[{index}]"
            require_known("coordinate", name, scene.coordinates, item_key)
            if name in names[:index]:
                raise SceneError(f"{name} stands there twice; leave one out", key=item_key)
        for index, factor in enumerate(factors):
            if factor == 0:
                raise SceneError(
                    "is zero; wanted a number, or leave the coordinate out",
                    key=f"{key}.factors[{index}]",
                )

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination Σ factor · coordinate, of angles in rad, else in the unit of the scene."""
        from kousoku.model.elements.combinations import as_written
        from kousoku.model.numbers import precise
        from kousoku.model.numbers.traced import at_scene

        assert joint.coordinates is not None
        assert joint.factors is not None
        indices = [coordinates.index_of(coordinate) for coordinate in joint.coordinates]
        factors = [precise.number(factor) for factor in joint.factors]
        units = [coordinates.unit_of(index)[0] for index in indices]
        if "m" in units:  # what is multiplied with an angle is a length
            pairs = zip(factors, units, strict=True)
            factors = [f * coordinates.unit if unit == "rad" else f for f, unit in pairs]
        sizes = [float(at_scene(factor)) for factor in factors]
        if "m" in units and "rad" in units:
            length = coordinates.length()
            sizes = [
                f / length if unit == "rad" else f for f, unit in zip(sizes, units, strict=True)
            ]
        scale = _scale_of(sizes)
        terms = [(index, scale * f) for index, f in zip(indices, factors, strict=True)]
        return replace(as_written(name, terms, coordinates), scale=scale)


def _scale_of(factors: Sequence[float]) -> float:
    """Scale of factors, so that their row has the size of other rows.

    A row that is far smaller would count as one that depends on others, and nothing would keep it.
    """
    largest = max(map(abs, factors))
    exponent = frexp(largest)[1] if largest else 0
    return 1.0 if abs(exponent) <= USUAL else ldexp(1.0, 1 - exponent)
