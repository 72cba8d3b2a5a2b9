"""The stages of kernels: the graph that a derivation is frozen into, and savings by passes."""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from kousoku.codegen.freeze import freeze
from kousoku.codegen.passes.optimise import optimise
from kousoku.codegen.passes.rebuild import with_outputs
from kousoku.codegen.passes.trace import without_sharing
from kousoku.model.errors import DerivationError
from kousoku.model.text import counted, table
from kousoku.symbolic.matrices import elements, symbol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from kousoku.model.operations.kernel import Kernel
    from kousoku.symbolic.derivation import Derivation, Function

#: Heads of the table that is printed.
HEADS = ("kernel", "frozen from", "not shared", "shared", "drop_dead", "factor", "bytes")
#: The levels of a derivation that a graph can be frozen from; the matrix level is emitted.
DERIVATION_LEVELS = ("components", "matrix level")


@dataclass(frozen=True, slots=True)
class Stage:
    """The operations of one kernel, frozen from one level of its derivation.

    Parameters
    ----------
    kernel, level : str
        The kernel, and ``components`` or ``matrix level``.
    not_shared, shared : int
        Operations if every use of a value computed it again, and with each value computed once.
    after_drop_dead, after_factor : int
        Operations that are left after each pass.
    bytes : int
        The largest number of intermediate results that are alive at once, times eight.
    """

    kernel: str
    level: str
    not_shared: int
    shared: int
    after_drop_dead: int
    after_factor: int
    bytes: int


@dataclass(frozen=True)
class KernelExplanation:
    """Stages of the formulas of a derivation on the way to its kernels.

    ``print`` shows the operations of each kernel, stage by stage: frozen from the components, as it
    would be to print SymPy's formulas as they are, and from the matrix level, which is emitted.

    Parameters
    ----------
    derivation : Derivation
        The derivation.
    """

    derivation: Derivation

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The operations of each kernel, from both levels."""
        return tuple(
            _stage(function, level)
            for function in self.derivation.functions
            for level in DERIVATION_LEVELS
        )

    def graph(self, kernel: str, *outputs: str) -> Kernel:
        """Frozen graph of a kernel: its nodes, each an operation and its operands.

        Parameters
        ----------
        kernel : str
            The kernel, e.g. ``constraint``.
        *outputs : str
            The outputs that are wanted; what only others need is dropped. All unless named.

        Raises
        ------
        DerivationError
            There is no such kernel, or no such output.
        """
        functions = {function.name: function for function in self.derivation.functions}
        frozen = freeze(functions[self._known("kernel", kernel, functions)])
        names = [quantity.name for quantity in frozen.outputs]
        if not outputs:
            return frozen
        chosen = [self._known(f"output of {kernel}", name, names) for name in outputs]
        return with_outputs(frozen, chosen)

    def plot(self, kernel: str | None = None, *outputs: str) -> Figure:
        """Draw the operations as bars, stage by stage; or the graph of one small kernel.

        Parameters
        ----------
        kernel : str, optional
            The kernel whose graph is drawn, with each use computed again and with each value
            computed once; it needs matplotlib.
        *outputs : str
            As of :meth:`graph`.
        """
        from kousoku.view.graph_plots import draw_counts, draw_sharing

        name = self.derivation.name
        if kernel is not None:
            title = " ".join([f"{name}: {kernel}", *([", ".join(outputs)] if outputs else [])])
            return draw_sharing(self.graph(kernel, *outputs), title=title)
        counts: dict[str, list[int]] = {}
        for stage in self.stages:
            counts.setdefault(f"{stage.level}, shared", []).append(stage.shared)
            counts.setdefault(f"{stage.level}, after the passes", []).append(stage.after_factor)
        kernels = [function.name for function in self.derivation.functions]
        return draw_counts(counts, kernels, title=f"operations of {name}, stage by stage")

    def as_data(self) -> dict[str, Any]:
        """Stages as data, ready for JSON."""
        fields = Stage.__dataclass_fields__
        rows = [dict(zip(fields, astuple(stage), strict=True)) for stage in self.stages]
        return {"name": self.derivation.name, "stages": rows}

    def __str__(self) -> str:
        rows = [tuple(map(str, astuple(stage))) for stage in self.stages]
        return table(HEADS, rows)

    def __repr__(self) -> str:
        kernels = counted(len(self.derivation.functions), "kernel")
        return f"<explanation of {self.derivation.name}: {kernels}; print() shows their operations>"

    def _known(self, sort: str, name: str, names: Any) -> str:
        """Name that is known.

        Raises
        ------
        DerivationError
            It is not.
        """
        if name in names:
            return name
        raise DerivationError(f"{self.derivation.name}: no {sort} {name!r}; has {', '.join(names)}")


def _stage(function: Function, level: str) -> Stage:
    """Stage of freezing and the passes for one level of a function."""
    frozen = freeze(function if level == DERIVATION_LEVELS[1] else _from_components(function))
    _, trace = optimise(frozen)
    dead, factored = trace
    return Stage(
        function.name,
        level,
        without_sharing(frozen),
        dead.operations_before,
        dead.operations_after,
        factored.operations_after,
        factored.bytes_after,
    )


def _from_components(function: Function) -> Function:
    """Function whose component level stands in place of its matrix level."""
    entries = {x: symbol(q)[k, 0] for q in function.inputs for k, x in enumerate(elements(q))}
    outputs = tuple(replace(o, expression=o.components.xreplace(entries)) for o in function.outputs)
    return replace(function, outputs=outputs)
