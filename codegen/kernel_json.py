"""Frozen kernels as text: the file ``graph.json.gz`` of a generated package, and back.

With it a scene is composed of the kinds that are shipped, and SymPy is not started.
"""

from __future__ import annotations

import hashlib
import json
import re
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from kousoku.model.errors import LoadError
from kousoku.model.files.cache import cache_folder, write_atomically
from kousoku.model.files.compressed import content
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import GRAPH_OPS, Op, OperationNode
from kousoku.model.operations.kernel import Kernel, Package
from kousoku.model.records.own_kind import PREFIX, is_own, kind_name
from kousoku.symbolic.kinds import KINDS

if TYPE_CHECKING:
    from pathlib import Path

GRAPH_FORMAT = 2
GRAPH_FILE = "graph.json.gz"
#: Signs of the operations that stand between the ids of their operands, as in ``12*40``.
SIGNS = {Op.ADD: "+", Op.SUB: "-", Op.MUL: "*", Op.DIV: "/"}
_SIGNED = re.compile(r"(\d+)([-+*/])(\d+)")
_INPUT = re.compile(r"(\w+)\[(\d+)\]")
#: Packages of one's own that this process knows, by the names that their content gives them.
_OWN: dict[str, Package] = {}


def dump(package: Package) -> str:
    """Content of ``graph.json.gz``; equal packages give equal bytes."""
    return to_text(
        {
            "format": GRAPH_FORMAT,
            "name": package.name,
            "title": package.title,
            "regenerate": package.regenerate,
            **({"choices": package.choices} if package.choices else {}),
            "kernels": [_kernel_to_data(kernel) for kernel in package.kernels],
        }
    )


def parse(text: str) -> Package:
    """Package that :func:`dump` wrote.

    Raises
    ------
    LoadError
        The text is not a package of this format.
    """
    try:
        data: dict[str, Any] = json.loads(text)
        if data["format"] != GRAPH_FORMAT:
            raise ValueError(f"format {data['format']} instead of {GRAPH_FORMAT}")
        kernels = tuple(_kernel_from_data(kernel) for kernel in data["kernels"])
        choices = tuple(data.get("choices", ()))
        return Package(data["name"], data["title"], data["regenerate"], kernels, choices)
    except (ValueError, KeyError, TypeError, IndexError, ZeroDivisionError) as problem:
        raise LoadError(
            f"this {GRAPH_FILE} cannot be read: {type(problem).__name__}: {problem};"
            " make it again with: kousoku generate"
        ) from problem


def shipped_kinds() -> tuple[str, ...]:
    """Kinds that are shipped, each choice of rows by itself, in order."""
    folder = resources.files("kousoku.generated.kinds")
    names = {x.name for x in folder.iterdir() if (x / GRAPH_FILE).is_file()}
    chosen = ((name, KINDS[name].packages if name in KINDS else (name,)) for name in names)
    return tuple(sorted(package for _, packages in chosen for package in packages))


def chosen(package: Package, choice: str) -> Package:
    """Package with one choice of rows, ``p2_z`` of ``p2``."""
    name, ending = f"{package.name}_{choice}", f"_{choice}"
    kernels = tuple(
        replace(kernel, name=kernel.name.removesuffix(ending))
        for kernel in package.kernels
        if kernel.name.endswith(ending)
    )
    return Package(name, package.title, f"kousoku generate {name}", kernels)


def keep_own(package: Package) -> str:
    """Keep a package of one's own, and return the name that :func:`load_frozen` finds it by.

    The name holds a digest of the kernels: a changed derivation has another one.
    Other processes of this user find the package in the cache, where that can be written.
    """
    text = dump(replace(package, regenerate=""))
    name = f"{PREFIX}{package.name}:{hashlib.sha256(text.encode()).hexdigest()[:32]}"
    if name not in _OWN:
        _OWN[name] = parse(text)
    with suppress(OSError):
        if not (path := _kept_at(name)).is_file():
            write_atomically(path, text.encode())
    return name


def _kept_at(name: str) -> Path:
    return cache_folder() / "derived" / f"own-{name.rpartition(':')[2]}.json"


def _load_own(name: str) -> Package:
    """Package of one's own, from this process or the cache.

    Raises
    ------
    LoadError
        Neither of them has it.
    """
    if name not in _OWN:
        with suppress(OSError, ValueError, LoadError):  # then it is not there
            package = parse(_kept_at(name).read_text(encoding="utf-8"))
            if keep_own(package) != name:
                raise LoadError(f"{name} is damaged")
    if name not in _OWN:
        kind = kind_name(name)
        raise LoadError(
            f"the kernels of {kind}, a kind of one's own, are not known here; load the scene with"
            f" them: kousoku.load(scene, kinds=[{kind}])"
        )
    return _OWN[name]


@cache
def load_frozen(name: str) -> Package:
    """Frozen kernels of a kind that is shipped, such as ``n1``, ``p2_z``, or ``p2``.

    A kind of one's own has the name that :func:`keep_own` returned.

    Raises
    ------
    LoadError
        No such kind is shipped or kept, or its file is damaged.
    """
    if is_own(name):
        return _load_own(name)
    kinds = resources.files("kousoku.generated").joinpath("kinds")
    kind, _, choice = name.partition("_")
    if kind in KINDS and name in KINDS[kind].packages and name != kind:
        return chosen(load_frozen(kind), choice)
    try:
        data = kinds.joinpath(name, GRAPH_FILE).read_bytes()
    except OSError as problem:
        known = sorted(
            folder.name
            for folder in (kinds.iterdir() if kinds.is_dir() else ())
            if folder.joinpath(GRAPH_FILE).is_file()
        )
        raise LoadError(
            f"no kind {name} is shipped; there are {', '.join(known) or 'none'};"
            f" make it with: kousoku generate {name}"
        ) from problem
    try:
        return parse(content(GRAPH_FILE, data).decode())
    except ValueError as problem:
        raise LoadError(f"{name}: {problem}; make it again with: kousoku generate {name}") from None


def _kernel_to_data(kernel: Kernel) -> dict[str, object]:
    return {
        "name": kernel.name,
        "title": kernel.title,
        "formula": kernel.formula,
        "source": kernel.source,
        "inputs": [_quantity_to_data(quantity) for quantity in kernel.inputs],
        "outputs": [_quantity_to_data(quantity) for quantity in kernel.outputs],
        "nodes": [_node_to_data(node) for node in kernel.nodes],
        "results": [list(result) for result in kernel.results],
        "names": [list(name) for name in kernel.names],
    }


def _quantity_to_data(quantity: Quantity) -> dict[str, object]:
    return {
        "name": quantity.name,
        "shape": list(quantity.shape),
        "unit": quantity.unit,
        "meaning": quantity.meaning,
    }


def _node_to_data(node: OperationNode[int]) -> str:
    """``=3/2`` for a number, ``p_i[0]`` for an input, ``12*40``, ``-7``, ``atan2 3 5``."""
    if node.op is Op.CONST:
        return f"={node.value}"
    if node.op is Op.INPUT:
        assert node.symbol is not None
        name, index = node.symbol
        return f"{name}[{index}]"
    if node.op in SIGNS:
        return f"{node.args[0]}{SIGNS[node.op]}{node.args[1]}"
    if node.op is Op.NEG:
        return f"-{node.args[0]}"
    return " ".join((node.op.value, *map(str, node.args)))


def _kernel_from_data(data: dict[str, Any]) -> Kernel:
    nodes: list[OperationNode[int]] = []
    for item in data["nodes"]:
        nodes.append(_node_from_data(item, len(nodes)))
    results = tuple(
        tuple(_known_id(node, len(nodes)) for node in result) for result in data["results"]
    )
    outputs = tuple(_quantity_from_data(quantity) for quantity in data["outputs"])
    if [len(result) for result in results] != [quantity.size for quantity in outputs]:
        raise ValueError(f"results of kernel {data['name']} do not fit its outputs")
    return Kernel(
        name=data["name"],
        title=data["title"],
        formula=data["formula"],
        source=data["source"],
        inputs=tuple(_quantity_from_data(quantity) for quantity in data["inputs"]),
        outputs=outputs,
        nodes=tuple(nodes),
        results=results,
        names=tuple((_known_id(node, len(nodes)), name) for node, name in data["names"]),
    )


def _quantity_from_data(data: dict[str, Any]) -> Quantity:
    return Quantity(data["name"], tuple(data["shape"]), data["unit"], data["meaning"])


def _node_from_data(text: str, position: int) -> OperationNode[int]:
    if text.startswith("="):
        return OperationNode(Op.CONST, value=Fraction(text[1:]))
    if match := _INPUT.fullmatch(text):
        return OperationNode(Op.INPUT, symbol=(match[1], int(match[2])))
    if match := _SIGNED.fullmatch(text):
        op = next(op for op, sign in SIGNS.items() if sign == match[2])
        args = [match[1], match[3]]
    elif text.startswith("-"):
        op, args = Op.NEG, [text[1:]]
    else:
        word, *args = text.split(" ")
        op = Op(word)
        if op not in GRAPH_OPS:
            raise ValueError(f"{word} is no operation of a kernel")
    return OperationNode(op, args=tuple(_known_id(int(arg), position) for arg in args))


def _known_id(node: int, count: int) -> int:
    if not 0 <= node < count:
        raise ValueError(f"node {node} is used before it is computed")
    return node
