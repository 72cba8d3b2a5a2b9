"""The kind of a force: its keys in a scene, their checks, and its elements."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.model.elements.inputs import ElementKind
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.multibody import ForceElement
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.loads import Force
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Value

    Constants = tuple[tuple[str, tuple[float, ...]], ...]
    Formulas = tuple[tuple[str, str], ...]
    Points = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, slots=True)
class Lowering:
    """Scene, frames and coordinates with which forces are turned into elements.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    coordinates : CoordinateList
        What the forces need is added.
    unit : number [m]
        The unit of the scene.
    """

    scene: Scene
    frames: Mapping[str, BodyFrame]
    coordinates: CoordinateList
    unit: High


class ForceKind(ElementKind):
    """One type of forces in a scene."""

    @abstractmethod
    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse wrong values of its keys.

        Types are right, and of two ``bodies`` both are there; formulas are checked elsewhere.

        Parameters
        ----------
        scene : Scene
            Where it is.
        force : Force
            The force.
        key : str
            Its dotted key.

        Raises
        ------
        SceneError
            With the dotted key of what is wrong.
        """

    def unused(self, force: Force) -> Iterable[tuple[str, str]]:
        """Keys that change nothing, and why."""
        return ()

    @abstractmethod
    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Elements of a checked force: in SI units and principal frames, rounded once.

        Points s′ (3,) and vectors become a′ in A a′; each class gives its law. It imports what
        computes in 50 digits itself: scenes are read and checked without.
        """

    def line(self, force: Force) -> tuple[tuple[str, str], Points] | None:
        """Bodies and the points between which pictures show a spring, if any.

        Points are (3,) [unit of the scene], in the frame of body i and of body j.
        """
        return None


def require_one(value: object, key: str, which: str = "") -> None:
    """Refuse a missing number, and several numbers.

    Raises
    ------
    SceneError
        With the dotted key.
    """
    if value is None or isinstance(value, tuple):
        problem = "is missing" if value is None else "has components"
        raise SceneError(f"{problem}; wanted one number or formula{which}", key=key)


def scalars(numbers: Mapping[str, tuple[Value | High | None, High]]) -> tuple[Constants, Formulas]:
    """Numbers in SI units; of a formula its unit, and the text.

    Parameters
    ----------
    numbers : mapping of str to (float or str, number)
        By name the value in the scene, and its unit.
    """
    from kousoku.model.numbers import precise

    def number(value: Any) -> High:
        return precise.number(1 if isinstance(value, str) else value)

    constants = tuple(
        (name, (precise.double(unit * number(value)),)) for name, (value, unit) in numbers.items()
    )
    texts = ((name, value) for name, (value, _) in numbers.items() if isinstance(value, str))
    return constants, tuple(texts)
