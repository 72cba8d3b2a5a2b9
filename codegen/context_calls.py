"""Arguments of a kernel, as C declares, loads, stores and passes them."""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING

from kousoku.codegen.context_lines import ascii_of, filled_lines, plain
from kousoku.codegen.context_records import ArgumentContext, CallsContext

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.context_names import Namer
    from kousoku.model.files.quantity import Quantity


def arguments_of(quantities: Sequence[Quantity], namer: Namer) -> tuple[ArgumentContext, ...]:
    """Contexts of the inputs or the outputs of a kernel."""
    symbols = [namer.take(quantity.name) for quantity in quantities]
    shapes = [str(quantity.shape).replace(",)", ")") for quantity in quantities]
    columns = list(zip(symbols, shapes, (f"[{q.unit}]" for q in quantities), strict=True))
    widths = [max(map(len, column), default=0) for column in zip(*columns, strict=True)]
    return tuple(
        ArgumentContext(
            name=quantity.name,
            symbol=symbol,
            index=index,
            size=quantity.size,
            shape=str(quantity.shape),
            batched=f"({', '.join(['...', *map(str, quantity.shape)])}) [{quantity.unit}]",
            meaning=plain(quantity.meaning),
            rows=_table_rows(cells, widths, ascii_of(plain(quantity.meaning))),
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


def unwanted_of(outputs: Sequence[ArgumentContext], namer: Namer) -> tuple[str, ...]:
    """Arrays that outputs are computed into where they are not wanted."""
    return tuple(namer.take(f"unwanted_{a.name}") for a in outputs)


def calls_of(inputs: Sequence[ArgumentContext], outputs: Sequence[ArgumentContext]) -> CallsContext:
    """Arguments as each call of C passes them."""
    signature = [f"{a.name}[{a.size}]" for a in inputs]
    signature += ["->", *(f"{a.name}[{a.size}]" for a in outputs)]
    return CallsContext(
        pointers=(*(f"in[{a.index}]" for a in inputs), *(f"out[{a.index}]" for a in outputs)),
        single=(
            *(f"in[{a.index}] + i * stride[{a.index}]" for a in inputs),
            *(f"out[{a.index}] ? out[{a.index}] + i * {a.size} : NULL" for a in outputs),
        ),
        arrays=filled_lines(
            [f"{a.symbol}[{a.size}]" for a in (*inputs, *outputs)], " " * 12
        ).lstrip(),
        signature="\n        ".join(f'"{line}"' for line in _strings(signature)),
    )


def _strings(words: Sequence[str]) -> list[str]:
    """Words in lines that fit, each but the last with a blank at its end."""
    lines = wrap(" ".join(words), 80, break_long_words=False, break_on_hyphens=False)
    return [f"{line} " for line in lines[:-1]] + lines[-1:]
