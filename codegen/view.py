"""From a kernel to the view of it that templates fill in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from textwrap import shorten, wrap
from typing import TYPE_CHECKING

from kousoku.codegen import printers
from kousoku.codegen.graph import BINARY_OPS, Op
from kousoku.codegen.passes.trace import without_sharing
from kousoku.codegen.view_body import (
    Layout,
    layout,
    output_text,
    straight_line,
    with_outputs,
)
from kousoku.codegen.view_names import Namer, checked
from kousoku.codegen.view_records import (
    ArgumentView,
    BodyView,
    CallsView,
    KernelView,
    PackageView,
)
from kousoku.codegen.view_shuffles import load_view, store_view

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.kernel import Kernel, Package
    from kousoku.codegen.printers import Printer
    from kousoku.model.quantity import Quantity

#: Operations on which Python's floats behave as arrays do, whatever the operands.
_POLYNOMIAL = frozenset({Op.ADD, Op.SUB, Op.MUL, Op.NEG})


def package_view(package: Package, version: str, digest: str) -> PackageView:
    """Return what the templates of all files get.

    Raises
    ------
    EmitError
        A name is no identifier, or an operation cannot be printed.
    """
    kernels = package.kernels
    called = {node.op for kernel in kernels for node in kernel.nodes} & printers.FUNCTIONS
    return PackageView(
        name=checked(package.name, "package name"),
        title=_plain(package.title),
        regenerate=_plain(package.regenerate),
        version=version,
        digest=digest,
        kernels=tuple(kernel_view(kernel) for kernel in kernels),
        loads=tuple(map(load_view, sorted({q.size for k in kernels for q in k.inputs}))),
        stores=tuple(map(store_view, sorted({q.size for k in kernels for q in k.outputs}))),
        functions=tuple(
            (printers.C.functions[op], 2 if op in BINARY_OPS else 1) for op in Op if op in called
        ),
    )


def kernel_view(kernel: Kernel) -> KernelView:
    """Return what the templates see of one kernel."""
    namer = Namer()
    for quantity in (*kernel.inputs, *kernel.outputs):
        checked(quantity.name, f"argument of {kernel.name}")
    read = {node.symbol[0] for node in kernel.nodes if node.symbol is not None}
    inputs = _arguments(kernel.inputs, namer, read)
    outputs = _arguments(kernel.outputs, namer, {q.name for q in kernel.outputs})
    alone = range(len(outputs)) if len(outputs) > 1 else ()
    choices = (tuple(range(len(outputs))), *((k,) for k in alone))
    bodies = [_Choice(kernel, choice, (inputs, outputs)).bodies() for choice in choices]
    about = (*_wrapped(kernel.formula), *_wrapped(f"({kernel.source})" if kernel.source else ""))
    return KernelView(
        name=checked(kernel.name, "kernel name"),
        heading=_wrapped(f"{kernel.name}: {kernel.title}"),
        summary=_summary(kernel),
        about=about,
        cost=_cost(kernel),
        inputs=inputs,
        outputs=outputs,
        calls=_calls(inputs, outputs),
        c=tuple(in_c for in_c, _ in bodies),
        numpy=tuple(in_numpy for _, in_numpy in bodies),
        is_polynomial=set(kernel.operations) <= _POLYNOMIAL,
    )


def _arguments(
    quantities: Sequence[Quantity], namer: Namer, used: set[str]
) -> tuple[ArgumentView, ...]:
    symbols = [namer.take(quantity.name) for quantity in quantities]
    shapes = [str(quantity.shape).replace(",)", ")") for quantity in quantities]
    columns = list(zip(symbols, shapes, (f"[{q.unit}]" for q in quantities), strict=True))
    widths = [max(map(len, column), default=0) for column in zip(*columns, strict=True)]
    return tuple(
        ArgumentView(
            name=quantity.name,
            symbol=symbol,
            index=index,
            size=quantity.size,
            shape=str(quantity.shape),
            batched=f"{_batched(quantity.shape)} [{quantity.unit}]",
            meaning=_plain(quantity.meaning),
            rows=_table_rows(cells, widths, _plain(quantity.meaning)),
            is_used=quantity.name in used,
        )
        for index, (quantity, symbol, cells) in enumerate(
            zip(quantities, symbols, columns, strict=True)
        )
    )


def _table_rows(cells: Sequence[str], widths: Sequence[int], meaning: str) -> tuple[str, ...]:
    left = "".join(f"{cell:<{width}}  " for cell, width in zip(cells, widths, strict=True))
    lines = wrap(meaning, width=max(30, 88 - len(left)), break_on_hyphens=False) or [""]
    margin = " " * len(left)
    return tuple(f"{margin if k else left}{line}".rstrip() for k, line in enumerate(lines))


def _batched(shape: tuple[int, ...]) -> str:
    return f"({', '.join(['...', *map(str, shape)])})"


def _calls(inputs: tuple[ArgumentView, ...], outputs: tuple[ArgumentView, ...]) -> CallsView:
    ins, outs = [a.symbol for a in inputs], [a.symbol for a in outputs]
    return CallsView(
        symbols=_joined(ins + outs),
        pointers=_joined([f"in[{a.index}]" for a in inputs] + [f"out[{a.index}]" for a in outputs]),
        single=_joined(
            [f"in[{a.index}] + i * stride[{a.index}]" for a in inputs]
            + [f"out[{a.index}] ? out[{a.index}] + i * {a.size} : NULL" for a in outputs]
        ),
        lanes=_joined(
            [f"in[{a.index}] + block * {a.size}" for a in inputs]
            + [f"out[{a.index}] ? out[{a.index}] + block * {a.size} : NULL" for a in outputs]
        ),
        names_in=_joined([f'"{a.name}"' for a in inputs]),
        names_out=_joined([f'"{a.name}"' for a in outputs]),
    )


def _joined(items: Sequence[str], separator: str = ",") -> str:
    """Return a list of arguments, broken between them into lines that fit."""
    lines = [""]
    for item in items:
        if len(lines[-1]) + len(item) > 80:
            lines.append("")
        lines[-1] += f" {item}{separator}" if lines[-1] else f"{item}{separator}"
    return "\n            ".join(lines).removesuffix(separator)


#: Where a count of operations without sharing ends: it grows exponentially.
_COUNTLESS = 10**6


@dataclass(frozen=True, slots=True)
class _Choice:
    """One choice of the outputs of a kernel, before it is printed."""

    kernel: Kernel
    outputs: tuple[int, ...]
    arguments: tuple[tuple[ArgumentView, ...], tuple[ArgumentView, ...]]

    def bodies(self) -> tuple[BodyView, BodyView]:
        """Return the text in C and in NumPy, line by line the same."""
        inputs = self.arguments[0]
        kernel, elements = self.kernel, [(a, k) for a in inputs for k in range(a.size)]
        in_c = {(a.name, k): f"{a.symbol}[{k}]" for a, k in elements}
        plan = layout(kernel, self.outputs, in_c)
        live = {kernel.nodes[node].symbol for node in plan.live}
        namer = self._namer()
        in_numpy = {
            (a.name, k): namer.take(f"{a.symbol}_{k}") if (a.name, k) in live else "_"
            for a, k in elements
        }
        return (
            self._body(plan, printers.C, in_c, self._namer()),
            self._body(plan, printers.NUMPY, in_numpy, namer),
        )

    def _namer(self) -> Namer:
        namer = Namer()
        for side in self.arguments:
            for argument in side:
                namer.keep(argument.symbol)
        return namer

    def _body(
        self,
        plan: Layout,
        printer: Printer,
        leaves: Mapping[tuple[str, int], str],
        namer: Namer,
    ) -> BodyView:
        kernel, (inputs, outputs) = self.kernel, self.arguments
        statements, texts = straight_line(plan, printer, leaves, namer)
        symbols = [kernel.nodes[node].symbol for node in texts]
        reads = {symbol[0] for symbol in symbols if symbol is not None}
        written = tuple(outputs[k] for k in self.outputs)
        is_all = len(written) == len(outputs)
        is_public = is_all and printer is printers.NUMPY
        read = tuple(a for a in inputs if is_public or a.name in reads)
        results = tuple(output_text(kernel, a.index, a.symbol, texts) for a in written)
        first, statements = with_outputs(plan, statements, results)
        return BodyView(
            name="all" if is_all else written[0].name,
            function=f"{kernel.name}_elements"
            if is_public
            else f"_{kernel.name}_{written[0].name}",
            inputs=read,
            outputs=written,
            is_wanted=_joined([f"out[{a.index}]" for a in written], " &&"),
            arguments=_joined([a.symbol for a in (*read, *written)]),
            components=tuple(
                f"({leaves[a.name, 0]},)"
                if a.size == 1
                else ", ".join(leaves[a.name, k] for k in range(a.size))
                for a in read
            ),
            first=first,
            statements=statements,
            results=results,
        )


def _summary(kernel: Kernel) -> str:
    """Return the title on one line; what stands in brackets goes first where it is too long."""
    title = _plain(kernel.title)
    brief = re.sub(r" \([^()]*\)", "", title)
    texts = (f"{kernel.name}: {title}", f"{kernel.name}: {brief}", brief)
    text = next((text for text in texts if len(text) <= 84), brief)
    return shorten(f"Compute {text}", 92, placeholder=" …").rstrip(".") + "."


def _cost(kernel: Kernel) -> tuple[str, ...]:
    """Return the operations that run, and how many it would be if nothing were shared."""
    counts = kernel.operations
    parts = [f"{counts[op]} {op.value}" for op in Op if counts[op]]
    if not parts:
        return ("no operations",)
    tree = without_sharing(kernel)
    before = str(tree) if tree < _COUNTLESS else f"over {_COUNTLESS:.0e}"
    return _wrapped(f"{', '.join(parts)} (before sharing: {before} in all)")


def _plain(text: str) -> str:
    """Return ``text`` on one line, harmless inside a comment of C and a docstring of Python."""
    line = " ".join(text.split())
    return line.replace("\\", "/").replace("*/", "* /").replace("/*", "/ *").replace('"""', "'''")


def _wrapped(text: str) -> tuple[str, ...]:
    return tuple(wrap(_plain(text), width=88, break_on_hyphens=False))
