"""Names of scenes and of their elements: they become columns, symbols and folders."""

from __future__ import annotations

import keyword
import re
import sys

LONGEST_NAME = 31
"""C99 5.2.4.1 promises that many significant characters of an external name."""

PATTERN = r"^[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*_?$"
"""ASCII identifiers without the underscores that C and C++ reserve."""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


C_KEYWORDS = _words(
    """
    auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while alignas alignof bool constexpr false nullptr static_assert
    thread_local true typeof typeof_unqual and and_eq asm bitand bitor catch char8_t char16_t
    char32_t class co_await co_return co_yield compl concept const_cast consteval constinit
    decltype delete dynamic_cast explicit export friend mutable namespace new noexcept not not_eq
    operator or or_eq private protected public reinterpret_cast requires static_cast template this
    throw try typeid typename using virtual wchar_t xor xor_eq
    """
)
"""Keywords of C99 to C23, and of C++, which includes the emitted header."""

C_LIBRARY = _words(
    """
    acos asin atan atan2 cos sin tan acosh asinh atanh cosh sinh tanh exp exp2 expm1 frexp ilogb
    ldexp log log10 log1p log2 modf scalbn scalbln cbrt fabs hypot pow sqrt erf erfc lgamma tgamma
    ceil floor nearbyint rint lrint llrint round lround llround trunc fmod remainder remquo
    copysign nan nextafter nexttoward fdim fmax fmin fma fpclassify isfinite isinf isnan isnormal
    signbit isgreater isgreaterequal isless islessequal islessgreater isunordered HUGE_VAL
    INFINITY NAN FP_INFINITE FP_NAN FP_NORMAL FP_SUBNORMAL FP_ZERO FP_FAST_FMA NULL assert errno
    main offsetof size_t ptrdiff_t abs labs llabs div exit abort malloc calloc realloc free memcpy
    memmove memset memcmp strlen printf
    """
)
"""Names of <math.h> and of the few other headers that emitted programs include."""

FOLDERS = frozenset(
    ["kinds", "kousoku", "numpy", "con", "prn", "aux", "nul"]
    + [f"{device}{number}" for device in ("com", "lpt") for number in range(1, 10)]
)
"""Scene names that cannot be a folder: the shipped kinds, what a solver imports from beside its own
folder, and the devices of Windows."""


def name_problem(name: str) -> str | None:
    """Reason why `name` cannot name an element, or None when it can."""
    shown = repr(name if len(name) <= LONGEST_NAME else name[:LONGEST_NAME] + "…")
    if len(name) > LONGEST_NAME:
        return f"the name {shown} has {len(name)} characters; at most {LONGEST_NAME} are allowed"
    if not re.fullmatch(PATTERN[1:-1], name):
        return (
            f"{shown} is not a name: wanted an identifier, a Latin letter (a-z, A-Z) followed by "
            "such letters, digits and single underscores, such as 'O1' or 'crank_pin'"
        )
    if keyword.iskeyword(name):
        return f"{shown} is a Python keyword; choose another name, such as '{name}_1'"
    if name in C_KEYWORDS:
        return f"{shown} is a C or C++ keyword; choose another name, such as '{name}_1'"
    if name in C_LIBRARY:
        return f"{shown} is taken by the C library; choose another name, such as '{name}_1'"
    return None


def scene_name_problem(name: str) -> str | None:
    """Reason why `name` cannot name a scene, whose solver lives in a folder of that name."""
    if name.lower() in FOLDERS:
        return f"{name!r} cannot be the name of a folder of a solver; choose another name"
    if name in sys.stdlib_module_names:
        return (
            f"{name!r} is a module of Python, which a folder of that name would hide; choose "
            f"another name, such as '{name}_1'"
        )
    return name_problem(name)
