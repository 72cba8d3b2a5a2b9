"""Record what acts on bodies beside gravity: accelerations, power, and potential energy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.forces import ELONGATION, SPRING, Load, Spring, Stored
from kousoku.codegen.dynamics.formulas import scaled, used_names
from kousoku.codegen.dynamics.recorder import Block, column
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from kousoku.codegen.dynamics.bodies import BodyBlocks
    from kousoku.codegen.dynamics.formulas import Meaning
    from kousoku.codegen.dynamics.recorder import Recorder
    from kousoku.model.mechanism import ForceElement

    Effect = tuple[dict[int, Block], Block | None]


class ForceTasks:
    """Forces of a program.

    Parameters
    ----------
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body, or of the ground, by its index.
    names : mapping of str to (Block, Block)
        What formulas may depend on: value and unit.
    """

    def __init__(
        self,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        names: Mapping[str, Meaning],
    ) -> None:
        self.recorder = recorder
        self.body = body
        self.names = names

    def effect(self, force: ForceElement) -> Effect:
        """Record what a force adds to the accelerations of each body, and its power.

        The power is that of what is no potential energy, None where all is.
        """
        constants = self._constants(force)
        i, j = self.body(force.i), self.body(force.j)
        if force.kind == SPRING:
            found = self._spring(force, i, j, constants)
        else:
            blocks = (j.p, j.orientation, j.v_r, j.omega_b, j.inverse_mass)
            operation = Load(force.kind, j.columns, force.works)
            found = (column(()), *self.recorder.call(operation, *blocks, *constants))
        ends = zip((force.i, force.j), found, strict=False)
        added = {index: block for index, block in ends if index != GROUND_INDEX}
        return added, found[2] if force.works else None

    def stored(self, force: ForceElement) -> Block:
        """Record (0, V) of a force that has a potential energy."""
        constants = self._constants(force)
        i, j = self.body(force.i), self.body(force.j)
        operation = Stored(force.kind)
        return self.recorder.call(operation, i.r, i.p, j.r, j.p, *constants)[0]

    def _constants(self, force: ForceElement) -> list[Block]:
        """Return the constants; those that a formula belongs to are multiplied by it."""
        texts = dict(force.formulas)
        found = []
        for name, values in force.constants:
            block = self.recorder.constant(values)
            if name in texts:
                block = scaled(self.recorder, block, texts[name], self.names)
            found.append(block)
        return found

    def _spring(
        self, force: ForceElement, i: BodyBlocks, j: BodyBlocks, constants: list[Block]
    ) -> tuple[Block, ...]:
        ends = [
            block
            for body in (i, j)
            for block in (
                *(body.r, body.p, body.orientation),
                *(body.v_r, body.omega_b, body.inverse_mass),
            )
        ]
        names: tuple[str, ...] = ()
        if force.law:
            used = used_names(force.law, (*ELONGATION, *self.names))
            names = tuple(name for name in used if name not in ELONGATION)
            constants += [block for name in names for block in self.names[name]]
        operation = Spring(i.columns, j.columns, force.law, names, force.works)
        return self.recorder.call(operation, *ends, *constants)
