"""The builder gives what a file gives, and checks as a file is checked."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.model.reading.typed_keys import keys_text

SCENES = Path(__file__).parents[3] / "scenes"


def lever() -> SceneBuilder:
    """Lever crank of the paper, step by step."""
    return (
        SceneBuilder(
            "lever_crank", unit="cm", title="Lever crank, Yamada and Tatsumi 1981, figure 6"
        )
        .node("O1", at=(0, 0), fixed=True)
        .node("O2", at=(30, 0))
        .node("O3", at=(45, 58))
        .node("O4", at=(100, 0), fixed=True)
        .link("l1", "O1", "O2", length=30)
        .link("l2", "O2", "O3", length=60)
        .link("l3", "O3", "O4", length=80)
        .link("l4", "O4", "O1", length=100)
        .input("alpha", link="l1", about="O1", turns=1)
        .method(residual=1e-13)
    )


def test_the_paper_lever_crank_is_the_same_from_python() -> None:
    assert lever().build() == read_scene(SCENES / "lever_crank.toml")


def test_every_element_has_a_call() -> None:
    scene = (
        SceneBuilder("all", unit="in", divisions=12)
        .node("A", at=np.array([0.0, 0.0]), fixed=True)
        .node("B", at=(np.float64(1), 0))
        .node("C", at=(1, 1))
        .node("S", at=(3, 0))
        .link("ab", "A", "B")
        .link("bc", "B", "C")
        .link("bs", "B", "S", length=np.float64(2))
        .rigid("corner", at="B", links=("ab", "bc"), angle=-1)
        .slider("s", node="S", through=(0, 0), direction=(1, 0))
        .input("alpha", link="ab", about="A", start=0.5, turns=-1, rate=-2, acceleration=0.25)
        .outputs("velocities", "angles")
        .method(scheme="paper", iterations=9)
        .build()
    )
    assert scene.rigid["corner"].angle == -1
    assert scene.sliders["s"].direction == (1, 0)
    assert scene.inputs["alpha"].acceleration == 0.25
    assert scene.outputs == ("velocities", "angles")
    assert (scene.method.scheme, scene.method.iterations) == ("paper", 9)


def test_spatial_scenes_are_built_from_the_keys_of_the_records() -> None:
    scene = (
        SceneBuilder("pendulum", unit="m")
        .body("bar", position=(0, 0, 0), orientation={"quaternion": (1, 0, 0, 1), "order": "wxyz"})
        .joint(
            "a",
            type="revolute",
            bodies=("ground", "bar"),
            points=np.zeros((2, 3)),
            axes=np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
        )
        .input("alpha", joint="a")
        .build()
    )
    assert scene.joints["a"].axes == ((0, 0, 1), (0, 0, 1))


def test_gravity_may_come_out_of_an_array() -> None:
    scene = SceneBuilder("stone", unit="m").gravity(*np.array([0, 0.5, -9.81]))
    built = scene.body("stone", position=(0, 0, 0), point=True, mass=1).build()
    assert built.gravity == (0.0, 0.5, -9.81)


def test_a_name_given_twice_is_refused_at_once() -> None:
    with pytest.raises(SceneError, match=r"nodes\.O2: the name 'O2' is given twice"):
        lever().node("O2", at=(1, 1))


@pytest.mark.parametrize("length", ["30", "2*15", float("nan"), 0, -1, True])
def test_lengths_that_are_no_lengths_are_refused_as_in_a_file(length: float) -> None:
    with pytest.raises(SceneError, match=r"^links\.l5\.length: "):
        lever().link("l5", "O1", "O3", length=length).build()


def test_a_scene_that_was_built_does_not_change_with_its_builder() -> None:
    builder = lever()
    scene = builder.build()
    builder.node("P", at=(1, 1))
    assert "P" not in scene.nodes


def test_drivers_coordinates_and_parameters_have_a_call() -> None:
    nut = read_scene(SCENES / "falling_nut.toml")
    built = (
        SceneBuilder("falling_nut", unit="m", title=nut.title)
        .gravity(0, 0, -9.80665)
        .outputs("velocities", "coordinates", "reactions", "energies")
        .body(
            "nut",
            position=(0, 0, 0),
            mass=2,
            inertia={"xx": 0.0015, "yy": 0.0015, "zz": np.float64(0.001)},
        )
        .joint(
            "thread",
            type="screw",
            bodies=("ground", "nut"),
            at=(0, 0, 0),
            axis=(0, 0, 1),
            pitch=0.1,
        )
        .coordinate("height", body="nut", along=np.array([0, 0, 1]))
        .coordinate("turned", joint="thread", of="angle")
    )
    assert built.build() == nut
    driven = built.parameter("speed", np.float64(2)).driver(
        "motor", coordinate="turned", value="speed*t"
    )
    scene = driven.build()
    assert (scene.parameters, scene.drivers["motor"].value) == ({"speed": 2}, "speed*t")
    with pytest.raises(SceneError, match=r"parameters\.speed: the name 'speed' is given twice"):
        built.parameter("speed", 3)


def test_the_typed_keys_are_those_of_the_records() -> None:
    committed = SCENES.parent / "model" / "reading" / "keys.py"
    assert committed.read_text(encoding="utf-8") == keys_text(), (
        "python -m kousoku.model.reading.typed_keys > model/reading/keys.py"
    )


@pytest.mark.parametrize("record", ["Body", "Joint", "Coordinate", "Driver", "Force", "Method"])
def test_a_call_takes_the_typed_keys_of_its_record(record: str) -> None:
    keys = inspect.signature(getattr(SceneBuilder, record.lower())).parameters["keys"]
    assert (keys.kind, keys.annotation) == (keys.VAR_KEYWORD, f"Unpack[{record}Keys]")


def test_a_key_that_is_not_there_is_refused_at_once() -> None:
    builder: Any = SceneBuilder("s", unit="m")
    with pytest.raises(SceneError, match=r"bodies\.b\.positoin: unknown key; did you mean"):
        builder.body("b", positoin=(0, 0, 0))
    with pytest.raises(SceneError, match=r"joints\.a\.type: is missing"):
        builder.joint("a", bodies=("ground", "b"))
    with pytest.raises(SceneError, match=r"bodies\.b\.rods\[0\]\.mas: unknown key"):
        builder.body("b", position=(0, 0, 0), rods=[{"mas": 1, "ends": []}])
    with pytest.raises(SceneError, match=r"coordinates\.c\.hold: the number 1 stands"):
        builder.coordinate("c", joint="a", hold=1)
    with pytest.raises(SceneError, match=r"method\.tolerence: unknown key"):
        builder.method(tolerence=1)


def slider(force: Any) -> SceneBuilder:
    builder = SceneBuilder("s", unit="m").parameter("k", 3)
    builder.body("b", position=(0, 0, 0), mass=1, point=True)
    line: dict[str, Any] = {"points": np.zeros((2, 3)), "axes": [[1, 0, 0]] * 2}
    builder.joint("a", type="point_on_line", bodies=("ground", "b"), **line)
    builder.coordinate("x_1", body="b", along=(1, 0, 0))
    return builder.force("f", type="along", coordinate="x_1", force=force)


T, K, X, RATE = sympy.symbols("t k x_1 x_1_dot")
NAMES = ("t", "k", "x_1", "x_1_dot")


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (sympy.sin(T), "sin(t)"),
        (-K * X**2 / 3, "-k*x_1^2/3"),
        ((0.1 + 0.2) * X - 1e-20 * T, None),
        (sympy.Abs(X) * sympy.exp(-T), "exp(-t)*abs(x_1)"),
        (sympy.Max(X, 0) + sympy.Min(T, K, X), None),
        (sympy.atan2(X, T) ** 2.5 + sympy.pi * T, None),
        (-RATE / sympy.sqrt(RATE**2 + sympy.Float("1e-6")), None),
        (sympy.E**2 * X, "x_1*exp(2)"),
    ],
)
def test_an_expression_of_sympy_is_a_formula(expression: sympy.Expr, text: str | None) -> None:
    given = slider(expression).build().forces["f"].force
    assert isinstance(given, str)
    values = {"t": 0.7, "k": 3.0, "x_1": 0.4, "x_1_dot": -0.2}
    found = value_of(parse_expression(given, NAMES), values)
    assert found == pytest.approx(float(expression.subs(values)), rel=1e-15)
    assert given == (text or given)


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        (sympy.Function("theta")(T), "unknown name 'theta'"),
        (sympy.I * T, "unknown name 'I'"),
        (sympy.Symbol("__import__('os')") * T, "unknown name"),
        (sympy.Symbol("1); x") + T, "stands where|belongs to no formula"),
        (sympy.Eq(T, 1), "Equality of SymPy is no expression"),
        (sympy.oo, "unknown name 'oo'"),
    ],
)
def test_an_expression_that_is_no_formula_of_a_scene_is_refused(
    expression: object, says: str
) -> None:
    with pytest.raises(SceneError, match=says):
        slider(expression).build()


def test_numbers_and_vectors_of_sympy_are_numbers() -> None:
    at = sympy.Matrix([sympy.Rational(1, 4), 0, sympy.sqrt(2)])
    scene = SceneBuilder("s", unit="m").body("b", position=at, point=True, mass=sympy.Integer(2))
    body = scene.build().bodies["b"]
    assert body.position == (0.25, 0.0, float(sympy.sqrt(2)))
    assert body.mass == 2


def test_tables_take_values_of_sympy_as_calls_do() -> None:
    """A vector was told to be lists of one, and a number a value of type Half."""
    tree: dict[str, Any] = {
        "name": "s",
        "unit": "m",
        "bodies": {"b": {"position": sympy.Matrix([sympy.Rational(1, 4), 0, 2]), "mass": 1}},
        "coordinates": {"x": {"body": "b", "along": sympy.Matrix([[1, 0, 0]])}},
        "forces": {"f": {"type": "along", "coordinate": "x", "force": -(sympy.Symbol("x") ** 2)}},
    }
    tree["bodies"]["b"]["point"] = True
    scene = scene_from_dict(tree)
    assert scene.bodies["b"].position == (0.25, 0.0, 2.0)
    nodes = {"A": {"at": sympy.Matrix([1, 2]), "fixed": True}, "B": {"at": [1, sympy.Integer(5)]}}
    linkage = scene_from_dict({
        "name": "l", "unit": "mm", "divisions": 4, "nodes": nodes,
        "links": {"c": {"nodes": ["A", "B"]}},
        "inputs": {"al": {"link": "c", "about": "A", "from": 0, "turns": 1, "rate": 1}},
    })  # fmt: skip
    assert linkage.nodes["A"].at == (1, 2)
    tree["forces"]["f"]["force"] = sympy.Eq(sympy.Symbol("x"), 1)
    with pytest.raises(SceneError, match=r"forces\.f\.force: Equality of SymPy is no expression"):
        scene_from_dict(tree)
