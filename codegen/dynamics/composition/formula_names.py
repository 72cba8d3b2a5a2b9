"""Names that formulas of a scene may use, each recorded where it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from kousoku.model.expressions.formulas import RATE, TIME
from kousoku.model.mechanics.constraints import is_length

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
    from kousoku.codegen.dynamics.operations.formulas import Meaning
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.model.mechanics.multibody import System


class FormulaNames(Mapping[str, "Meaning"]):
    """Names that formulas may depend on: time, parameters, coordinates, rates of coordinates.

    Each is recorded in the segment that asks for it.

    Parameters
    ----------
    system : System
        The scene.
    recorder : Recorder
        The program.
    coordinates : CoordinateRecorder
        Its coordinates.
    given : (SlotMatrix, SlotMatrix)
        Where time and parameters are.
    by_body : sequence of SlotMatrix
        The velocities of each body.
    """

    def __init__(
        self,
        system: System,
        recorder: Recorder,
        coordinates: CoordinateRecorder,
        given: tuple[SlotMatrix, SlotMatrix],
        by_body: Sequence[SlotMatrix],
    ) -> None:
        time, parameters = given
        self._fixed = {TIME: time}
        for k, (name, _) in enumerate(system.parameters):
            self._fixed[name] = parameters.part(k, 1)
        self._places = {one.name: place for place, one in enumerate(system.coordinates)}
        self._rates = {f"{name}{RATE}": place for name, place in self._places.items()}
        self._unit = system.unit
        self._recorder, self._coordinates, self._by_body = recorder, coordinates, by_body

    def __getitem__(self, name: str) -> Meaning:
        one = self._recorder.constant((1,))
        if name in self._fixed:
            return self._fixed[name], one
        if name in self._rates:
            place = self._rates[name]
            value = self._coordinates.rate(place, self._by_body)
        else:
            place = self._places[name]
            value = self._coordinates.value(place)
        kind = self._coordinates.all[place].kind
        return value, self._recorder.constant((self._unit,)) if is_length(kind) else one

    def __contains__(self, name: object) -> bool:
        return name in self._fixed or name in self._places or name in self._rates

    def __iter__(self) -> Iterator[str]:
        yield from (*self._fixed, *self._places, *self._rates)

    def __len__(self) -> int:
        return len(self._fixed) + len(self._places) + len(self._rates)
