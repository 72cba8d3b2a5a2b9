"""Context of the templates of a package of kernels."""

from __future__ import annotations

import re
from dataclasses import replace
from textwrap import shorten, wrap
from typing import TYPE_CHECKING

from kousoku.codegen import printers
from kousoku.codegen.context_body import count_operations
from kousoku.codegen.context_calls import arguments_of, calls_of, unwanted_of
from kousoku.codegen.context_choices import Bodies
from kousoku.codegen.context_lines import ascii_of, plain
from kousoku.codegen.context_names import Namer, identifier
from kousoku.codegen.context_records import ArgumentContext, KernelContext, PackageContext
from kousoku.codegen.passes.trace import without_sharing
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.operations.kernel import Kernel, Package

#: Operations on which Python's floats behave as arrays do, whatever the operands.
_POLYNOMIAL = frozenset({Op.ADD, Op.SUB, Op.MUL, Op.NEG})


def package_context(package: Package, version: str, digest: str) -> PackageContext:
    """Context of the templates of all files.

    Raises
    ------
    EmitError
        A name is no identifier, or an operation cannot be printed.
    """
    nodes = (node for kernel in package.kernels for node in kernel.nodes)
    return PackageContext(
        name=identifier(package.name, "package name"),
        title=plain(package.title),
        title_ascii=ascii_of(plain(package.title)),
        regenerate=plain(package.regenerate),
        version=version,
        digest=digest,
        kernels=tuple(
            context
            for family in package.families
            for context in _kernel_contexts(family, package.choices)
        ),
        has_calls=any(node.op in printers.FUNCTIONS for node in nodes),
        has_choices=bool(package.choices),
    )


def _kernel_contexts(family: Sequence[Kernel], choices: Sequence[str]) -> Iterator[KernelContext]:
    """Contexts of kernels that differ in the choice of rows only."""
    kernel, namer = family[0], Namer()
    name = kernel.name.removesuffix(f"_{choices[0]}") if choices else kernel.name
    for quantity in (*kernel.inputs, *kernel.outputs):
        identifier(quantity.name, f"argument of {kernel.name}")
    inputs = arguments_of(kernel.inputs, namer)
    outputs = arguments_of(kernel.outputs, namer)
    unwanted = unwanted_of(outputs, namer)
    output_arguments = _declared("", outputs)
    all_outputs = tuple(range(len(outputs)))
    bodies = tuple(
        Bodies(tuple(family), name, chosen, (inputs, outputs)).context()
        for chosen in (all_outputs, *((k,) for k in _cheap_alone(kernel)))
    )
    costs = {member.name: _cost(member) for member in family}
    first = KernelContext(
        name=identifier(kernel.name, "kernel name"),
        family=name,
        choice=("0",) if choices else (),
        is_first=True,
        names=", ".join(costs),
        heading=_wrapped(ascii_of(f"{', '.join(costs)}: {kernel.title}")),
        summary=_summary(kernel),
        about=(*_wrapped(kernel.formula), *_wrapped(_source(kernel))),
        about_ascii=(*_wrapped(ascii_of(kernel.formula)), *_wrapped(ascii_of(_source(kernel)))),
        cost=costs[kernel.name],
        family_cost=tuple(dict.fromkeys(line for cost in costs.values() for line in cost)),
        inputs=inputs,
        outputs=outputs,
        declared=_declared("const double *KOUSOKU_RESTRICT ", inputs)
        + _declared("double *KOUSOKU_RESTRICT ", outputs),
        parameters=_declared("in_array ", inputs) + _declared("out_array ", outputs),
        arguments=_declared("", inputs) + output_arguments,
        calls=calls_of(inputs, outputs),
        flags=tuple(namer.take(f"with_{a.name}") for a in outputs),
        unwanted=", ".join(f"{x}[{a.size}]" for x, a in zip(unwanted, outputs, strict=True)),
        alone_calls=tuple(
            (*_declared("", inputs), *unwanted[:k], output_arguments[k], *unwanted[k + 1 :])
            for k in all_outputs
        ),
        bodies=bodies,
        is_polynomial=set(kernel.operations) <= _POLYNOMIAL,
    )
    yield first
    for number, other in enumerate(family[1:], 1):
        yield replace(
            first,
            name=identifier(other.name, "kernel name"),
            choice=(str(number),),
            is_first=False,
            summary=_summary(other),
            cost=costs[other.name],
        )


def _source(kernel: Kernel) -> str:
    return f"({kernel.source})" if kernel.source else ""


def _cheap_alone(kernel: Kernel) -> tuple[int, ...]:
    """Outputs that need at most half of the operations, which get a body of their own.

    For other outputs the body for all of them runs: it costs at most twice as much.
    """
    all_outputs = range(len(kernel.outputs))
    if len(all_outputs) == 1:
        return ()
    total = count_operations(kernel, all_outputs)
    return tuple(k for k in all_outputs if 2 * count_operations(kernel, (k,)) <= total)


def _declared(kind: str, arguments: tuple[ArgumentContext, ...]) -> tuple[str, ...]:
    return tuple(f"{kind}{argument.symbol}" for argument in arguments)


#: Largest count of operations without sharing that is told: it grows exponentially.
_COUNTLESS = 10**6


def _summary(kernel: Kernel) -> str:
    """Title on one line; text in brackets goes first where it is too long."""
    title = plain(kernel.title)
    brief = re.sub(r" \([^()]*\)", "", title)
    texts = (f"{kernel.name}: {title}", f"{kernel.name}: {brief}", brief)
    text = next((text for text in texts if len(text) <= 84), brief)
    return shorten(f"Compute {text}", 92, placeholder=" …").rstrip(".") + "."


def _cost(kernel: Kernel) -> tuple[str, ...]:
    """Counts of the operations that run, and their count without sharing."""
    counts = kernel.operations
    parts = [f"{counts[op]} {op.value}" for op in Op if counts[op]]
    if not parts:
        return ("no operations",)
    tree = without_sharing(kernel)
    before = str(tree) if tree < _COUNTLESS else f"over {_COUNTLESS:.0e}"
    return _wrapped(f"{', '.join(parts)} (before sharing: {before} in all)")


def _wrapped(text: str) -> tuple[str, ...]:
    return tuple(wrap(plain(text), width=88, break_on_hyphens=False))
