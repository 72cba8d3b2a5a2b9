"""From a formula's LaTeX to its tree: strict about brackets, ignorant of the meaning of symbols."""

from __future__ import annotations

from dataclasses import replace

from kousoku.ledger.formula import (
    RELATIONS,
    Array,
    Cross,
    Derivative,
    Division,
    FormulaNode,
    FunctionCall,
    Numeral,
    Power,
    Product,
    Statement,
    Sum,
    SymbolName,
    Tilde,
    Transposed,
)
from kousoku.ledger.tokens import tokens
from kousoku.model.errors import FormulaError

_FACES = {"\\mathbf", "\\boldsymbol", "\\mathrm"}
_SKIPPED = {"\\,", "\\;", "\\left", "\\right", "\\hline", "\\displaystyle", "$"}
#: Where something is taken: at the reference position.
_PLACES = {"ref."}
_CLOSING = {"(": ")", "[": "]", "\\{": "\\}", "\\langle": "\\rangle", "{": "}"}
_ENDS = {*_CLOSING.values(), "&", "\\\\", "⟧", "\\ ", ",", "\\quad", "\\qquad", "\\stackrel"}
_ENDS |= {"\\underset", *RELATIONS}
#: Words of prose in a formula: behind a letter part of its name, behind a bracket a remark.
_WORDS = "\\text"
#: Accents that stand for a derivative or an arrow, as marks in front of the letter.
_MARKS = {"\\dot": "d/dt ", "\\ddot": "d²/dt² ", "\\vec": "vec "}
_FUNCTIONS = {"\\cos": "cos", "\\sin": "sin"}


def parse(latex: str) -> tuple[Statement, ...]:
    """Statements of a formula; commas part them.

    Raises
    ------
    FormulaError
        Brackets do not match, or something cannot be read.
    """
    stream = _Stream([t for t in tokens(latex) if t not in _SKIPPED])
    statements = [_statement(stream)]
    while stream.peek() in {",", "\\quad", "\\qquad"}:
        stream.next()
        if [stream.peek(), stream.peek(1)] == ["(", _WORDS]:
            _remark(stream)
        elif stream.peek() not in {",", "\\quad", "\\qquad", ""}:
            statements.append(_statement(stream))
    if stream.peek():
        raise FormulaError(f"{stream.peek()!r} stands where the formula should end")
    return tuple(statements)


class _Stream:
    """Tokens and a position among them."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens
        self.position = 0

    def peek(self, ahead: int = 0) -> str:
        """Token without taking it; empty at the end."""
        position = self.position + ahead
        return self.tokens[position] if position < len(self.tokens) else ""

    def next(self) -> str:
        token = self.peek()
        if not token:
            raise FormulaError("the formula ends too early")
        self.position += 1
        return token

    def expect(self, expected: str) -> None:
        token = self.next()
        if token != expected:
            raise FormulaError(f"{token!r} stands where {expected!r} is wanted")

    def group(self) -> list[str]:
        """Take one token, or all between braces."""
        if self.peek() != "{":
            return [self.next()]
        self.next()
        inside: list[str] = []
        depth = 1
        while True:
            token = self.next()
            depth += (token == "{") - (token == "}")
            if depth == 0:
                return inside
            inside.append(token)


def _statement(stream: _Stream) -> Statement:
    sides, relations = [_sum(stream)], []
    while (relation := _relation(stream)) is not None:
        relations.append(relation)
        sides.append(_sum(stream))
    return Statement(tuple(sides), tuple(relations))


def _remark(stream: _Stream) -> None:
    """Pass over prose in parentheses behind a formula."""
    stream.expect("(")
    stream.expect(_WORDS)
    stream.group()
    stream.expect(")")


def _relation(stream: _Stream) -> str | None:
    """Take a relation with the remark above or below it; None where none follows."""
    if stream.peek() in {"\\stackrel", "\\underset"}:
        stream.next()
        stream.group()
        (relation,) = stream.group()
        if relation not in RELATIONS:
            raise FormulaError(f"{relation!r} is no relation")
        return relation
    return stream.next() if stream.peek() in RELATIONS else None


def _sum(stream: _Stream) -> FormulaNode:
    terms = []
    sign = 1
    if stream.peek() in {"+", "-"}:
        sign = -1 if stream.next() == "-" else 1
    while True:
        terms.append((sign, _product(stream)))
        if stream.peek() not in {"+", "-"}:
            break
        sign = -1 if stream.next() == "-" else 1
    return terms[0][1] if terms == [(1, terms[0][1])] else Sum(tuple(terms))


def _product(stream: _Stream) -> FormulaNode:
    factors = [_factor(stream)]
    while stream.peek() and stream.peek() not in _ENDS | {"+", "-"}:
        if stream.peek() == "/":
            stream.next()
            under = _factor(stream)
            factors = [Division(_joined(factors), under)]
        elif stream.peek() == "\\times":
            stream.next()
            factors[-1] = Cross(factors[-1], _factor(stream))
        else:
            if stream.peek() in {"*", "\\cdot"}:
                stream.next()
            factors.append(_factor(stream))
    return _joined(factors)


def _joined(factors: list[FormulaNode]) -> FormulaNode:
    return factors[0] if len(factors) == 1 else Product(tuple(factors))


def _factor(stream: _Stream) -> FormulaNode:
    node = _atom(stream)
    while True:
        match stream.peek():
            case "^":
                stream.next()
                node = _raised(node, stream.group())
            case "_":
                stream.next()
                if "".join(stream.group()) not in _PLACES:
                    raise FormulaError("a subscript of a bracket means nothing")
            case token if token == _WORDS:
                stream.next()
                node = _worded(node, "".join(stream.group()))
            case "\\sim":
                stream.next()
                node = Tilde(node)
            case _:
                return node


def _worded(node: FormulaNode, words: str) -> FormulaNode:
    """Symbol with words added to its name; behind anything else words name a position."""
    if isinstance(node, SymbolName):
        return replace(node, letter=node.letter + words)
    if words not in _PLACES:
        raise FormulaError(f"the words {words!r} stand behind something that is no symbol")
    return node


def _raised(node: FormulaNode, script: list[str]) -> FormulaNode:
    match script:
        case ["T"]:
            return Transposed(node)
        case ["-", "1"]:
            return Power(node, -1)
        case [digits] if digits.isdigit():
            return Power(node, int(digits))
    raise FormulaError(f"the superscript {''.join(script)!r} of a bracket means nothing")


def _atom(stream: _Stream) -> FormulaNode:
    token = stream.peek()
    if (variable := _differential(stream)) is not None:
        return Derivative(variable, _factor(stream))
    if token in _CLOSING:
        return _bracket(stream)
    match token:
        case "⟦":
            return _array(stream)
        case "cross":
            stream.next()
            return Tilde(_bracket(stream))
        case "\\frac":
            return _fraction(stream)
        case "\\sqrt":
            stream.next()
            return FunctionCall("sqrt", _bracket(stream))
        case "\\cos" | "\\sin":
            return _function(stream)
    if token[:1].isdigit():
        return Numeral(stream.next())
    if token in _ENDS or token in {"", "^", "_", "'"}:
        raise FormulaError(f"{token or 'the end'!r} stands where a symbol is wanted")
    return _symbol(stream)


def _differential(stream: _Stream) -> str | None:
    """Take ``(d/dt)`` and return ``t``; None where something else follows."""
    if [stream.peek(k) for k in (0, 1, 2, 3, 5)] != ["(", "d", "/", "d", ")"]:
        return None
    variable = stream.peek(4)
    stream.position += 6
    return variable


def _bracket(stream: _Stream) -> FormulaNode:
    """Read a bracket; cells that are parted by blanks make it a row."""
    opening = stream.next()
    if opening not in _CLOSING:
        raise FormulaError(f"{opening!r} stands where a bracket is wanted")
    cells = [_sum(stream)]
    while stream.peek() in {"\\ ", "\\quad"}:
        stream.next()
        cells.append(_sum(stream))
    closing = stream.next()
    if closing != _CLOSING[opening]:
        raise FormulaError(f"{closing!r} closes the bracket {opening!r}")
    return cells[0] if len(cells) == 1 else Array((tuple(cells),))


def _array(stream: _Stream) -> FormulaNode:
    stream.expect("⟦")
    rows: list[list[FormulaNode]] = [[]]
    while True:
        rows[-1].append(_sum(stream))
        token = stream.next()
        if token == "\\\\" and stream.peek() != "⟧":
            rows.append([])
        elif token in {"\\\\", "⟧"}:
            if token == "\\\\":
                stream.expect("⟧")
            break
        elif token != "&":
            raise FormulaError(f"{token!r} stands inside an array")
    if len({len(row) for row in rows}) > 1:
        counts = ", ".join(str(len(row)) for row in rows)
        raise FormulaError(f"the rows of an array have {counts} cells")
    return Array(tuple(tuple(row) for row in rows))


def _fraction(stream: _Stream) -> FormulaNode:
    stream.expect("\\frac")
    if (stream.group(), stream.group()) == (["d"], ["d", "t"]):
        if stream.peek() == "\\{":
            raise FormulaError("d/dt stands before a bracket")
        return _marked("d/dt ", _symbol(stream))
    raise FormulaError("a fraction that is not d/dt")


def _function(stream: _Stream) -> FormulaNode:
    function = _FUNCTIONS[stream.next()]
    exponent = 1
    if stream.peek() == "^":
        stream.next()
        (digits,) = stream.group()
        exponent = int(digits)
    factors: list[FormulaNode] = []
    while stream.peek()[:1].isdigit():
        factors.append(Numeral(stream.next()))
    factors.append(_bracket(stream) if stream.peek() in _CLOSING else _symbol(stream))
    call = FunctionCall(function, _joined(factors))
    return call if exponent == 1 else Power(call, exponent)


def _marked(mark: str, node: FormulaNode) -> FormulaNode:
    """Put a mark in front of a symbol's letter, under its tilde and transposition."""
    match node:
        case SymbolName():
            return SymbolName(mark + node.letter, node.primes, node.sub, node.sup)
        case Tilde():
            return Tilde(_marked(mark, node.inner))
        case Transposed():
            return Transposed(_marked(mark, node.inner))
    raise FormulaError(f"{mark.strip()} stands before something that is no symbol")


def _symbol(stream: _Stream) -> FormulaNode:
    """Read a letter with its marks and scripts; arguments in parentheses are left out."""
    token = stream.next()
    if token in {"δ", "Δ"} or (token == "d" and _is_letter(stream.peek())):
        return _marked(token, _symbol(stream))
    if token == "d" and stream.peek() == "^" and _is_letter(stream.peek(2)):
        stream.next()
        return _marked(f"d^{stream.next()} ", _symbol(stream))
    node: FormulaNode = Numeral(token) if token.isdigit() else SymbolName(token)
    if token in {"\\tilde", *_MARKS, *_FACES}:
        inside = _Stream(stream.group())
        if inside.tokens == ["0"]:  # bold, of a vector or a matrix
            return Numeral(inside.next())
        node = _symbol(inside)
        if inside.peek():
            raise FormulaError(f"{token} stands over more than one symbol")
        if token in _MARKS:
            node = _marked(_MARKS[token], node)
        elif token == "\\tilde":
            node = Tilde(node)
    elif not token.isalnum():
        raise FormulaError(f"{token!r} stands where a symbol is wanted")
    node = _scripted(stream, node)
    _skip_arguments(stream)
    return node


def _is_letter(token: str) -> bool:
    return token.isalpha() or token in _FACES | {*_MARKS, "\\tilde"}


def _scripted(stream: _Stream, node: FormulaNode) -> FormulaNode:
    """Give the scripts that follow to the symbol; a ``T`` at the end transposes."""
    primes, sub, sup = "", "", ""
    while stream.peek() in {"'", "^", "_"}:
        match stream.next():
            case "'":
                primes += "'"
            case "_":
                sub += "".join(stream.group())
            case _:
                sup += "".join(t for t in stream.group() if t not in {"{", "}"})
    is_transposed = sup.endswith("T")
    sup = sup.removesuffix("T")
    is_inverse = sup == "-1"
    node = _with_scripts(node, primes, sub, "" if is_inverse else sup)
    node = Power(node, -1) if is_inverse else node
    return Transposed(node) if is_transposed else node


def _with_scripts(node: FormulaNode, primes: str, sub: str, sup: str) -> FormulaNode:
    match node:
        case SymbolName():
            return SymbolName(node.letter, node.primes + primes, node.sub + sub, node.sup + sup)
        case Tilde():
            return Tilde(_with_scripts(node.inner, primes, sub, sup))
        case _ if not primes + sub + sup:
            return node
    raise FormulaError("scripts stand at something that is no symbol")


def _skip_arguments(stream: _Stream) -> None:
    """Pass over ``(…, …)`` behind the symbol of a function: C of two vectors."""
    if stream.peek() != "(":
        return
    depth, has_comma = 0, False
    for ahead in range(len(stream.tokens) - stream.position):
        token = stream.peek(ahead)
        depth += (token == "(") - (token == ")")
        has_comma = has_comma or (token == "," and depth == 1)
        if depth == 0:
            if has_comma:
                stream.position += ahead + 1
            return
