"""An event: a formula of the motion that passes zero, and what a run does then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.expressions.formulas import (
    formula_problems,
    state_names,
    used_coordinates,
    used_names,
    values_at_start,
)
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.switching import may_jump
from kousoku.model.mechanics.multibody import SystemEvent
from kousoku.model.records.dotted_keys import join

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Direction, Event

DIRECTIONS: dict[Direction, int] = {"both": 0, "rising": 1, "falling": -1}
"""Sign of the rate with which the formula passes zero, 0 where either counts."""


@dataclass(frozen=True, slots=True)
class ZeroCrossing:
    """An event of a scene: a formula g(t, q, v) of the motion passes zero.

    Parameters
    ----------
    scene : Scene
        Where it is.
    name : str
        Its name there.
    event : Event
        Its keys.
    """

    scene: Scene
    name: str
    event: Event

    @property
    def key(self) -> str:
        """Its dotted key."""
        return join("events", self.name)

    def check(self) -> None:
        """Refuse an event whose text is no formula, or whose formula never changes.

        Raises
        ------
        SceneError
            With the dotted key of the formula.
        """
        scene, when, key = self.scene, self.event.when, f"{self.key}.when"
        names = state_names(scene)
        if problems := list(formula_problems(when, names, key, values_at_start(scene))):
            raise SceneError.of(problems)
        if not used_names(when, names - scene.parameters.keys()):
            raise SceneError(
                "never changes, so that it passes zero nowhere; wanted a formula of t, of"
                " coordinates or of their rates, such as 'x - 1' or 'x_dot'",
                key=key,
            )

    def element(self, coordinates: CoordinateList) -> SystemEvent:
        """Event of a system; the coordinates that its formula needs are added to the list."""
        event = self.event
        for name in used_coordinates(self.scene, [event.when]):
            coordinates.index_of(name)
        return SystemEvent(self.name, event.when, DIRECTIONS[event.direction], event.action)

    def notes(self) -> Iterator[str]:
        """Note on jumps of its formula over 0, which do not count as events."""
        names = state_names(self.scene)
        formula = parse_expression(self.event.when, names)
        if may_jump(formula, names.difference(self.scene.parameters)):
            yield (
                f"{self.key} may jump over 0, also through infinity, and does not"
                " count where it does; take what passes 0 there: x for sign(x) and for 1/x"
            )


def events_of(scene: Scene) -> Iterator[ZeroCrossing]:
    """All events of a scene."""
    for name, event in scene.events.items():
        yield ZeroCrossing(scene, name, event)
