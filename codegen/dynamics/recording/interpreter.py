"""Run a program without emitting it: in doubles, or in 50 digits for references."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import node_values

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program, Task
    from kousoku.model.operations.arithmetic import Arithmetic


class ProgramInterpreter:
    """The workspace of a program, with the start of the scene in it.

    Parameters
    ----------
    program : Program
        Program that is run.
    arithmetic : Arithmetic
        Arithmetic of its numbers: :data:`~kousoku.model.operations.arithmetic.FLOAT`, or
        :data:`~kousoku.model.numbers.digits.HIGH`.
    """

    def __init__(self, program: Program, arithmetic: Arithmetic[Any] = FLOAT) -> None:
        self.program = program
        self.arithmetic = arithmetic
        zero = arithmetic.number(Fraction(0))
        self.values: list[Any] = [zero] * program.size
        self["constants"] = [arithmetic.number(value) for value in program.constants]
        if program.parameters:
            self["parameters"] = [arithmetic.number(Fraction(x)) for x in program.parameters]
        places = [x for body in program.bodies for x in (*body.r, *body.p, *body.v, *body.omega_b)]
        places += [entry.place for entry in program.auxiliary]
        for place in places:
            if place.slot >= 0:
                self.values[place.slot] = arithmetic.number(Fraction(place.value))
        if program.design:
            self.run("setup")

    def __getitem__(self, name: str) -> list[Any]:
        """Content of a region."""
        region = self.program.region(name)
        return self.values[region.base : region.base + region.size]

    def __setitem__(self, name: str, values: Sequence[Any]) -> None:
        """Fill a region."""
        region = self.program.region(name)
        if len(values) != region.size:
            raise ValueError(f"region {name} has {region.size} slots, not {len(values)}")
        self.values[region.base : region.base + region.size] = values

    def run(self, *segments: str) -> None:
        """Run segments by their names, one after the other."""
        for name in segments:
            for task in self.program.segment(name).tasks:
                self.execute(task)

    def execute(self, task: Task) -> list[Any]:
        """Run a task; return the values of all nodes of its kernel."""
        kernel = self.program.kernels[task.kernel]
        inputs = {
            quantity.name: self.values[base : base + quantity.size]
            for base, quantity in zip(task.inputs, kernel.inputs, strict=True)
        }
        values = node_values(kernel, inputs, self.arithmetic)
        for base, result in zip(task.outputs, kernel.results, strict=True):
            self.values[base : base + len(result)] = [values[node] for node in result]
        return values
