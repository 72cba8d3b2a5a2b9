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
        Recorder of its coordinates.
    arguments : (SlotMatrix, SlotMatrix)
        Time and parameters.
    by_body : sequence of SlotMatrix
        The velocities of each body.
    """

    def __init__(
        self,
        system: System,
        recorder: Recorder,
        coordinates: CoordinateRecorder,
        arguments: tuple[SlotMatrix, SlotMatrix],
        by_body: Sequence[SlotMatrix],
    ) -> None:
        time, parameters = arguments
        self._fixed = {TIME: time}
        for k, (name, _) in enumerate(system.parameters):
            self._fixed[name] = parameters.part(k, 1)
        self._indices = {u.name: index for index, u in enumerate(system.coordinates)}
        self._rates = {f"{name}{RATE}": index for name, index in self._indices.items()}
        self._unit = system.unit
        self._recorder, self._coordinates, self._by_body = recorder, coordinates, by_body

    def __getitem__(self, name: str) -> Meaning:
        unity = self._recorder.constant((1,))
        if name in self._fixed:
            return self._fixed[name], unity
        if name in self._rates:
            index = self._rates[name]
            value = self._coordinates.rate(index, self._by_body)
        else:
            index = self._indices[name]
            value = self._coordinates.value(index)
        kind = self._coordinates.all[index].kind
        return value, self._recorder.constant((self._unit,)) if is_length(kind) else unity

    def __contains__(self, name: object) -> bool:
        return name in self._fixed or name in self._indices or name in self._rates

    def __iter__(self) -> Iterator[str]:
        yield from (*self._fixed, *self._indices, *self._rates)

    def __len__(self) -> int:
        return len(self._fixed) + len(self._indices) + len(self._rates)
