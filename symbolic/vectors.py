"""The lecture's vectors as objects with operators: how one states a constraint of one's own.

A vector or a number carries both levels along. Each operator is written twice, as a product of
matrices and as sums of elements; the proof compares what is derived from one with what is derived
from the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NoReturn

import sympy
from sympy import S
from sympy.matrices.expressions import Identity, MatAdd, MatMul, MatrixSymbol, Transpose, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.model.validation.names import name_problem
from kousoku.symbolic import bodies
from kousoku.symbolic.components import cross, dot, plus, rotate, rotate_back
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import Constraint
from kousoku.symbolic.matrices import (
    Dot,
    NamedMatrix,
    Skew,
    add,
    coefficient_and_factors,
    elements,
    mul,
    neg,
    skew,
    symbol,
    transpose,
)
from kousoku.symbolic.printing import show
from kousoku.symbolic.sympy_types import as_matrix, as_scalar
from kousoku.symbolic.variation import orthogonality, rewrite

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix

#: The power of length in the units that an own input may have.
POWERS = {"-": 0, "rad": 0, "m": 1}
_SHARED = {q.name: q for q in (*bodies.CONFIGURATION, *bodies.MOTION)}


@dataclass(frozen=True, slots=True, repr=False)
class _Term:
    """A term of vectors or numbers.

    Parameters
    ----------
    matrix : SymbolicMatrix
        Matrix level: (3, 1) of a vector, (1, 1) of a number.
    components : tuple of sympy.Expr
        Component level, found without the matrix level.
    power : int
        Of the unit of length.
    inputs : tuple of Quantity
        Inputs that it depends on, without the orientations and positions of the bodies.
    """

    matrix: SymbolicMatrix
    components: tuple[Scalar, ...]
    power: int
    inputs: tuple[Quantity, ...] = ()

    #: NumPy arrays leave the operators to this class, which refuses them.
    __array_ufunc__ = None

    @property
    def text(self) -> str:
        """The formula on the matrix level, in the lecture's letters."""
        return show(self.matrix)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.text} [{_unit(self.power)}]>"

    def _repr_latex_(self) -> str:
        return f"${show(self.matrix, 'latex')}$"

    def _require_same_unit(self, other: _Term) -> None:
        if self.power != other.power:
            raise DerivationError(
                f"{self.text} is in {_unit(self.power)} and {other.text} in {_unit(other.power)}; "
                "they cannot be added"
            )


@dataclass(frozen=True, slots=True, repr=False)
class Vector(_Term):
    """A vector (3,): ``+``, ``-``, ``*`` and ``/`` with numbers, ``dot``, ``cross``, ``[k]``.

    Both operands are components in the same frame; :attr:`Body.A` changes it, a = A a′. Its unit is
    a power of m.

    Parameters
    ----------
    frame : {"O", "i", "j"}
        The frame of its components.
    parts : mapping of str to tuple of sympy.Expr
        Terms of a vector in frame O: components in the frame of a body before A turns them.
    """

    frame: str = field(default="O")
    parts: Mapping[str, tuple[Scalar, ...]] = field(default_factory=dict, compare=False)

    def dot(self, other: Vector) -> Number:
        """Scalar product uᵀv, in the product of the units."""
        self._require_same_frame(other, f"{self.text} is multiplied by")
        return Number(
            mul(transpose(self.matrix), other.matrix),
            (self._product(other),),
            self.power + other.power,
            _joined(self, other),
            Dot(self.matrix, other.matrix),
        )

    def _product(self, other: Vector) -> Scalar:
        """Scalar product by elements; vectors that A has turned on both sides stay as they are."""
        total = S.Zero
        for name in self.parts.keys() & other.parts.keys() - {self.frame}:
            total += _square(name) ** 2 * dot(self.parts[name], other.parts[name])
        if total == 0:
            return dot(self.components, other.components)
        for frame_u, u in self._turned().items():
            for frame_v, v in other._turned().items():
                if frame_u != frame_v or frame_u == self.frame:
                    total += dot(u, v)
        return as_scalar(total)

    def _turned(self) -> dict[str, Sequence[Scalar]]:
        """Terms, each in the frame of the sum."""
        return {
            name: x if name == self.frame else rotate(bodies.COMPONENTS[f"p_{name}"], x)
            for name, x in self.parts.items()
        }

    def _with(self, parts: Mapping[str, Sequence[Scalar]], **changes: Any) -> Vector:
        """Vector of these terms."""
        new = replace(self, parts={k: tuple(x) for k, x in parts.items()}, **changes)
        return replace(new, components=tuple(_sum(new._turned().values())))

    def cross(self, other: Vector) -> Vector:
        """Vector product, self × other."""
        self._require_same_frame(other, f"{self.text} is multiplied by")
        product = cross(self.components, other.components)
        return self._with(
            {self.frame: product},
            matrix=mul(skew(self.matrix), other.matrix),
            power=self.power + other.power,
            inputs=_joined(self, other),
        )

    def named(self, name: str) -> Vector:
        """Vector of the same value under a name of its own, such as d, by which steps call it."""
        _require_name(name)
        return replace(self, matrix=NamedMatrix(name, self.matrix))

    def __getitem__(self, index: int) -> Number:
        if index not in (0, 1, 2):
            raise IndexError(f"{self.text} has the components 0, 1 and 2; there is no {index!r}")
        unit = ImmutableDenseMatrix([int(k == index) for k in range(3)])
        return Number(
            mul(unit.T, self.matrix),
            (self.components[index],),
            self.power,
            self.inputs,
            Dot(unit, self.matrix),
        )

    def __add__(self, other: Vector) -> Vector:
        self._require_same_frame(other, f"to {self.text} is added")
        self._require_same_unit(other)
        mine, others = self.parts, other.parts
        both = {k: plus(mine[k], others[k]) for k in mine if k in others}
        return self._with(
            {**mine, **others, **both},
            matrix=add(self.matrix, other.matrix),
            inputs=_joined(self, other),
        )

    def __neg__(self) -> Vector:
        parts = {k: [-x for x in part] for k, part in self.parts.items()}
        return self._with(parts, matrix=neg(self.matrix))

    def __sub__(self, other: Vector) -> Vector:
        _require(other, Vector, f"from {self.text} is subtracted")
        return self + (-other)

    def __mul__(self, other: Number | int | Fraction) -> Vector:
        factor = number_of(other, f"{self.text} is multiplied by")
        (size,) = factor.components
        return self._with(
            {k: [size * x for x in part] for k, part in self.parts.items()},
            matrix=mul(factor.scalar, self.matrix),
            power=self.power + factor.power,
            inputs=_joined(self, factor),
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Number | int | Fraction) -> Vector:
        return self * _inverse(self, other)

    def _require_same_frame(self, other: Vector, where: str) -> None:
        _require(other, Vector, where)
        if self.frame != other.frame:
            raise DerivationError(
                f"{where} {other.text}: components in frame {self.frame} and in frame "
                f"{other.frame}; A takes components of a body to frame O, A.T takes them back"
            )


@dataclass(frozen=True, slots=True, repr=False)
class Number(_Term):
    """A number that varies with the motion, or a constant: ``+``, ``-``, ``*``, powers.

    It can be divided by constants. Its unit is a power of m; it is uᵀv of vectors in one frame.

    Parameters
    ----------
    scalar : sympy.Expr
        Matrix level, as a scalar factor.
    """

    scalar: Scalar = field(default=S.Zero)

    @property
    def is_constant(self) -> bool:
        """Whether it does not depend on the positions of the bodies."""
        return not self.scalar.has(Dot)

    def __add__(self, other: Number | int | Fraction) -> Number:
        other = number_of(other, f"to {self.text} is added")
        self._require_same_unit(other)
        return Number(
            add(self.matrix, other.matrix),
            (self.components[0] + other.components[0],),
            self.power,
            _joined(self, other),
            self.scalar + other.scalar,
        )

    __radd__ = __add__

    def __neg__(self) -> Number:
        x = self.components[0]
        return replace(self, matrix=neg(self.matrix), components=(-x,), scalar=-self.scalar)

    def __sub__(self, other: Number | int | Fraction) -> Number:
        return self + (-number_of(other, f"from {self.text} is subtracted"))

    def __rsub__(self, other: Number | int | Fraction) -> Number:
        return (-self) + other

    def __mul__(self, other: Number | Vector | int | Fraction) -> Any:
        if isinstance(other, Vector):
            return other * self
        other = number_of(other, f"{self.text} is multiplied by")
        first, last = (other, self) if other.is_constant else (self, other)
        return Number(
            mul(first.scalar, last.matrix),
            (self.components[0] * other.components[0],),
            self.power + other.power,
            _joined(self, other),
            self.scalar * other.scalar,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Number | int | Fraction) -> Number:
        quotient: Number = self * _inverse(self, other)
        return quotient

    def __rtruediv__(self, other: int | Fraction) -> Number:
        return number_of(other, f"by {self.text} is divided") / self

    def __pow__(self, exponent: int) -> Number:
        if not isinstance(exponent, int) or isinstance(exponent, bool) or exponent < 1:
            raise DerivationError(
                f"the power {exponent!r} of {self.text}: wanted a positive integer; a root of what "
                "varies is stated as docs/own_kind.md says"
            )
        product = self
        for _ in range(exponent - 1):
            product = product * self
        return product


@dataclass(frozen=True, slots=True)
class Rotation:
    """The orientation A (3, 3) [-] of a body, or its transpose: ``A @ v``, ``A.T @ v``.

    a = A a′ of body components a′ is in frame O; lecture 7.1, (orthogonality): A Aᵀ = I.

    Parameters
    ----------
    name : str
        The body.
    is_back : bool
        Whether it takes components in frame O to the body frame.
    """

    name: str
    is_back: bool = False

    @property
    def T(self) -> Rotation:
        """The transpose; A Aᵀ = I for Euler parameters of norm one."""
        return replace(self, is_back=not self.is_back)

    def __matmul__(self, v: Vector) -> Vector:
        _require(v, Vector, f"the orientation of body {self.name} is applied to")
        before, after = ("O", self.name) if self.is_back else (self.name, "O")
        if v.frame != before:
            raise DerivationError(
                f"A{'.T' * self.is_back} of body {self.name} takes components in frame {before}; "
                f"those of {v.text} are in frame {v.frame}"
            )
        matrix = bodies.A[self.name]
        if not self.is_back:
            parts = {self.name: v.components}
            return v._with(parts, frame=after, matrix=mul(matrix, v.matrix))
        # AᵀA = (p·p)² I for p of any norm: a term that A turned comes back with this factor.
        turned = [x for k, x in v._turned().items() if k != self.name]
        back = rotate_back(bodies.COMPONENTS[f"p_{self.name}"], _sum(turned))
        unturned = [_square(self.name) ** 2 * x for x in v.parts.get(self.name, (S.Zero,) * 3)]
        product = mul(transpose(matrix), v.matrix)
        return v._with({after: plus(back, unturned)}, frame=after, matrix=product)


@dataclass(frozen=True, slots=True)
class Body:
    """Body i or j of a constraint, and the lecture's vectors of it, (3,), with frame and unit.

    A prime marks components in the body frame: a = A a′ in frame O, lecture 8.2,
    (known-components).

    Parameters
    ----------
    name : {"i", "j"}
        Which of the two.
    """

    name: str

    @property
    def r(self) -> Vector:
        """Position r (3,) [m] of the origin of the body frame, frame O; lecture 7.1, (4.28)."""
        return _vector(_SHARED[f"r_{self.name}"], "O")

    @property
    def A(self) -> Rotation:
        """Orientation A (3, 3) [-], components in the body frame to frame O; lecture 7.1, (4.3)."""
        return Rotation(self.name)

    @property
    def a_b(self) -> Vector:
        """An axis a′ (3,) [-] fixed in the body, body frame; lecture 8.2, (8.9)."""
        return self.fixed("a", "-")

    @property
    def s_b(self) -> Vector:
        """A point s′ (3,) [m] from the origin, fixed in the body, its frame; lecture 8.2, (8.8)."""
        return self.fixed("s", "m")

    def fixed(self, name: str, unit: str, meaning: str = "") -> Vector:
        """Components (3,) in the body frame of a vector that is fixed in the body, a′ or s′.

        Parameters
        ----------
        name : str
            The input is called so, with the body: ``b`` of body i is ``b_i_b``.
        unit : {"m", "-"}
            Of a point [m], or of a direction.
        meaning : str
            What it is, in a few words, for the generated files.
        """
        _require_name(name)
        text = meaning or f"{'point' if unit == 'm' else 'axis'} fixed in body {self.name}"
        frame = f"frame of {self.name}"
        quantity = _input(f"{name}_{self.name}_b", (3,), unit, f"{text}, {frame}")
        return _vector(quantity, self.name)

    def axis(self, name: str = "a") -> Vector:
        """Axis a = A a′ (3,) [-], fixed in the body, in frame O; lecture 8.2, (a-i-turned)."""
        return (self.A @ self.fixed(name, "-")).named(f"{name}_{self.name}")

    def point(self, name: str = "s") -> Vector:
        """Point r + A s′ (3,) [m], fixed in the body, in frame O; lecture 7.1, (4.28)."""
        return self.r + self.A @ self.fixed(name, "m")

    if not TYPE_CHECKING:  # type checkers know the members themselves

        def __getattr__(self, name: str) -> NoReturn:
            if name.startswith("_") or name == "name":
                raise AttributeError(name)
            raise AttributeError(
                f"body {self.name} has no {name}: there are r, A, a_b, s_b, axis(name), point(name)"
                " and fixed(name, unit); C is of positions, ω′ and δθ′ follow when it is derived"
            )


def body(name: str) -> Body:
    """Body i or j, of whose vectors a constraint is an expression.

    Raises
    ------
    DerivationError
        A constraint is between bodies i and j only.
    """
    if name not in bodies.BODIES:
        raise DerivationError(f"no body {name!r}: a constraint is between bodies 'i' and 'j'")
    return Body(name)


def number(name: str, unit: str = "-", meaning: str = "") -> Number:
    """Given number, constant in time: an input of the constraint by this name.

    Parameters
    ----------
    name : str
        A lower-case identifier.
    unit : {"-", "rad", "m"}
        Its unit.
    meaning : str
        What it is, in a few words, for the generated files.
    """
    _require_name(name)
    quantity = _input(name, (), unit, meaning or f"given {name}")
    return _constant(symbol(quantity), elements(quantity)[0], POWERS[unit], (quantity,))


def number_of(x: Any, where: str) -> Number:
    """Number of the formula; an exact one of Python or SymPy is taken as it is.

    Raises
    ------
    DerivationError
        It is something else; a float, of which nobody knows which fraction is meant.
    """
    if isinstance(x, Number):
        return x
    is_exact = isinstance(x, int | Fraction | sympy.Rational) and not isinstance(x, bool)
    if not is_exact:
        shown = x.text if isinstance(x, _Term) else repr(x)
        raise DerivationError(
            f"{where} {shown}, of type {type(x).__name__}; wanted a number: an integer, "
            "a Fraction such as Fraction(1, 3), or one that number() gives a name"
        )
    value = sympy.Rational(x.numerator, x.denominator)
    return _constant(value, value, 0, ())


def constraint_of(name: str, C: Any, *, title: str, source: str) -> Constraint:
    """Constraint C = 0 (m,) that an expression states, or several, one below the other.

    Vectors in one of them are in one frame, frame O or that of a body.

    Parameters
    ----------
    name : str
        The package that is emitted.
    C : Number, Vector, or a sequence of them
        In metres, or without unit.
    title, source : str
        For the generated files: what it is in one line, and where it stands.

    Raises
    ------
    DerivationError
        C is no such expression, or in another unit.
    """
    parts = tuple(C) if isinstance(C, tuple | list) else (C,)
    for part in parts:
        _require(part, _Term, f"{name}: C holds")
        if isinstance(part, Vector) and part.matrix.has(Dot):
            raise DerivationError(
                f"{name}: C holds the vector {part.text} with a factor that varies; wanted "
                "numbers, such as its products with axes"
            )
    powers = {part.power for part in parts}
    if len(powers) != 1 or not powers <= set(POWERS.values()):
        got = ", ".join(f"{part.text} in {_unit(part.power)}" for part in parts) or "nothing"
        raise DerivationError(
            f"{name}: C holds {got}; wanted a length in m or a number without unit, all parts the "
            "same: divide by a given length, as the kind distance does"
        )
    stated = _column_of(parts)
    opened = rewrite(stated, _opened)
    # What is constant by this rule, such as a point of i seen from i, would vary and cancel if it
    # were left, and with it digits.
    value = rewrite(opened, resolve)
    left = MatrixSymbol("C", *value.shape)
    steps = [Step(left, stated, "the constraint as it is stated", "")]
    if opened != stated:
        steps.append(Step(left, opened, "each name resolved", ""))
    if value != opened:
        rule = "AᵀA = (p·p)² I, for Euler parameters of any norm"
        steps.append(Step(left, value, rule, "4.3"))
    return Constraint(
        name=name,
        kind=name,
        title=f"{name}, {title}" if title else name,
        source=source or "an own constraint",
        formula=f"C = {show(stated)}",
        unit=_unit(parts[0].power),
        steps=tuple(steps),
        value=value,
        components=tuple(x for part in parts for x in part.components),
        inputs=tuple(q for q in _joined(*parts) if q.name not in _SHARED),
        rule=resolve,
    )


def _opened(x: SymbolicMatrix) -> SymbolicMatrix | None:
    """Value that a name stands for."""
    if isinstance(x, Transpose) and isinstance(x.arg, NamedMatrix):
        return transpose(x.arg.value)
    return x.value if isinstance(x, NamedMatrix) else None


def resolve(x: SymbolicMatrix) -> SymbolicMatrix | None:
    """Apply AᵀA = (p·p)² I and sᵀs̃ = 0 where they stand in x, also to single terms of a sum."""
    if not isinstance(x, MatMul):
        return None
    scalar, factors = coefficient_and_factors(x)
    for k in range(len(factors) - 1):
        left, right = factors[k : k + 2]
        skews = [(u.v, v) for u, v in ((left, right), (right, left)) if isinstance(u, Skew)]
        if any(v in {u, transpose(u)} for u, v in skews):
            return as_matrix(ZeroMatrix(*x.shape))
        if isinstance(left, MatAdd) == isinstance(right, MatAdd):
            continue
        terms = (left if isinstance(left, MatAdd) else right).args
        plain: list[SymbolicMatrix] = []
        reduced: list[SymbolicMatrix] = []
        for term in terms:
            product = mul(term, right) if isinstance(left, MatAdd) else mul(left, term)
            resolved = orthogonality(product)
            (plain if resolved is None else reduced).append(term if resolved is None else resolved)
        if reduced:
            if plain:
                rest = add(*plain)
                reduced.insert(0, mul(rest, right) if isinstance(left, MatAdd) else mul(left, rest))
            around = factors[:k], factors[k + 2 :]
            return add(*(mul(scalar, *around[0], product, *around[1]) for product in reduced))
    return orthogonality(x)


def _column_of(parts: Sequence[_Term]) -> SymbolicMatrix:
    """Parts one below the other, as a sum: part k times a selection of rows."""
    if len(parts) == 1:
        return parts[0].matrix
    rows = [(k, n) for k, part in enumerate(parts) for n in range(len(part.components))]
    placed = []
    for k, part in enumerate(parts):
        selection = [[int(row == (k, n)) for n in range(len(part.components))] for row in rows]
        placed.append(mul(ImmutableDenseMatrix(selection), part.matrix))
    return add(*placed)


def _constant(scalar: Any, component: Any, power: int, inputs: tuple[Quantity, ...]) -> Number:
    return Number(mul(scalar, Identity(1)), (component,), power, inputs, scalar)


def _vector(quantity: Quantity, frame: str) -> Vector:
    x = elements(quantity)
    return Vector(symbol(quantity), x, POWERS[quantity.unit], (quantity,), frame, {frame: x})


def _sum(vectors: Iterable[Sequence[Scalar]]) -> list[Scalar]:
    return [sum(cells, S.Zero) for cells in zip(*vectors, strict=True)] or [S.Zero] * 3


def _square(body: str) -> Scalar:
    """Square p·p of a body."""
    return as_scalar(sum(e**2 for e in bodies.COMPONENTS[f"p_{body}"]))


def _input(name: str, shape: tuple[int, ...], unit: str, meaning: str) -> Quantity:
    """Input by a name; those of every constraint, such as a′ of body i, are shared."""
    if unit not in POWERS:
        raise DerivationError(f"{name}: unit {unit!r}; wanted one of {', '.join(POWERS)}")
    shared = _SHARED.get(name)
    if shared is None:
        return Quantity(name, shape, unit, meaning)
    if (shared.shape, shared.unit) != (shape, unit):
        raise DerivationError(
            f"{name} is {shared.meaning}, of shape {shared.shape} in {shared.unit}; choose another "
            "name"
        )
    return shared


def _joined(*terms: _Term) -> tuple[Quantity, ...]:
    inputs: dict[str, Quantity] = {}
    for quantity in (quantity for term in terms for quantity in term.inputs):
        known = inputs.setdefault(quantity.name, quantity)
        if known != quantity:
            raise DerivationError(
                f"{quantity.name} is there twice, as {known.meaning} [{known.unit}] and as "
                f"{quantity.meaning} [{quantity.unit}]; give each its own name"
            )
    return tuple(inputs.values())


def _inverse(term: _Term, other: Any) -> Number:
    """Reciprocal of a constant.

    Raises
    ------
    DerivationError
        It varies, or is zero.
    """
    divisor = number_of(other, f"{term.text} is divided by")
    if not divisor.is_constant or divisor.scalar == 0:
        raise DerivationError(
            f"{term.text} is divided by {divisor.text}; wanted a constant that is not zero. "
            "A quotient by what varies is stated as docs/own_kind.md says"
        )
    return _constant(1 / divisor.scalar, 1 / divisor.components[0], -divisor.power, divisor.inputs)


def _require(x: Any, wanted: type, where: str) -> None:
    if not isinstance(x, wanted):
        noun = "vector" if wanted is Vector else "vector or number"
        shown = x.text if isinstance(x, _Term) else repr(x)
        raise DerivationError(
            f"{where} {shown}, of type {type(x).__name__}; wanted a {noun}, made of those of "
            "body('i'), body('j') and number(...)"
        )


def _require_name(name: str) -> None:
    problem = name_problem(name) if isinstance(name, str) else f"{name!r} is no text"
    if problem is not None:
        raise DerivationError(problem)


def _unit(power: int) -> str:
    return {0: "-", 1: "m"}.get(power, f"m^{power}")
