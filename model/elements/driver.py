"""A kind of driver: driven coordinates, and their laws of time."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from kousoku.model.elements.inputs import ElementKind
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver, Value

    #: Identity of a driven coordinate, equal for the same coordinate by another name.
    Driven = tuple[object, ...]


class DriverKind(ElementKind):
    """One sort of drivers in a scene; its first key selects it."""

    @abstractmethod
    def driven(self, scene: Scene, driver: Driver, key: str) -> Iterator[Driven]:
        """Coordinates that it drives, checked.

        Parameters
        ----------
        scene : Scene
            Where it is.
        driver : Driver
            The driver.
        key : str
            Its dotted key.

        Raises
        ------
        SceneError
            With the dotted key of what is wrong.
        """

    @abstractmethod
    def laws(
        self, name: str, driver: Driver, coordinates: CoordinateList
    ) -> Iterator[tuple[int, Value]]:
        """Indices of coordinates u and their laws, u = f(t) (1,) in rad or the unit of the scene.

        The coordinates are added to the list.
        """

    def of_joint(self, scene: Scene, driver: Driver) -> tuple[str, str | None] | None:
        """Joint that it drives, and which of its free coordinates, if it does."""
        return None

    def near(self, scene: Scene, driver: Driver) -> tuple[str, float] | None:
        """Name of the driven angle and its ``near``, which selects the turn, if that is given."""
        return None


def require_value(driver: Driver, key: str) -> None:
    """Refuse a driver of one coordinate without a law.

    Raises
    ------
    SceneError
        With the dotted key.
    """
    if driver.value is None:
        raise SceneError("is missing; wanted a formula of t", key=f"{key}.value")
