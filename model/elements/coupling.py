"""A kind of coupling: a linear combination of the coordinates of other joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.inputs import ElementKind

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Joint


class Coupling(ElementKind):
    """A linear combination of the coordinates of other joints: it has no bodies of its own.

    Attributes
    ----------
    wanted : mapping of str to str
        The keys of :class:`~kousoku.model.records.spatial.Joint` that a scene gives, all of them,
        and what each is; those of ``inputs`` it gives all, too.
    couples : tuple of str
        What the two joints of it must leave free, where it names joints.
    not_zero : tuple of str
        Keys whose number must not be zero.
    aliases : tuple of str
        Other names that are accepted.
    """

    wanted: ClassVar[Mapping[str, str]]
    couples: ClassVar[tuple[str, ...]] = ()
    not_zero: ClassVar[tuple[str, ...]] = ()
    aliases: ClassVar[tuple[str, ...]] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of :class:`~kousoku.model.records.spatial.Joint` that a scene gives."""
        return tuple(self.wanted)

    @property
    def rows(self) -> int:
        """Count of equations."""
        return 1

    def check(self, scene: Scene, joint: Joint, key: str) -> None:
        """Refuse wrong values of its keys, beside the conditions that are stated above.

        Raises
        ------
        SceneError
            With the dotted key of what is wrong.
        """

    def combination(self, name: str, joint: Joint, coordinates: CoordinateList) -> Instance:
        """Combination C = Σ c u + c₀ = 0 (1,) [m or rad], zero at the positions as written."""
        raise NotImplementedError(f"no row of {joint.type}")
