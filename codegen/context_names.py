"""Names in generated text: the symbols of the formula, kept wherever a language lets them stand."""

from __future__ import annotations

import re

from kousoku.model.errors import EmitError

_C = (
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while bool true false nullptr alignas alignof constexpr "
    "static_assert thread_local typeof typeof_unqual asm"
)
_CPP = (
    "and and_eq bitand bitor catch char16_t char32_t char8_t class co_await co_return co_yield "
    "compl concept const_cast consteval constinit decltype delete dynamic_cast explicit export "
    "friend mutable namespace new noexcept not not_eq operator or or_eq private protected public "
    "reinterpret_cast requires static_cast template this throw try typeid typename using virtual "
    "wchar_t xor xor_eq"
)
_PYTHON = (
    "False None True and as assert async await break class continue def del elif else except "
    "finally for from global if import in is lambda match nonlocal not or pass raise return try "
    "type while with yield"
)
_LIBM = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh drem erf erfc exp exp10 "
    "exp2 expm1 fabs fdim floor fma fmax fmin fmod frexp gamma hypot ilogb isfinite isinf isnan "
    "j0 j1 jn ldexp lgamma llrint llround log log10 log1p log2 logb lrint lround modf nan "
    "nearbyint nextafter nexttoward pow pow10 remainder remquo rint round scalb scalbln scalbn "
    "signbit signgam significand sin sincos sinh sqrt tan tanh tgamma trunc y0 y1 yn"
)
_OURS = (
    "CALL CALL_2 INLINE LANES NULL NUMBER abs calloc exit free index int8_t linux main malloc "
    "memcpy memset printf size_t unix "
    "at block element evaluate i in in_array lane n np out out_array outputs real self stride vec"
)
#: Fixed here, and not asked of the running Python, so that every version emits the same text.
RESERVED = frozenset(" ".join((_C, _CPP, _PYTHON, _LIBM, _OURS)).split())

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


def identifier(name: str, what: str) -> str:
    """``name`` if it is an identifier of both languages.

    Raises
    ------
    EmitError
        It is not.
    """
    if _IDENTIFIER.fullmatch(name) is None:
        raise EmitError(
            f"{what} {name!r} cannot be emitted: wanted a letter and then letters, digits or "
            "underscores, all ASCII; rename it"
        )
    return name


class Namer:
    """Gives every value of one function a name of its own."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._temporaries = 0

    def take(self, wanted: str) -> str:
        """``wanted``, with a trailing underscore for as long as it collides."""
        name = wanted
        while name in RESERVED or name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def keep(self, name: str) -> None:
        """Note that ``name``, taken in a wider scope, is not free."""
        self._taken.add(name)

    def temporary(self) -> str:
        """Name of a temporary, the next free one of t0, t1, …."""
        while (name := f"t{self._temporaries}") in self._taken:
            self._temporaries += 1
        self._taken.add(name)
        return name
