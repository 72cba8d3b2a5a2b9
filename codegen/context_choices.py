"""Bodies of kernels that differ in the choice of rows only: shared terms stand once."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen import printers
from kousoku.codegen.context_body import (
    layout,
    live_nodes,
    output_text,
    straight_line,
    with_outputs,
)
from kousoku.codegen.context_names import Namer
from kousoku.codegen.context_records import ArgumentContext, BodyContext, BodyText, TailText
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.printers import Printer
    from kousoku.model.operations.graph import OperationNode
    from kousoku.model.operations.kernel import Kernel

#: Operations whose operands may change places.
_COMMUTATIVE = frozenset({Op.ADD, Op.MUL})


@dataclass(frozen=True, slots=True)
class Bodies:
    """One choice of the outputs of a family of kernels, before it is printed.

    Parameters
    ----------
    kernels : tuple of Kernel
        They have the same arguments, and differ in the choice of rows; mostly one.
    name : str
        Name of the family.
    outputs : tuple of int
        Indices of those that are computed.
    arguments : tuple of (tuple of ArgumentContext, tuple of ArgumentContext)
        Inputs and outputs.
    """

    kernels: tuple[Kernel, ...]
    name: str
    outputs: tuple[int, ...]
    arguments: tuple[tuple[ArgumentContext, ...], tuple[ArgumentContext, ...]]

    def context(self) -> BodyContext:
        """Text in C and in NumPy, line by line the same."""
        inputs, outputs = self.arguments
        merged = merged_kernel(self.kernels)
        elements = [(a, k) for a in inputs for k in range(a.size)]
        in_c = {(a.name, k): f"{a.symbol}[{k}]" for a, k in elements}
        live = {merged.nodes[node].symbol for tail in self._live(merged) for node in tail}
        namer = self._namer()
        in_numpy = {
            (a.name, k): namer.take(f"{a.symbol}_{k}") if (a.name, k) in live else "_"
            for a, k in elements
        }
        written = tuple(outputs[k] for k in self.outputs)
        is_all = len(written) == len(outputs)
        return BodyContext(
            name="all" if is_all else written[0].name,
            function=f"{self.name}_elements" if is_all else f"_{self.name}_{written[0].name}",
            outputs=written,
            c=self._text(merged, printers.C, in_c, self._namer()),
            numpy=self._text(merged, printers.NUMPY, in_numpy, namer),
        )

    def _namer(self) -> Namer:
        namer = Namer()
        namer.keep("choice")
        for side in self.arguments:
            for argument in side:
                namer.keep(argument.symbol)
        return namer

    def _written(self, choice: int) -> tuple[int, ...]:
        """Outputs of one choice among those of all."""
        return tuple(choice * len(self.arguments[1]) + k for k in self.outputs)

    def _live(self, merged: Kernel) -> list[list[int]]:
        """Nodes that each choice needs."""
        return [live_nodes(merged, self._written(k)) for k in range(len(self.kernels))]

    def _text(
        self,
        merged: Kernel,
        printer: Printer,
        leaves: Mapping[tuple[str, int], str],
        namer: Namer,
    ) -> BodyText:
        inputs, outputs = self.arguments
        in_c = {(a.name, k): f"{a.symbol}[{k}]" for a in inputs for k in range(a.size)}
        needs = self._live(merged)
        common = frozenset(needs[0]).intersection(*needs[1:] or [[]])
        later = _used_later(merged, common, needs, [self._written(k) for k in range(len(needs))])
        plan = layout(merged, (), in_c, live=sorted(common), used_later=later)
        head, known = straight_line(plan, printer, leaves, namer)
        tails, symbols_read = [], {merged.nodes[node].symbol for need in needs for node in need}
        for choice, need in enumerate(needs):
            live = [node for node in need if node not in common]
            plan = layout(merged, self._written(choice), in_c, live=live, before=common)
            statements, texts = straight_line(plan, printer, leaves, deepcopy(namer), known)
            results = tuple(
                output_text(merged, number, outputs[k].symbol, texts)
                for k, number in zip(self.outputs, self._written(choice), strict=True)
            )
            first, statements = with_outputs(plan, statements, results)
            tails.append(TailText(first, statements, results))
        names = {symbol[0] for symbol in symbols_read if symbol is not None}
        is_public = len(self.outputs) == len(outputs) and printer is printers.NUMPY
        read_inputs = tuple(a for a in inputs if is_public or a.name in names)
        return BodyText(
            inputs=read_inputs,
            components=tuple(
                f"({leaves[a.name, 0]},)"
                if a.size == 1
                else ", ".join(leaves[a.name, k] for k in range(a.size))
                for a in read_inputs
            ),
            head=head,
            tails=tuple(dict.fromkeys(tails)) if len(set(tails)) == 1 else tuple(tails),
        )


def _used_later(
    merged: Kernel,
    common: frozenset[int],
    needs: Sequence[Sequence[int]],
    written: Sequence[Sequence[int]],
) -> frozenset[int]:
    """Common nodes that a choice uses or writes."""
    choice_nodes = {node for need in needs for node in need} - common
    used = {arg for node in choice_nodes for arg in merged.nodes[node].args}
    used.update(node for outputs in written for k in outputs for node in merged.results[k])
    return common & used


def merged_kernel(kernels: Sequence[Kernel]) -> Kernel:
    """Kernel with the outputs of several kernels, in which equal nodes are one.

    Sums and products are equal whatever the order of their operands, which no bit depends on.
    """
    if len(kernels) == 1:
        return kernels[0]
    nodes: list[OperationNode[int]] = []
    merged: dict[OperationNode[int], int] = {}
    results: list[tuple[int, ...]] = []
    names: dict[int, str] = {}
    for kernel in kernels:
        ids: list[int] = []
        for node in kernel.nodes:
            copy = node.with_args(tuple(ids[arg] for arg in node.args))
            key = copy
            if node.op in _COMMUTATIVE:
                key = copy.with_args(tuple(sorted(copy.args)))
            if key not in merged:
                merged[key] = len(nodes)
                nodes.append(copy)
            ids.append(merged[key])
        results += [tuple(ids[node] for node in result) for result in kernel.results]
        names |= {ids[node]: name for node, name in kernel.names if ids[node] not in names}
    return replace(
        kernels[0],
        outputs=tuple(output for kernel in kernels for output in kernel.outputs),
        nodes=tuple(nodes),
        results=tuple(results),
        names=tuple(names.items()),
    )
