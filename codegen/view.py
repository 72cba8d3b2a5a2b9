"""From a kernel to the view of it that templates fill in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from textwrap import shorten, wrap
from typing import TYPE_CHECKING

from kousoku.codegen import printers
from kousoku.codegen.graph import Op
from kousoku.codegen.passes.trace import without_sharing
from kousoku.codegen.view_body import (
    Layout,
    count_operations,
    layout,
    output_text,
    straight_line,
    with_outputs,
)
from kousoku.codegen.view_calls import arguments_of, calls_of, unwanted_of
from kousoku.codegen.view_lines import ascii_of, plain
from kousoku.codegen.view_names import Namer, checked
from kousoku.codegen.view_records import ArgumentView, BodyText, BodyView, KernelView, PackageView

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.kernel import Kernel, Package
    from kousoku.codegen.printers import Printer

#: Operations on which Python's floats behave as arrays do, whatever the operands.
_POLYNOMIAL = frozenset({Op.ADD, Op.SUB, Op.MUL, Op.NEG})


def package_view(package: Package, version: str, digest: str) -> PackageView:
    """Return what the templates of all files get.

    Raises
    ------
    EmitError
        A name is no identifier, or an operation cannot be printed.
    """
    nodes = (node for kernel in package.kernels for node in kernel.nodes)
    return PackageView(
        name=checked(package.name, "package name"),
        title=plain(package.title),
        title_ascii=ascii_of(plain(package.title)),
        regenerate=plain(package.regenerate),
        version=version,
        digest=digest,
        kernels=tuple(kernel_view(kernel) for kernel in package.kernels),
        has_calls=any(node.op in printers.FUNCTIONS for node in nodes),
    )


def kernel_view(kernel: Kernel) -> KernelView:
    """Return what the templates see of one kernel."""
    namer = Namer()
    for quantity in (*kernel.inputs, *kernel.outputs):
        checked(quantity.name, f"argument of {kernel.name}")
    inputs = arguments_of(kernel.inputs, namer)
    outputs = arguments_of(kernel.outputs, namer)
    alone = _cheap_alone(kernel)
    unwanted = unwanted_of(outputs, namer)
    into = _declared("", outputs)
    everything = tuple(range(len(outputs)))
    bodies = (
        _Choice(kernel, choice, (inputs, outputs)).body()
        for choice in (everything, *((k,) for k in alone))
    )
    formula, source = kernel.formula, f"({kernel.source})" if kernel.source else ""
    return KernelView(
        name=checked(kernel.name, "kernel name"),
        heading=_wrapped(ascii_of(f"{kernel.name}: {kernel.title}")),
        summary=_summary(kernel),
        about=(*_wrapped(formula), *_wrapped(source)),
        about_ascii=(*_wrapped(ascii_of(formula)), *_wrapped(ascii_of(source))),
        cost=_cost(kernel),
        inputs=inputs,
        outputs=outputs,
        declared=_declared("const double *KOUSOKU_RESTRICT ", inputs)
        + _declared("double *KOUSOKU_RESTRICT ", outputs),
        parameters=_declared("in_array ", inputs) + _declared("out_array ", outputs),
        arguments=_declared("", inputs) + into,
        calls=calls_of(inputs, outputs),
        flags=tuple(namer.take(f"with_{a.name}") for a in outputs),
        unwanted=", ".join(f"{x}[{a.size}]" for x, a in zip(unwanted, outputs, strict=True)),
        alone_calls=tuple(
            (*_declared("", inputs), *unwanted[:k], into[k], *unwanted[k + 1 :]) for k in everything
        ),
        bodies=tuple(bodies),
        is_polynomial=set(kernel.operations) <= _POLYNOMIAL,
    )


def _cheap_alone(kernel: Kernel) -> tuple[int, ...]:
    """Return the outputs that need at most half of the operations, which get a body of their own.

    For any other the body for all outputs runs: it costs at most twice as much.
    """
    everything = range(len(kernel.outputs))
    if len(everything) == 1:
        return ()
    whole = count_operations(kernel, everything)
    return tuple(k for k in everything if 2 * count_operations(kernel, (k,)) <= whole)


def _declared(kind: str, arguments: tuple[ArgumentView, ...]) -> tuple[str, ...]:
    return tuple(f"{kind}{argument.symbol}" for argument in arguments)


#: Where a count of operations without sharing ends: it grows exponentially.
_COUNTLESS = 10**6


@dataclass(frozen=True, slots=True)
class _Choice:
    """One choice of the outputs of a kernel, before it is printed."""

    kernel: Kernel
    outputs: tuple[int, ...]
    arguments: tuple[tuple[ArgumentView, ...], tuple[ArgumentView, ...]]

    def body(self) -> BodyView:
        """Return the text in C and in NumPy, line by line the same."""
        kernel, (inputs, outputs) = self.kernel, self.arguments
        elements = [(a, k) for a in inputs for k in range(a.size)]
        in_c = {(a.name, k): f"{a.symbol}[{k}]" for a, k in elements}
        plan = layout(kernel, self.outputs, in_c)
        live = {kernel.nodes[node].symbol for node in plan.live}
        namer = self._namer()
        in_numpy = {
            (a.name, k): namer.take(f"{a.symbol}_{k}") if (a.name, k) in live else "_"
            for a, k in elements
        }
        written = tuple(outputs[k] for k in self.outputs)
        is_all = len(written) == len(outputs)
        return BodyView(
            name="all" if is_all else written[0].name,
            function=f"{kernel.name}_elements" if is_all else f"_{kernel.name}_{written[0].name}",
            outputs=written,
            c=self._text(plan, printers.C, in_c, self._namer()),
            numpy=self._text(plan, printers.NUMPY, in_numpy, namer),
        )

    def _namer(self) -> Namer:
        namer = Namer()
        for side in self.arguments:
            for argument in side:
                namer.keep(argument.symbol)
        return namer

    def _text(
        self,
        plan: Layout,
        printer: Printer,
        leaves: Mapping[tuple[str, int], str],
        namer: Namer,
    ) -> BodyText:
        kernel, (inputs, outputs) = self.kernel, self.arguments
        statements, texts = straight_line(plan, printer, leaves, namer)
        symbols = [kernel.nodes[node].symbol for node in texts]
        reads = {symbol[0] for symbol in symbols if symbol is not None}
        is_public = len(self.outputs) == len(outputs) and printer is printers.NUMPY
        read = tuple(a for a in inputs if is_public or a.name in reads)
        results = tuple(output_text(kernel, k, outputs[k].symbol, texts) for k in self.outputs)
        first, statements = with_outputs(plan, statements, results)
        return BodyText(
            inputs=read,
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
    title = plain(kernel.title)
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


def _wrapped(text: str) -> tuple[str, ...]:
    return tuple(wrap(plain(text), width=88, break_on_hyphens=False))
