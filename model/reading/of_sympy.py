"""Values of SymPy in a scene: numbers, vectors, and expressions that stand for formulas."""

from __future__ import annotations

import re
import sys
from typing import Any

OF_SYMPY = {"Abs": "abs", "Min": "min", "Max": "max", "E": "exp(1)"}
"""Names of SymPy that formulas of a scene write in another way."""


def is_of_sympy(value: object) -> bool:
    """Whether a value is an expression or a matrix of SymPy, which is not imported here."""
    sympy: Any = sys.modules.get("sympy")
    return sympy is not None and isinstance(value, (sympy.Basic, sympy.MatrixBase))


def plain_of(value: Any) -> Any:
    """Number for a number of SymPy, a list for a vector, else the text of a formula.

    The text is read by the grammar of scenes as any other is: what it does not have is refused.

    Raises
    ------
    ValueError
        It is none of these, such as an equation.
    """
    sympy: Any = sys.modules["sympy"]
    if isinstance(value, sympy.MatrixBase):
        is_vector = 1 in value.shape
        rows = value if is_vector else value.tolist()
        return [plain_of(row) if is_vector else list(map(plain_of, row)) for row in rows]
    if not isinstance(value, sympy.Expr):
        raise ValueError(f"{type(value).__name__} of SymPy is no expression; wanted one, or text")
    if value.is_Integer:
        return int(value)
    if value.is_number and value.is_real and value.is_finite:
        return float(value)
    # A Float is printed in 15 digits: a name with all of them stands for it.
    digits = {number: sympy.Symbol(f"({float(number)!r})") for number in value.atoms(sympy.Float)}
    text = str(value.xreplace(digits)).replace("**", "^")
    return re.sub(r"[A-Za-z_]\w*", lambda word: OF_SYMPY.get(word[0], word[0]), text)
