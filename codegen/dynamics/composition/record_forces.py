"""Gravity and the forces of a program, recorded, with the operands that their facets ask for."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.operations.applied_forces import ELONGATION
from kousoku.codegen.dynamics.operations.formulas import MatrixProduct, Relative, scaled
from kousoku.codegen.dynamics.operations.sums import summed
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column
from kousoku.model.expressions.formulas import used_names
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.codegen.dynamics.composition.formula_names import FormulaNames
    from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.lowering.root_functions import Measure
    from kousoku.model.mechanics.multibody import ForceElement, System
    from kousoku.model.numbers.precise import High

    Effect = tuple[dict[int, SlotMatrix], SlotMatrix | None]


class ForceRecorder:
    """Forces of a program: shares M⁻¹f of the accelerations, f of M v̇ + C_qᵀλ = f.

    f (c,) is force [N] in frame O and torque [N m] about the centre of mass in the principal frame.

    Parameters
    ----------
    recorder : Recorder
        The program.
    body : callable
        Returns the blocks of a body, or of the ground, by its index.
    coordinates : CoordinateRecorder
        Recorder of the coordinates that forces act along.
    names : FormulaNames
        Names that formulas may depend on.
    by_body : sequence of SlotMatrix
        The velocities of each body.
    """

    def __init__(
        self,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        coordinates: CoordinateRecorder,
        names: FormulaNames,
        by_body: Sequence[SlotMatrix],
    ) -> None:
        self.recorder = recorder
        self.body = body
        self.coordinates = coordinates
        self.by_body = by_body
        self.names = names

    def effect(self, force: ForceElement) -> Effect:
        """M⁻¹f (c,) of a force on each body, and its power (1,) [W], recorded.

        The power is that of the part without potential energy, None where all has one.
        """
        blocks = facets_of(force).effect(self)
        ends = zip((force.i, force.j), blocks, strict=False)
        accelerations = {index: block for index, block in ends if index != GROUND_INDEX}
        return accelerations, blocks[2] if force.is_nonconservative else None

    def act(self, forces: Sequence[ForceElement], free: list[SlotMatrix]) -> dict[str, SlotMatrix]:
        """Add M⁻¹f of forces to accelerations; return the power of those that work, by name.

        Parameters
        ----------
        forces : sequence of ForceElement
            Forces of the scene.
        free : list of SlotMatrix (c,) [m/s², rad/s²]
            Accelerations by body, which are replaced by the sums.
        """
        shares = [[block] for block in free]
        powers: dict[str, list[SlotMatrix]] = {}
        for force in forces:
            with self.recorder.of(force.name):
                accelerations, power = self.effect(force)
            for index, block in accelerations.items():
                shares[index].append(block)
            if power is not None:
                powers.setdefault(force.name, []).append(power)
        free[:] = [summed(self.recorder, blocks) for blocks in shares]
        return {name: summed(self.recorder, blocks) for name, blocks in powers.items()}

    def measure(self, system: System, source: Measure, value: SlotMatrix, rate: SlotMatrix) -> None:
        """Record a measure of the state that formulas read, x and ẋ (1,): (u − u⁰)/unit."""
        offset = column((0,))
        if source.force < 0:
            (x, unit), (v, _) = self.names[source.name], self.names[source.rate]
        else:
            x, v, free, unit = facets_of(system.forces[source.force]).elongation(self)
            offset = offset if source.is_length else free
        self.recorder.call(Relative(), x, offset, unit, into=(value,))
        self.recorder.call(Relative(), v, column((0,)), unit, into=(rate,))

    def gravity(self, system: System) -> SlotMatrix:
        """Acceleration of free fall g (3,) [m/s²], frame O, recorded."""
        components = [self.recorder.constant(system.gravity)]
        for axis, formula in enumerate(system.gravity_law):
            if formula:
                direction = self.recorder.constant([system.unit * (n == axis) for n in range(3)])
                components.append(scaled(self.recorder, direction, formula, self.names))
        return summed(self.recorder, components)

    def weight(self, system: System, gravity: SlotMatrix, mass: High) -> SlotMatrix:
        """Minus the weight of a body, −m g (3,) [N], frame O, recorded."""
        if not any(system.gravity_law):
            return self.recorder.constant([-mass * Fraction(g) for g in system.gravity])
        return self.recorder.call(MatrixProduct(), gravity, self.recorder.constant((-mass,)))[0]

    def constants(self, force: ForceElement) -> list[SlotMatrix]:
        """Record the constants of a force; those that have a formula are multiplied by it."""
        formulas = dict(force.formulas)
        blocks = []
        for name, values in force.constants:
            block = self.recorder.constant(values)
            if name in formulas:
                block = scaled(self.recorder, block, formulas[name], self.names)
            blocks.append(block)
        return blocks

    def law(self, force: ForceElement) -> tuple[tuple[str, ...], list[SlotMatrix]]:
        """Values and units that a law depends on beside elongation and rate."""
        if not force.law:
            return (), []
        names = tuple(name for name in used_names(force.law, self.names) if name not in ELONGATION)
        return names, [block for name in names for block in self.names[name]]
