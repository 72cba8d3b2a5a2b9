"""A spring and damper between two points."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_only_point
from kousoku.model.elements.force import ForceKind, scalars
from kousoku.model.elements.spring import check_law, unused_free
from kousoku.model.errors import SceneError
from kousoku.model.mechanics.multibody import ForceElement
from kousoku.model.records.spatial import GROUND

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Lowering, Points
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Value


@dataclass(frozen=True, slots=True)
class PointSpring(ForceElement):
    """A spring and damper between two points: tension T = k (l − l⁰) + c l̇ (1,) [N] along d.

    Of ``constants`` ``s_i_b`` and ``s_j_b`` (3,) [m] are its ends in the principal frames, then
    come ``stiffness`` k [N/m], ``damping`` c [N s/m] and ``free_length`` l⁰ [m]; with a law of its
    own ``unit`` [m], that of the scene, in place of stiffness and damping. l = |d|, lecture 8.2,
    (8.8).
    """

    kind: str = field(init=False, default="spring_damper")

    @property
    def has_potential(self) -> bool:
        """Whether it is linear."""
        return not self.law

    @property
    def needs_direction(self) -> bool:
        """Whether its force is undefined where its ends meet; that of T = k l is not: k **d**."""
        constants = dict(self.constants)
        zero = (0.0,)
        return bool(self.law) or not constants["damping"] == constants["free_length"] == zero


class SpringDamper(ForceKind):
    """A spring and damper between two points: tension T = k (l − l⁰) + c l̇ (1,) [N].

    See :class:`PointSpring`; l = |d|, d (3,) [m] in frame O.
    """

    title = "a spring and damper between two points"
    keys = ("bodies", "points", "stiffness", "damping", "tension", "free_length")

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse a spring without ends, without a law, or of negative length."""
        if force.points is None:
            raise SceneError("is missing; wanted its end in each of them", key=f"{key}.points")
        for index, (name, point) in enumerate(zip(force.bodies or (), force.points, strict=True)):
            if name != GROUND:
                check_only_point(scene, name, point, f"{key}.points[{index}]")
        check_law(force, "tension", key)
        free = force.free_length
        if isinstance(free, float) and free < 0:
            raise SceneError(
                f"a length of {free!r}; wanted none that is negative", key=f"{key}.free_length"
            )

    def unused(self, force: Force) -> Iterator[tuple[str, str]]:
        """Free length without effect."""
        yield from unused_free(force, "free_length", "tension")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Element of the spring: ends (3,) [m], l⁰ = |d| as written where it is not given."""
        from kousoku.model.numbers import precise

        assert force.bodies is not None
        assert force.points is not None
        ends = [lowering.frames[body] for body in force.bodies]
        points = [precise.triple(point) for point in force.points]
        free: Value | High | None = force.free_length
        if free is None:
            start, end = (
                precise.add(frame.position, precise.rotate(frame.p, point))
                for frame, point in zip(ends, points, strict=True)
            )
            free = precise.length(precise.subtract(end, start))
        one = precise.number(1)
        law: dict[str, tuple[Value | High, High]] = {"unit": (1.0, lowering.unit)}
        if force.tension is None:
            assert not isinstance(force.stiffness, tuple)
            assert not isinstance(force.damping, tuple)
            linear = {"stiffness": force.stiffness, "damping": force.damping}
            law = {name: (value or 0.0, one) for name, value in linear.items()}
        numbers, formulas = scalars(law | {"free_length": (free, lowering.unit)})
        constants = (
            ("s_i_b", ends[0].point(points[0], lowering.unit)),
            ("s_j_b", ends[1].point(points[1], lowering.unit)),
            *numbers,
        )
        i, j = (end.index for end in ends)
        yield PointSpring(name, i, j, constants, force.tension or "", formulas)

    def line(self, force: Force) -> tuple[tuple[str, str], Points] | None:
        """Bodies i and j, and ends (3,) [unit of the scene] of the spring in their frames."""
        ends = force.bodies, force.points
        return None if ends[0] is None or ends[1] is None else (ends[0], ends[1])
