"""Straight-line text of one choice of outputs: shared terms, then the outputs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.printers import FUNCTIONS, C, Text
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.context_names import Namer
    from kousoku.codegen.printers import Printer
    from kousoku.model.operations.kernel import Kernel

#: Longest name and right-hand side together: what C writes around them keeps it within 100.
WIDTH = 77


@dataclass(frozen=True, slots=True)
class Assignment:
    """Assignment of a value to a name.

    Parameters
    ----------
    name, text : str
        ``name = text``.
    function : str
        Function that is called; empty for arithmetic.
    arguments : tuple of str
        Arguments of the call: names, never expressions.
    is_number : bool
        Whether the value is a constant.
    ready : tuple of (str, str)
        The elements of outputs that can be written now, and their expressions.
    """

    name: str
    text: str
    function: str
    arguments: tuple[str, ...]
    is_number: bool
    ready: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class OutputText:
    """Elements of one output.

    Parameters
    ----------
    name : str
        Name of the output in the text.
    size : int
        Count of its elements.
    elements : tuple of str
        The expressions of all elements.
    numbers : tuple of (int, str)
        Flat index and text of those that are numbers, zero left out.
    others : tuple of (int, str)
        Flat index and expression of those that are not identically zero.
    has_zeros : bool
        Whether some are identically zero.
    """

    name: str
    size: int
    elements: tuple[str, ...]
    numbers: tuple[tuple[int, str], ...]
    others: tuple[tuple[int, str], ...]
    has_zeros: bool


def live_nodes(kernel: Kernel, outputs: Sequence[int]) -> list[int]:
    """Nodes that some outputs need, in topological order."""
    needed = [False] * len(kernel.nodes)
    for output in outputs:
        for node in kernel.results[output]:
            needed[node] = True
    for node in range(len(kernel.nodes) - 1, -1, -1):
        if needed[node]:
            for arg in kernel.nodes[node].args:
                needed[arg] = True
    return [node for node, is_needed in enumerate(needed) if is_needed]


def count_operations(kernel: Kernel, outputs: Sequence[int]) -> int:
    """Number of operations that some outputs need."""
    live = live_nodes(kernel, outputs)
    return sum(kernel.nodes[node].op not in {Op.CONST, Op.INPUT} for node in live)


@dataclass(frozen=True, slots=True)
class LineLayout:
    """Nodes that some outputs need, and where lines begin: the same in every language.

    Parameters
    ----------
    kernel : Kernel
        The whole kernel.
    outputs : tuple of int
        Those that are written.
    before : frozenset of int
        The nodes that are known already.
    live : tuple of int
        The others that they need, in topological order.
    lines : tuple of int
        The nodes that get a line of their own, in the order of the lines.
    """

    kernel: Kernel
    outputs: tuple[int, ...]
    before: frozenset[int]
    live: tuple[int, ...]
    lines: tuple[int, ...]


def layout(
    kernel: Kernel,
    outputs: tuple[int, ...],
    leaves: Mapping[tuple[str, int], str],
    *,
    live: Sequence[int] | None = None,
    before: frozenset[int] = frozenset(),
    used_later: frozenset[int] = frozenset(),
) -> LineLayout:
    """Decide which nodes get a line of their own.

    A node with one use is written where it is used, as long as the line stays short; nodes that
    have a name or are used later, calls, and operands of calls stand alone.

    Parameters
    ----------
    kernel : Kernel
        The whole kernel.
    outputs : tuple of int
        Those that are written.
    leaves : mapping
        The text of each element of the inputs.
    live : sequence of int, optional
        The nodes to compute, in topological order; by default those that the outputs need.
    before, used_later : frozenset of int
        The nodes that are known already, and those to compute that others will need.
    """
    live = live_nodes(kernel, outputs) if live is None else live
    uses = Counter(arg for node in live for arg in kernel.nodes[node].args)
    uses.update(node for output in outputs for node in kernel.results[output])
    names = dict(kernel.names)
    alone = set(names) | used_later
    for node in live:
        if kernel.nodes[node].op in FUNCTIONS:
            alone.update((node, *kernel.nodes[node].args))
    texts = {
        node: Text(names.get(node, "t000"))
        if kernel.nodes[node].args
        else _text(kernel, node, C, leaves, {})
        for node in before
    }
    order: list[int] = []

    def settle(node: int) -> None:
        order.append(node)
        texts[node] = Text(names.get(node, "t000"))

    for node in live:
        op, args = kernel.nodes[node].op, kernel.nodes[node].args
        texts[node] = _text(kernel, node, C, leaves, texts)
        while len(texts[node].text) + len(names.get(node, "t000")) > WIDTH:
            settle(max(args, key=lambda arg: len(texts[arg].text)))
            texts[node] = _text(kernel, node, C, leaves, texts)
        is_leaf = op is Op.INPUT or (op is Op.CONST and node in used_later)
        if not is_leaf and (node in alone or (args and uses[node] > 1)):
            settle(node)
    return LineLayout(kernel, outputs, before, tuple(live), tuple(order))


def straight_line(
    plan: LineLayout,
    printer: Printer,
    leaves: Mapping[tuple[str, int], str],
    namer: Namer,
    known: Mapping[int, Text] | None = None,
) -> tuple[tuple[Assignment, ...], dict[int, Text]]:
    """Statements of a layout in one language, and the text of every node so far."""
    kernel, names = plan.kernel, dict(plan.kernel.names)
    symbols = {
        node: namer.take(names[node]) if node in names else namer.temporary() for node in plan.lines
    }
    texts = dict(known or {})
    lines: dict[int, Assignment] = {}
    for node in plan.live:
        op, args = kernel.nodes[node].op, kernel.nodes[node].args
        texts[node] = _text(kernel, node, printer, leaves, texts)
        if node in symbols:
            call = printer.functions.get(op, "")
            operands = tuple(texts[arg].text for arg in args) if call else ()
            lines[node] = Assignment(
                symbols[node], texts[node].text, call, operands, texts[node].is_number
            )
            texts[node] = Text(symbols[node])
    return tuple(lines[node] for node in plan.lines), texts


def _text(
    kernel: Kernel,
    node: int,
    printer: Printer,
    leaves: Mapping[tuple[str, int], str],
    texts: Mapping[int, Text],
) -> Text:
    item = kernel.nodes[node]
    if item.symbol is not None:
        return Text(leaves[item.symbol])
    if item.value is not None:
        return printer.constant(item.value)
    return printer.apply(item.op, [texts[arg] for arg in item.args])


def output_text(kernel: Kernel, output: int, name: str, texts: Mapping[int, Text]) -> OutputText:
    """Lines that are written into one output, given the texts of :func:`straight_line`."""
    nodes = kernel.results[output]
    values = [kernel.nodes[node].value for node in nodes]
    return OutputText(
        name=name,
        size=len(nodes),
        elements=tuple(texts[node].text for node in nodes),
        numbers=tuple((k, texts[n].text) for k, n in enumerate(nodes) if values[k]),
        others=tuple((k, texts[n].text) for k, n in enumerate(nodes) if values[k] != 0),
        has_zeros=any(value == 0 for value in values),
    )


def with_outputs(
    plan: LineLayout,
    statements: Sequence[Assignment],
    outputs: Sequence[OutputText],
) -> tuple[tuple[tuple[str, str], ...], tuple[Assignment, ...]]:
    """Outputs that can be written at once, and the statements with those that each makes ready.

    To write early keeps few values alive, and spreads the traffic to memory.
    """
    kernel = plan.kernel
    line = {node: k for k, node in enumerate(plan.lines)}
    known = dict.fromkeys(plan.before, -1)
    for node in plan.live:
        args = kernel.nodes[node].args
        known[node] = line.get(node, max((known[arg] for arg in args), default=-1))
    ready: list[list[tuple[str, str]]] = [[] for _ in range(len(statements) + 1)]
    for output, text in zip(plan.outputs, outputs, strict=True):
        for k, node in enumerate(kernel.results[output]):
            if kernel.nodes[node].value is None:
                ready[known[node]].append((f"{text.name}[{k}]", text.elements[k]))
    return tuple(ready[-1]), tuple(
        replace(statement, ready=tuple(items))
        for statement, items in zip(statements, ready, strict=False)
    )
