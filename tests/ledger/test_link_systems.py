"""(29) and (33): every element, every known displacement, every zero; and the code's systems."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import sympy

from kousoku.codegen.linkage.assemble import Role, assemble
from kousoku.ledger.documents import link_examples
from kousoku.ledger.documents.link_examples import (
    ExampleVocabulary,
    displacement,
    faults_of,
    has_faults,
    lever,
    parts,
    piston,
)
from kousoku.ledger.formula import Array
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import prove, proved
from kousoku.ledger.reading import read
from kousoku.model.errors import LedgerError
from kousoku.model.reading.read import read_scene

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.codegen.linkage.assemble import Assembly
    from kousoku.ledger.entry import Entry

ENTRIES = {entry.equation: entry for entry in read(link_examples)}
SCENES = Path(__file__).parents[2] / "scenes"
WORDS = {"29": piston, "33": lever}
CELL = re.compile(r"-?\\(?:cos|sin) \\beta_\d\^0|-?l_\d\^0")

both = pytest.mark.parametrize("key", WORDS)


def other_signs(text: str) -> Iterator[str]:
    for match in CELL.finditer(text):
        cell = match.group()
        other = cell[1:] if cell.startswith("-") else f"-{cell}"
        yield text[: match.start()] + other + text[match.end() :]


@both
def test_every_sign_of_the_corrected_system_is_proved(key: str) -> None:
    forms = list(other_signs(ENTRIES[key].corrected))
    assert len(forms) == {"29": 28, "33": 56}[key]
    for text in forms:
        with pytest.raises(LedgerError):
            proved(text, WORDS[key]())


@both
def test_every_zero_of_the_corrected_system_is_proved(key: str) -> None:
    text = ENTRIES[key].corrected
    zeros = [match.start() for match in re.finditer(r"(?<=[\n ])0(?= [&\\\n])", text)]
    assert len(zeros) >= {"29": 32, "33": 136}[key]
    for place in zeros[::5]:
        with pytest.raises(LedgerError):
            proved(text[:place] + "1" + text[place + 1 :], WORDS[key]())


@pytest.mark.parametrize(
    ("key", "old", "new", "message"),
    [
        ("29", "v_3(0)", "v_3", "v_3 is 0, not unknown"),
        ("29", "u_1(0)", "u_1", "u_1 is 0"),
        ("29", "u_3 ", "u_3(0) ", "u_3 is not known, not 0"),
        ("29", r"\psi_{11}(\Delta\alpha)", r"\psi_{11}(0)", "ψ_11 is Δα, not 0"),
        ("29", r"\psi_{12}", r"\psi_{32}", "no displacement ψ_32"),
        ("29", r"0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0", r"0 \\ 0 \\ 0", "3 zeros for 6 equations"),
        ("33", r"\psi_{42}(0)", r"\psi_{42}", "ψ_42 is 0"),
        ("33", r"\psi_{41} ", r"\psi_{41}(0) ", "ψ_41 is not known"),
        ("33", "u_4 ", "u_3 ", "element"),
        ("33", r"0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0", "0", "zeros for 12 equations"),
    ],
)
def test_knowns_unknowns_and_the_right_side_are_proved(
    key: str, old: str, new: str, message: str
) -> None:
    entry = ENTRIES[key]
    text = entry.corrected.replace(old, new, 1)
    assert text != entry.corrected
    with pytest.raises(LedgerError, match=message):
        prove(replace(entry, corrected=text))


@both
def test_rows_cannot_change_places(key: str) -> None:
    lines = ENTRIES[key].corrected.splitlines()
    lines[1], lines[2] = lines[2], lines[1]
    with pytest.raises(LedgerError, match="element 1 of"):
        proved("\n".join(lines), WORDS[key]())


@both
def test_the_corrected_system_has_no_fault_and_the_printed_one_those_that_are_named(
    key: str,
) -> None:
    entry: Entry = ENTRIES[key]
    words = WORDS[key]()
    assert faults_of(entry.corrected, words) == []
    assert len(faults_of(entry.printed, words)) == {"29": 3, "33": 4}[key]
    with pytest.raises(LedgerError, match="its faults are none"):
        has_faults({"29": "piston", "33": "lever"}[key], entry.corrected, ["a fault"])


# -- what the code assembles ---------------------------------------------------------------------


def paper_system(key: str) -> tuple[sympy.Matrix, list[tuple[str, str]]]:
    """Corrected matrix and its displacements with their known values."""
    words: ExampleVocabulary = WORDS[key]()
    rows, cells = parts(parse(ENTRIES[key].corrected)[0].sides[0])
    return sympy.Matrix(words.matrix(rows)), [displacement(cell) for cell in cells]


def code_system(system: Assembly) -> sympy.Matrix:
    """Matrix (15) in the rows and columns that the code gives to the elements of a scene."""
    rows = []
    for number, element in enumerate(system.elements, 1):
        beta, length = sympy.symbols(f"β_{number}^0 l_{number}^0")
        c, s = sympy.cos(beta), sympy.sin(beta)
        d = [[-c, -s, 0, c, s, 0], [-s, c, length, s, -c, 0], [s, -c, 0, -s, c, -length]]
        for k in element.rows:
            row: list[Any] = [0] * len(system.coordinates)
            for value, term in zip(d[k], element.ends, strict=True):
                row[term.coordinate] += value * sympy.Rational(
                    term.factor.numerator, term.factor.denominator
                )
            rows.append(row)
    return sympy.Matrix(rows)


def assembled_scene(name: str) -> Assembly:
    return assemble(read_scene(SCENES / f"{name}.toml"))


def column_names(system: Assembly) -> list[str]:
    return [coordinate.name for coordinate in system.coordinates]


def test_the_code_assembles_the_piston_crank_as_corrected() -> None:
    """The slider is one coordinate in place of u3 and v3 = 0."""
    system = assembled_scene("piston_crank")
    wanted, displacements = paper_system("29")
    names = dict.fromkeys(["u_1", "v_1", "u_2", "v_2", "u_3"])
    ours = ["O1.x", "O1.y", "O2.x", "O2.y", "piston", "alpha", "l1@O2", "l2@O2", "l2@O3"]
    paper = [*names, "ψ_11", "ψ_12", "ψ_21", "ψ_22"]
    assert sorted(column_names(system)) == sorted(ours)
    got = code_system(system)
    index = [name for name, _ in displacements]
    for mine, theirs in zip(ours, paper, strict=True):
        column = got[:, column_names(system).index(mine)]
        assert column == wanted[:, index.index(theirs)], (mine, theirs)
    known = dict(displacements)
    for mine, theirs in zip(ours, paper, strict=True):
        role = system.coordinates[column_names(system).index(mine)].role
        assert known[theirs] == {Role.FIXED: "0", Role.INPUT: "Δα", Role.UNKNOWN: ""}[role]
    assert known["v_3"] == "0"


def test_the_code_assembles_the_lever_crank_as_corrected() -> None:
    """The code drops the frame, the fourth link: its rows say that node 4 stands still."""
    system = assembled_scene("lever_crank")
    wanted, displacements = paper_system("33")
    index = [name for name, _ in displacements]
    ours = [f"O{k}.{axis}" for k in (1, 2, 3, 4) for axis in "xy"]
    ours += ["alpha", "l1@O2", "l2@O2", "l2@O3", "l3@O3", "l3@O4"]
    assert [name for name in column_names(system) if name not in ours] == []
    got = code_system(system)
    assert got.rows == 9
    for mine, theirs in zip(ours, index, strict=False):
        column = got[:, column_names(system).index(mine)]
        assert column == wanted[:9, index.index(theirs)], (mine, theirs)
    frame = wanted[9:, :]
    assert frame[:, 2:6].is_zero_matrix
    held = [index.index(name) for name in ("u_4", "v_4", "ψ_41")]
    assert sympy.simplify(frame[:, held].det()) != 0
    known = dict(displacements)
    assert known["ψ_42"] == "0" and system.coordinates[ours.index("O4.x")].role is Role.FIXED


def test_an_array_of_zeros_stands_for_the_deformations() -> None:
    words = piston()
    zeros = parse(r"\begin{bmatrix} 0 \\ 0 \\ 0 \\ 0 \\ 0 \\ 0 \end{bmatrix}")[0].sides[0]
    assert isinstance(zeros, Array)
    first = words.value(zeros)[0, 0]
    u1, u2, v1, v2, beta = sympy.symbols("u_1 u_2 v_1 v_2 β_1^0")
    assert sympy.expand(first - sympy.cos(beta) * (u2 - u1) - sympy.sin(beta) * (v2 - v1)) == 0
