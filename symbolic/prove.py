"""The prover: the two levels of an output agree, and the lines of a derivation follow.

Both sides are carried into one ring of polynomials (:mod:`kousoku.symbolic.ring`).
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import sympy
from sympy.matrices.expressions import MatrixSymbol
from sympy.polys.domains import QQ

from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import Flow, half_turn
from kousoku.symbolic.matrices import (
    Divisor,
    NamedMatrix,
    NamedScalar,
    OrientationMatrix,
    elements,
    quadratic_form,
)
from kousoku.symbolic.named_ring import NamedRing, polynomial_names, shared
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function


def prove(function: Function) -> int:
    """Prove that both levels of every output agree, for all values of the inputs.

    Parameters
    ----------
    function : Function
        Its matrix level against its component level.

    Returns
    -------
    int
        How many elements were proved equal.

    Raises
    ------
    DerivationError
        Names the first element that differs.
    """
    point_ring = Ring(function.inputs, at=rational_point(function.inputs))
    ring = Ring(function.inputs)
    for output in function.outputs:
        # At one rational point first: a mistake is then found at once, however much is to prove.
        _compare(function, output, point_ring, output.expression)
        forms = (output.expression, *output.through)
        for form, following in itertools.pairwise(forms):
            renamed = _with_names_of(form, following)
            if renamed != following and not _agree((renamed, following), is_unit=False):
                raise DerivationError(
                    f"{function.name}: two forms of {output.quantity.name} differ; correct one"
                )
        carrier = ring
        if output.through:
            names = polynomial_names(ring, forms[-1])
            carrier = NamedRing(function.inputs, names, plain=ring)
        _compare(function, output, carrier, forms[-1])
    return sum(output.quantity.size for output in function.outputs)


def _compare(function: Function, output: DerivedOutput, carrier: Ring, expression: Any) -> None:
    cells = carrier.cells(expression)
    for k, (cell, component) in enumerate(zip(cells, output.components, strict=True)):
        if not carrier.is_equal(cell, carrier.scalar(component)):
            raise DerivationError(
                f"{function.name}: the two levels differ in {output.quantity.name}, element {k} "
                f"of {output.quantity.size}; correct the derivation of one of them"
            )


def prove_steps(derivation: Derivation) -> int:
    """Prove that the lines of a derivation follow from each other.

    Two lines with the same left-hand side must have equal right-hand sides; where the left-hand
    side is itself a formula, it must equal the right. δA is that of the component level. An
    identity that fails for Euler parameters of any norm must hold for those of norm one.

    Parameters
    ----------
    derivation : Derivation
        Its steps. Those on assembled systems, whose sizes are letters, are left out.

    Returns
    -------
    int
        How many equalities were proved.

    Raises
    ------
    DerivationError
        Names the first step that does not follow.
    """
    before: dict[Any, Any] = {}
    equal_names: dict[Any, Any] = {}  # names of one quantity, written out in two ways
    count = 0
    for number, step in enumerate(derivation.steps, 1):
        left = step.left
        if any(s.is_integer for s in left.atoms(sympy.Symbol) | step.right.atoms(sympy.Symbol)):
            continue  # the letter is a size
        if isinstance(left, MatrixSymbol | sympy.Symbol | NamedScalar):
            left, before[step.left] = before.get(step.left), step.right
        if left is None:
            continue
        renamed = tuple(_with_one_name(x, equal_names) for x in (left, step.right))
        forms = dict.fromkeys([renamed, (left, step.right)])
        if not any(_agree(*forms, is_unit=is_unit) for is_unit in (False, True)):
            raise DerivationError(
                f"{derivation.name}: step {number} does not follow: {step.rule}; correct it"
            )
        if isinstance(step.left, MatrixSymbol):
            equal_names[NamedMatrix(step.left.name, left)] = NamedMatrix(step.left.name, step.right)
        count += 1
    return count


def _with_one_name(x: Any, equal_names: Mapping[Any, Any]) -> Any:
    """``x`` with names by the last of the values that were proved equal."""
    for old, new in equal_names.items():
        x = x.xreplace({old: new})
    return x


def _with_names_of(form: Any, other: Any) -> Any:
    """``form`` with the values that its names have in ``other``, where these are equal."""
    while True:
        values = {x.name: x for x in other.atoms(NamedMatrix)}
        differing = (x for x in form.atoms(NamedMatrix) if values.get(x.name, x) != x)
        name = min(differing, key=lambda x: (len(str(x)), str(x)), default=None)
        if name is None or not _agree((name.value, values[name.name].value), is_unit=False):
            return form
        form = form.xreplace({name: values[name.name]})


def _agree(*forms: tuple[Any, Any], is_unit: bool) -> bool:
    """Whether two formulas are equal for all values of their symbols.

    Given more than once they differ in names that were proved equal.
    """
    left, right = forms[0]
    symbols = sorted(
        left.atoms(MatrixSymbol, sympy.Symbol) | right.atoms(MatrixSymbol, sympy.Symbol), key=str
    )
    quantities = []
    variations: dict[str, Any] = {}
    for s in symbols:
        shape = tuple(int(n) for n in s.shape) if isinstance(s, MatrixSymbol) else ()
        if s.name.startswith("δA"):
            variations[s.name] = s.name.removeprefix("δA")
        else:
            quantities.append(Quantity(s.name, shape, "", ""))
    known = {q.name for q in quantities}
    for body in variations.values():
        for name, shape in ((f"p{body}", (4, 1)), (_virtual_rotation(body, known), (3, 1))):
            if name not in known:
                quantities.append(Quantity(name, shape, "", ""))
                known.add(name)
    varied = {
        name: _varied_orientation(f"p{body}", _virtual_rotation(body, known), is_unit=is_unit)
        for name, body in variations.items()
    }
    point = rational_point(quantities, is_unit=is_unit)  # a counterexample is found sooner
    if not _is_same(Ring(quantities, varied, is_unit=is_unit, at=point), left, right):
        return False
    sorts_of_names = (
        (NamedMatrix, Divisor, OrientationMatrix),
        (NamedMatrix, NamedScalar, OrientationMatrix),
        (NamedMatrix, OrientationMatrix),
        (NamedScalar,),
    )
    if any(a == b for a, b in forms):
        return True
    ordered = sorted(forms, key=lambda form: -len(shared(*form, NamedMatrix)))
    for (a, b), sorts in itertools.product(ordered, sorts_of_names):
        names = shared(a, b, *sorts)
        carrier = NamedRing(quantities, names, matrices=varied, is_unit=is_unit)
        if names and _is_same(carrier, a, b):
            return True
    return _is_same(Ring(quantities, varied, is_unit=is_unit), left, right)


def _is_same(carrier: Ring, left: Any, right: Any) -> bool:
    pairs = zip(carrier.cells(left), carrier.cells(right), strict=True)
    return all(carrier.is_equal(a, b) for a, b in pairs)


def rational_point(quantities: Sequence[Quantity], *, is_unit: bool = False) -> list[Any]:
    """Rational numbers of all elements, none special; Euler parameters of norm one if asked for."""
    unit = ([QQ(2, 9), QQ(4, 9), QQ(5, 9), QQ(6, 9)], [QQ(1, 11), QQ(2, 11), QQ(4, 11), QQ(10, 11)])
    values: list[Any] = []
    for k, quantity in enumerate(quantities):
        if is_unit and quantity.name.startswith("p") and quantity.size == 4:
            values.extend(unit[k % 2])
        else:
            start = len(values)
            values.extend(QQ(2 * n + 3, n + 2) for n in range(start, start + quantity.size))
    return values


def _virtual_rotation(body: str, known: set[str]) -> str:
    """Name of δθ′ of a body: an input of the rotation, or a column of a constraint."""
    return "dtheta_b" if not body or "dtheta_b" in known else f"δθ{body}_b"


def _varied_orientation(p_name: str, theta_name: str, *, is_unit: bool) -> list[Any]:
    """Variation δA by differentiating A(p) along ½ p∘(0, δθ′)."""
    p = elements(Quantity(p_name, (4,), "", ""))
    theta = elements(Quantity(theta_name, (3,), "", ""))
    flow = Flow(dict(zip(p, half_turn(p, theta), strict=True)), (*p, *theta))
    square = sum((e**2 for e in p), sympy.S.Zero) if is_unit else sympy.S.One
    return [flow(cell) / square for row in quadratic_form(p) for cell in row]
