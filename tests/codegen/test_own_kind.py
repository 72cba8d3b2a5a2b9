"""A kind of one's own, from its value to a verified folder, without editing kousoku."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from sympy import Determinant, Symbol, sqrt
from sympy.matrices.expressions import Identity, Inverse, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.checking import verify as verify_any
from kousoku.codegen.generate import generate, write_tree
from kousoku.deriving import body, kernels, number
from kousoku.deriving import derive as derive_own
from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.runtime import load, verify
from kousoku.symbolic import derive
from kousoku.symbolic.bodies import COMPONENTS, SYMBOLS, A
from kousoku.symbolic.components import dot, rotate, subtract
from kousoku.symbolic.constraint import Constraint, derive_constraint
from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function
from kousoku.symbolic.matrices import add, elements, mul, neg, symbol, transpose

ROOT = Path(__file__).parents[2]
COSINE = Quantity("cos_theta", (), "-", "cosine of the given angle")
AXES = {body: mul(A[body], SYMBOLS[f"a_{body}_b"]) for body in "ij"}
TURNED = [rotate(COMPONENTS[f"p_{body}"], COMPONENTS[f"a_{body}_b"]) for body in "ij"]
VALUE = add(mul(transpose(AXES["i"]), AXES["j"]), neg(mul(symbol(COSINE), Identity(1))))
SLANT = Constraint(
    name="slant",
    kind="slant",
    title="two vectors at a given angle",
    source="this test",
    formula="C = a_i · a_j − cos_theta",
    unit="-",
    steps=(),
    value=VALUE,
    components=(dot(*TURNED) - elements(COSINE)[0],),
    inputs=(COSINE,),
)


def hand_made(*inputs: Quantity, output: str = "f", component: Any = None) -> Derivation:
    """Function f = the first input, as a package of one kernel."""
    x = component if component is not None else elements(inputs[0])[0]
    outputs = (
        DerivedOutput(
            Quantity(output, (), "m", "that"), symbol(inputs[0]), ImmutableDenseMatrix([x])
        ),
    )
    function = Function("kernel", "title", "f = x", "this test", tuple(inputs), outputs)
    return Derivation("own", "own", "title", "this test", (), (function,))


X = Quantity("x", (), "m", "a length")


@pytest.fixture(scope="module")
def tree() -> dict[str, str]:
    return generate(derive_constraint(SLANT), regenerate="python slant.py")


def test_an_own_kind_is_emitted_and_verified(
    tree: dict[str, str], tmp_path: Path, backend: Literal["c", "numpy"]
) -> None:
    assert " * regenerate: python slant.py\n" in tree["kernels.c"]
    assert write_tree(tmp_path / "slant", tree) == list(tree)
    library = load(tmp_path / "slant", target=backend)
    report = verify(library, target=backend)
    report.check()
    assert {row.output for row in report.rows} == {
        *("C", "C_q", "nu", "gamma"),
        *("reaction", "reaction_q"),
    }
    half_turn_about_x = [0.0, 1.0, 0.0, 0.0]
    c, c_q = library.constraint(
        p_i=[1.0, 0.0, 0.0, 0.0],
        a_i_b=[0.0, 0.0, 1.0],
        p_j=half_turn_about_x,
        a_j_b=[0.0, 0.6, 0.8],
        cos_theta=-0.8,
    )
    assert c.tolist() == [0.0]
    # Body i turns its axis z about x towards −y: δC = −δθ_x · (a_j)_y, and a_j is (0, −0.6, −0.8).
    assert np.array_equal(c_q[0, 3:6], [0.6, 0.0, 0.0])
    assert np.array_equal(c_q[0, [0, 1, 2, 6, 7, 8]], np.zeros(6))


def test_references_of_an_own_kind_hold_its_own_input_and_all_sorts_of_points(
    tree: dict[str, str],
) -> None:
    text = tree["reference.json.gz"]
    for label in (
        *("ordinary", "badly scaled arrays", "badly scaled elements", "nearly coincident"),
        *("near half a turn, near an axis", "on the manifold", "near the manifold"),
        *("p not normalised", "cos_theta is zero", "subnormal cos_theta", "is nan"),
    ):
        assert label in text
    assert '"cos_theta":' in text


def test_equal_derivations_give_equal_folders(tree: dict[str, str]) -> None:
    assert generate(derive_constraint(SLANT), regenerate="python slant.py") == tree


def test_a_kind_whose_right_hand_sides_vanish_has_kernels_for_them(tmp_path: Path) -> None:
    apart = Constraint(
        name="origins",
        kind="origins",
        title="two origins coincide",
        source="this test",
        formula="C = r_j − r_i",
        unit="m",
        steps=(),
        value=add(SYMBOLS["r_j"], neg(SYMBOLS["r_i"])),
        components=tuple(subtract(COMPONENTS["r_j"], COMPONENTS["r_i"])),
    )
    write_tree(tmp_path, generate(derive_constraint(apart)))
    assert verify(tmp_path, target="numpy").ok
    nu, gamma = load(tmp_path, target="numpy").rates(np.ones(3), np.ones(3))
    assert not nu.any()
    assert not gamma.any()


def test_a_wrong_sign_in_the_components_is_refused_by_the_proof() -> None:
    wrong = replace(SLANT, components=(dot(*TURNED) + elements(COSINE)[0],))
    with pytest.raises(DerivationError, match="two levels differ in C, element 0 of 1"):
        generate(derive_constraint(wrong))


def test_a_wrong_transpose_on_the_matrix_level_is_refused_by_the_proof() -> None:
    axis = mul(transpose(A["i"]), SYMBOLS["a_i_b"])
    value = add(mul(transpose(axis), AXES["j"]), neg(mul(symbol(COSINE), Identity(1))))
    with pytest.raises(DerivationError, match="two levels differ in C, element 0 of 1"):
        generate(derive_constraint(replace(SLANT, value=value)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"components": ()}, r"shape \(1, 1\) and there are 0 components"),
        ({"components": SLANT.components * 2}, "there are 2 components"),
        ({"value": symbol(COSINE)}, r"has shape \(\)"),
        ({"inputs": ()}, "slant.constraint: the matrix level of C holds cos_theta, which is not"),
        ({"inputs": (COSINE, replace(COSINE, name="r_i"))}, "input r_i is there already"),
        ({"inputs": (COSINE, replace(COSINE, name="lam"))}, "input lam is there already"),
        ({"components": (Symbol("x") + dot(*TURNED),)}, "components of C hold x, which is not"),
        ({"inputs": (replace(COSINE, shape=(2,)),)}, "in that shape; declare it"),
        ({"value": mul(transpose(AXES["i"]), Inverse(A["i"]), AXES["j"])}, "rule for Inverse"),
        ({"value": mul(Determinant(A["i"]), VALUE)}, "no rule for Determinant"),
        (
            {"value": mul(transpose(AXES["i"]), MatrixSymbol("W", 3, 3), AXES["j"])},
            "holds W, which is not among the inputs",
        ),
        (
            {"components": dot(*TURNED) - elements(COSINE)[0]},
            "slant: components is of type Add, wanted a tuple of expressions; of one",
        ),
        (
            {"inputs": COSINE},
            "slant: inputs is of type Quantity, wanted a tuple of quantities; of one",
        ),
    ],
)
def test_a_mistake_gets_one_clear_message(change: dict[str, Any], message: str) -> None:
    with pytest.raises(DerivationError, match=message) as caught:
        generate(derive_constraint(replace(SLANT, **change)))
    assert "\n" not in str(caught.value)


def test_a_number_in_place_of_a_matrix_is_refused_where_it_stands() -> None:
    with pytest.raises(DerivationError, match=r"-cos_theta alone is a number; .* by Identity\(1\)"):
        neg(symbol(COSINE))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("two slants", "not a name"),
        ("1slant", "not a name"),
        ("../slant", "not a name"),
        ("class", "is a Python keyword"),
        ("double", "is a C or C.. keyword"),
        ("sin", "taken by the C library"),
        ("n1", "taken by a kind that kousoku ships"),
        ("P2_x", "taken by a kind that kousoku ships"),
        ("inline", "taken by a kind that kousoku ships"),
    ],
)
def test_a_name_that_cannot_be_emitted_or_is_taken_is_refused(name: str, message: str) -> None:
    with pytest.raises(DerivationError, match=message):
        generate(derive_constraint(replace(SLANT, name=name)))


@pytest.mark.parametrize("name", ["lambda", "register", "2x", "x y"])
def test_a_name_of_an_input_that_cannot_be_emitted_is_refused(name: str) -> None:
    with pytest.raises(DerivationError, match=r"own.kernel: name of an input or output: '"):
        generate(hand_made(replace(X, name=name)))


def test_two_things_of_one_name_are_refused() -> None:
    with pytest.raises(DerivationError, match="'x' is there twice"):
        generate(hand_made(X, X))
    with pytest.raises(DerivationError, match="'x' is there twice"):
        generate(hand_made(X, output="x"))
    derivation = hand_made(X)
    with pytest.raises(DerivationError, match="'kernel' is there twice"):
        generate(replace(derivation, functions=derivation.functions * 2))


def test_a_shipped_derivation_is_generated_by_its_name_alone() -> None:
    with pytest.raises(DerivationError, match="'n1' is taken by a kind that kousoku ships"):
        generate(derive("n1"))


def test_functions_that_were_put_together_by_hand_are_emitted_too(tmp_path: Path) -> None:
    write_tree(tmp_path, generate(hand_made(X)))
    assert verify(tmp_path, target="numpy").ok
    assert load(tmp_path, target="numpy").kernel(3.0)[0] == 3.0


def test_sizes_that_do_not_agree_are_refused() -> None:
    derivation = hand_made(X)
    (function,) = derivation.functions
    (output,) = function.outputs
    wide = replace(output, quantity=replace(output.quantity, shape=(2,)))
    wrong = replace(derivation, functions=(replace(function, outputs=(wide,)),))
    with pytest.raises(
        DerivationError, match=r"f has shape \(2,\), 2 numbers, but the matrix level"
    ):
        generate(wrong)


def root(inside: Any) -> Derivation:
    """Function f = √inside, with x and y."""
    y = Quantity("y", (), "m", "another length")
    derivation = hand_made(X, y)
    (function,) = derivation.functions
    (output,) = function.outputs
    value = sqrt(inside)
    output = replace(output, expression=value, components=ImmutableDenseMatrix([value]))
    return replace(derivation, functions=(replace(function, outputs=(output,)),))


def test_points_where_a_root_is_not_real_are_left_out(tmp_path: Path) -> None:
    write_tree(tmp_path, generate(root(Symbol("x") ** 2 - Symbol("y") ** 2)))
    report = verify(tmp_path, target="numpy")
    report.check()


def test_a_root_that_is_never_real_is_refused() -> None:
    with pytest.raises(DerivationError, match="no real root at every point"):
        generate(root(-(Symbol("x") ** 2) - Symbol("y") ** 2 - 1))


def test_a_constraint_in_vectors_has_verified_kernels(tmp_path: Path) -> None:
    i, j = body("i"), body("j")
    d = j.point("t") - i.point()
    own = derive_own("plane", C=[i.axis("b").dot(d), 2 * d[2] - number("h", "m")])
    library = kernels(own, tmp_path / "plane", target="numpy")
    verify(library, target="numpy").check()
    numbers = {
        name: np.linspace(0.2, 1.0, q.size).reshape(q.shape) for name, q in own.inputs.items()
    }
    given: dict[str, Any] = {q.name: numbers[q.name] for q in own.functions[1].inputs}
    gamma = library.rates(*given.values(), outputs=["gamma"])[0]
    assert np.allclose(gamma, own.at(given)["gamma"], rtol=1e-13, atol=0)


def test_kernels_without_a_folder_are_kept_by_their_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    library = kernels(hand_made(X), target="numpy")
    assert library.kernel(3.0)[0] == 3.0
    assert library.folder.parents[1] == tmp_path / "kernels"
    assert kernels(hand_made(X), target="numpy").folder == library.folder
    assert kernels(library.folder, target="numpy").manifest == library.manifest
    report = verify_any(hand_made(X), target="numpy")
    assert report.ok
    assert report.folder == str(library.folder)


def test_kernels_of_a_name_are_those_that_are_committed() -> None:
    assert kernels("INLINE", target="numpy").manifest.package == "p2"


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_the_file_that_the_document_shows_runs_as_it_stands(tmp_path: Path) -> None:
    document = (ROOT / "docs" / "own_kind.md").read_text(encoding="utf-8")
    program, scene = re.findall(r"```python\n(.*?)```", document, re.DOTALL)
    (tmp_path / "slant.py").write_text(program + scene, encoding="utf-8")
    command = [sys.executable, "-X", "utf8", "slant.py"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=True)
    assert "C = a_i^T a_j − cos_θ" in run.stdout
    assert "\n[0.] [[" in run.stdout
    assert "trust: energy" in run.stdout
    torque = [float(x) for x in run.stdout.splitlines()[-1].strip("[]").split()]
    assert np.linalg.norm(torque) == pytest.approx(0.2 * 981 * 3 * 0.6)
    assert "kousoku." not in program + scene  # public names only
    statements = [line for line in program.splitlines() if line.strip()]
    assert len(statements) <= 11
    assert (tmp_path / "slant" / "kernels.h").exists()
