"""Checks of a derivation before it is proved and emitted, each mistake in one message."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sympy import Symbol
from sympy.matrices.expressions import MatrixSymbol

from kousoku.model.errors import DerivationError
from kousoku.model.validation.names import name_problem
from kousoku.symbolic.kinds import KINDS, packages_of
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function
    from kousoku.symbolic.forms import Constraint


def check_constraint(c: Constraint, taken: Sequence[str]) -> None:
    """Check the size of a constraint, and that none of its own inputs has a ``taken`` name.

    Raises
    ------
    DerivationError
        Names the constraint, what was got and what was wanted.
    """
    for name, wanted in (("components", "expressions"), ("inputs", "quantities")):
        got = getattr(c, name)
        if not isinstance(got, (tuple, list)):
            raise DerivationError(
                f"{c.name}: {name} is of type {type(got).__name__}, wanted a tuple of {wanted}; "
                f"of one, write ({name[:-1]},)"
            )
    rows = len(c.components)
    shape = tuple(getattr(c.value, "shape", ()))
    if shape != (rows, 1) or not rows:
        raise DerivationError(
            f"{c.name}: the value has shape {shape} and there are {rows} components; "
            "wanted a column, and one component for each of its rows"
        )
    for quantity in c.inputs:
        if quantity.name in taken:
            raise DerivationError(
                f"{c.name}: the input {quantity.name} is there already, with a meaning of its own "
                f"({', '.join(taken)}); choose another name"
            )


def check_functions(derivation: Derivation) -> None:
    """Check that each function holds only the symbols that it declares, in their sizes.

    Raises
    ------
    DerivationError
        Names the function, the output and the symbol.
    """
    for function in derivation.functions:
        where = f"{derivation.name}.{function.name}"
        if not function.inputs or not function.outputs:
            raise DerivationError(f"{where} has no inputs or no outputs; wanted one of each")
        for output in function.outputs:
            _check_size(where, output)
            _check_symbols(where, function, output)


def check_names(derivation: Derivation) -> None:
    """Check that all names can be emitted, and that none is taken.

    Raises
    ------
    DerivationError
        A name is no identifier, is a word of C or Python, stands for two things, or is the name of
        a kind that kousoku ships.
    """
    require_own_name(derivation.name)
    _check_each("a kernel", derivation.name, [function.name for function in derivation.functions])
    for function in derivation.functions:
        quantities = (*function.inputs, *(output.quantity for output in function.outputs))
        where = f"{derivation.name}.{function.name}"
        _check_each("an input or output", where, [quantity.name for quantity in quantities])


def require_own_name(name: str) -> None:
    """Refuse a name of a kind that cannot be emitted, or that is one of a kind kousoku ships."""
    if not isinstance(name, str):
        raise DerivationError(f"name of a kind: {name!r} is no text")
    try:
        shipped = packages_of(name)
    except DerivationError:
        shipped = ()
    if shipped:
        raise DerivationError(
            f"{name!r} is taken by a kind that kousoku ships (they are "
            f"{', '.join(KINDS)}, and their other names); choose another name for yours"
        )
    _check_each("a kind", name, (name,))


def _check_each(role: str, where: str, names: Sequence[str]) -> None:
    for index, name in enumerate(names):
        problem = name_problem(name)
        if name in names[:index]:
            problem = f"{name!r} is there twice; give each its own name"
        if problem is not None:
            raise DerivationError(f"{where}: name of {role}: {problem}")


def _check_size(where: str, output: DerivedOutput) -> None:
    quantity, x = output.quantity, output.expression
    matrix = int(x.shape[0] * x.shape[1]) if getattr(x, "is_Matrix", False) else 1
    if not matrix == len(output.components) == quantity.size:
        raise DerivationError(
            f"{where}: {quantity.name} has shape {quantity.shape}, {quantity.size} numbers, but the"
            f" matrix level gives {matrix} and the component level {len(output.components)}"
        )


def _check_symbols(where: str, function: Function, output: DerivedOutput) -> None:
    declared = ", ".join(quantity.name for quantity in function.inputs)
    shapes = {q.name: (*q.shape, 1)[:2] if q.shape else () for q in function.inputs}
    for x in sorted(output.expression.atoms(Symbol, MatrixSymbol), key=str):
        name = x.name
        if shapes.get(name) != tuple(getattr(x, "shape", ())):
            raise DerivationError(
                f"{where}: the matrix level of {output.quantity.name} holds {name}, which is not "
                f"among the inputs ({declared}) in that shape; declare it as a Quantity"
            )
    known = {s for quantity in function.inputs for s in elements(quantity)}
    for name in sorted(str(s) for s in output.components.free_symbols - known):
        raise DerivationError(
            f"{where}: the components of {output.quantity.name} hold {name}, which is not an "
            f"element of the inputs ({declared}) of the matrix level; correct one of the two"
        )
