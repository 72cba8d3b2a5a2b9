"""Types of SymPy's classes, as far as they are used: SymPy itself is untyped.

mypy takes whatever comes from SymPy as it is. What is handed on has one of these types, so that a
matrix is not taken for a number, and a misspelt word is found.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


class SymbolicExpression(Protocol):
    """A tree of SymPy's nodes, which can be compared and hashed."""

    @property
    def args(self) -> tuple[Any, ...]:
        """The parts of the node."""

    @property
    def func(self) -> Any:
        """The class that makes the node of its parts."""

    @property
    def free_symbols(self) -> set[Any]:
        """The symbols in it."""

    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

    def atoms(self, *types: Any) -> set[Any]:
        """Parts of some types, anywhere in the tree."""

    def has(self, *parts: Any) -> bool:
        """Whether some part is in it, or one of a type."""

    def diff(self, *symbols: Any) -> Any:
        """The derivative by symbols."""

    def subs(self, *pairs: Any) -> Any:
        """The expression with some replaced by others, and evaluated."""

    def xreplace(self, rule: Any) -> Any:
        """The expression with some nodes replaced by others."""


class Scalar(SymbolicExpression, Protocol):
    """A number: a SymPy expression."""

    is_Add: bool
    is_Mul: bool
    is_Pow: bool
    is_Rational: bool

    @property
    def base(self) -> Any:
        """Base of a power."""

    @property
    def exp(self) -> Any:
        """Exponent of a power."""

    def __add__(self, other: Scalar | int, /) -> Scalar: ...
    def __radd__(self, other: Scalar | int, /) -> Scalar: ...
    def __sub__(self, other: Scalar | int, /) -> Scalar: ...
    def __rsub__(self, other: Scalar | int, /) -> Scalar: ...
    def __mul__(self, other: Scalar | int, /) -> Scalar: ...
    def __rmul__(self, other: Scalar | int, /) -> Scalar: ...
    def __truediv__(self, other: Scalar | int, /) -> Scalar: ...
    def __rtruediv__(self, other: Scalar | int, /) -> Scalar: ...
    def __pow__(self, other: Scalar | int, /) -> Scalar: ...
    def __neg__(self) -> Scalar: ...
    def __abs__(self) -> Scalar: ...

    def could_extract_minus_sign(self) -> bool:
        """Whether it is printed with a minus sign in front."""


class SymbolicMatrix(SymbolicExpression, Protocol):
    """A matrix expression or an explicit matrix; a vector is one of shape (n, 1)."""

    @property
    def shape(self) -> tuple[Any, Any]:
        """Rows and columns."""

    @property
    def T(self) -> Any:
        """The transposed matrix."""

    @property
    def blocks(self) -> Any:
        """Blocks of a matrix of blocks."""

    def __getitem__(self, place: Any, /) -> Any: ...
    def __iter__(self) -> Iterator[Any]: ...

    def applyfunc(self, function: Callable[[Any], Any]) -> Any:
        """A matrix of the values of a function at each element."""

    def tolist(self) -> list[list[Any]]:
        """Its rows."""


class Letter(SymbolicMatrix, Protocol):
    """A matrix symbol: an input, or a variation of one."""

    @property
    def name(self) -> str:
        """Its name."""


class Value(Scalar, SymbolicMatrix, Protocol):
    """A number or a matrix: only the formula tells which."""


def as_matrix(x: Any) -> SymbolicMatrix:
    """Matrix of SymPy, typed for mypy."""
    matrix: SymbolicMatrix = x
    return matrix


def as_scalar(x: Any) -> Scalar:
    """Number of SymPy, typed for mypy."""
    scalar: Scalar = x
    return scalar


def as_value(x: Any) -> Value:
    """Number or matrix of SymPy, typed as either for mypy."""
    value: Value = x
    return value
