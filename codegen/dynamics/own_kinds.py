"""Constraint of a user as a type of joints: its inputs and rows, for a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from kousoku.codegen.dynamics.operations.own_frames import COLUMNS, PLACES, RATES, own_inputs
from kousoku.codegen.kernel_json import keep_own
from kousoku.codegen.passes.rebuild import substitute
from kousoku.model.elements.joints import NAMES
from kousoku.model.errors import DerivationError
from kousoku.model.operations.graph import Graph
from kousoku.model.records.own_kind import KEYS, OwnInput, OwnKind

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Literal

    from kousoku.model.files.quantity import Quantity
    from kousoku.model.operations.kernel import Kernel, Package

#: Outputs of the kernels that a joint is made of, by kernel.
OUTPUTS = {"constraint": ("C", "C_q"), "rates": ("nu", "gamma")}
STATE = {name.format(body): (n,) for name, n, _ in (*PLACES, *RATES) for body in "ij"}


def own_kind_of(package: Package) -> OwnKind:
    """Kind of one's own, as a type of joints; its kernels are kept.

    Parameters
    ----------
    package : Package
        Frozen kernels, as :func:`kousoku.codegen.derived.freeze_derivation` gives them.

    Raises
    ------
    DerivationError
        The package is no constraint between two bodies; the message says why.
    """
    if problem := next(_problems(package), ""):
        raise DerivationError(
            f"{package.name} cannot be the type of a joint: {problem}; wanted what"
            " kousoku.derive(name, C=...) gives, a constraint C = 0 between bodies i and j"
        )
    constraint = _kernel(package, "constraint")
    assert constraint is not None
    return OwnKind(
        kernels=keep_own(package),
        unit="m" if constraint.outputs[0].unit == "m" else "rad",
        turns=(_needs_orientation(constraint, 0), _needs_orientation(constraint, 1)),
        inputs={quantity.name: _input(quantity) for quantity in own_inputs(package)},
    )


def _problems(package: Package) -> Iterator[str]:
    """Reasons why a package is no constraint between two bodies."""
    if package.name in NAMES:
        yield f"{package.name!r} is a type of joints that kousoku has"
    for name, outputs in OUTPUTS.items():
        kernel = _kernel(package, name)
        shapes = {} if kernel is None else {output.name: output.shape for output in kernel.outputs}
        if not shapes.keys() >= {*outputs}:
            yield f"it has no kernel {name} that gives {' and '.join(outputs)}"
            return
        rows = shapes[outputs[0]]
        if len(rows) != 1 or not 1 <= rows[0] <= COLUMNS:
            yield f"{outputs[0]} has shape {rows}, and a joint has 1 to {COLUMNS} rows"
        if name == "constraint" and shapes["C_q"] != (*rows, 2 * COLUMNS):
            yield f"C_q has shape {shapes['C_q']} for C of shape {rows}"
        for quantity in () if kernel is None else kernel.inputs:
            if STATE.get(quantity.name, quantity.shape) != quantity.shape:
                yield f"{quantity.name} has shape {quantity.shape}"
    for quantity in own_inputs(package):
        name, shape, unit = quantity.name, quantity.shape, quantity.unit
        if name in KEYS:
            yield f"its input is called {name!r}, as a key of joints is"
        if shape not in {(), (3,)}:
            yield f"its input {name} has shape {shape}, which is no number and no vector"
        if unit not in {"-", "rad", "m"}:
            yield f"its input {name} is in {unit}, not in m, rad or without unit"


def _kernel(package: Package, name: str) -> Kernel | None:
    return next((kernel for kernel in package.kernels if kernel.name == name), None)


def _input(quantity: Quantity) -> OwnInput:
    unit = cast("Literal['-', 'rad', 'm']", quantity.unit)  # as was checked
    return OwnInput(
        unit=unit, vector=quantity.shape == (3,), body=_body_of(quantity), meaning=quantity.meaning
    )


def _body_of(quantity: Quantity) -> Literal["", "i", "j"]:
    """Body that a vector is fixed in, by its name."""
    if quantity.shape != (3,):
        return ""
    return "i" if quantity.name.endswith("_i_b") else "j" if quantity.name.endswith("_j_b") else ""


def _needs_orientation(constraint: Kernel, side: int) -> bool:
    """Whether turns of a body change C where its points are the origin of its frame."""
    graph, body = Graph(), "ij"[side]
    inputs = {
        quantity.name: [
            graph.const(0)
            if quantity.unit == "m" and _body_of(quantity) == body
            else graph.input(quantity.name, k)
            for k in range(quantity.size)
        ]
        for quantity in constraint.inputs
    }
    jacobian = substitute(graph, constraint, inputs)["C_q"]
    first = side * COLUMNS + 3
    return any(
        graph.value(jacobian[row + k]) != 0
        for row in range(0, len(jacobian), 2 * COLUMNS)
        for k in range(first, first + 3)
    )
