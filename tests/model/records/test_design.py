"""Numbers of a scene that are formulas of parameters: read, checked, written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.model.errors import MOST_FOUND, SceneError
from kousoku.model.expressions import design_numbers
from kousoku.model.expressions.design_numbers import with_numbers
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers.varying import is_varying
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.write import to_toml
from kousoku.model.records.design import Formula

if TYPE_CHECKING:
    from collections.abc import Collection

    from kousoku.model.operations.expression import Expression

SCENE = """
name = "bar"
unit = "cm"
[parameters]
m = 2.0
L = 150
[bodies.bar]
position = [0, 0, 0]
mass = "m"
center = ["L/2", 0, 0]
inertia = { xx = 100, yy = "m*L^2/12", zz = "m*L^2/12" }
[joints.hinge]
type = "revolute"
bodies = ["ground", "bar"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 1, 0], [0, 1, 0]]
"""


def test_a_formula_has_its_value_and_its_text() -> None:
    bar = scene_from_toml(SCENE).bodies["bar"]
    assert bar.center is not None
    assert bar.center[0] == Formula("L/2")
    assert float(bar.center[0]) == 75.0
    assert with_numbers(scene_from_toml(SCENE)).bodies["bar"].center == (75.0, 0.0, 0.0)


def test_a_formula_without_names_is_a_number_also_in_a_scene_without_parameters() -> None:
    text = SCENE.replace("m = 2.0\nL = 150\n", "").replace('"m*L^2/12"', "100")
    text = text.replace('"m"', '"sqrt(4)"').replace('"L/2"', '"75*cos(0)"')
    text = text.replace("axes = [[0, ", 'axes = [["sin(0)", ') + "zero = [[1, 0, 0], [1, 0, 0]]\n"
    scene = scene_from_toml(text)
    assert type(scene.bodies["bar"].mass) is float
    axes = scene.joints["hinge"].axes
    assert axes is not None
    assert type(axes[0][0]) is float


def test_a_scene_with_formulas_is_written_and_read_back() -> None:
    scene = scene_from_toml(SCENE)
    assert scene_from_toml(to_toml(scene)) == scene
    assert hash(scene.bodies["bar"]) == hash(scene_from_toml(SCENE).bodies["bar"])


def test_the_builder_takes_formulas() -> None:
    scene = scene_from_toml(SCENE)
    built = (
        SceneBuilder("bar", unit="cm")
        .parameter("m", 2.0)
        .parameter("L", 150)
        .body(
            "bar",
            position=(0, 0, 0),
            mass="m",
            center=("L/2", 0, 0),
            inertia={"xx": 100, "yy": "m*L^2/12", "zz": "m*L^2/12"},
        )
        .joint(
            "hinge",
            type="revolute",
            bodies=("ground", "bar"),
            points=((0, 0, 0), (0, 0, 0)),
            axes=((0, 1, 0), (0, 1, 0)),
        )
        .build()
    )
    assert built == scene


def test_a_formula_of_numbers_only_is_a_number() -> None:
    scene = scene_from_toml(SCENE.replace('mass = "m"', 'mass = "2*pi/4"'))
    assert type(scene.bodies["bar"].mass) is float
    assert scene.bodies["bar"].mass == pytest.approx(1.5707963267948966)


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ('"L/2"', '"L/2 + k"', r"line 10: bodies\.bar\.center\[0\]: column 7: unknown name 'k'"),
        ('"L/2"', '"L*t"', r"center\[0\]: column 3: depends on the time; .* parameters only"),
        ('"L/2"', '"sqrt(L)*t"', r"center\[0\]: column 9: depends on the time"),
        ('"L/2"', '"L +"', r"center\[0\]: column 4: the formula ends where"),
        ('"L/2"', '"1/(L-150)"', r"center\[0\]: .*has no finite value"),
        ('"L/2"', '"L + (1 + 1e-40)^1e49"', r"center\[0\]: .*has no finite value"),
        ('mass = "m"', 'mass = "-m"', r"line 9: bodies\.bar\.mass: .*positive"),
        (
            'yy = "m*L^2/12"',
            'yy = "3*m*L^2/12"',
            r"bodies\.bar\.inertia: no body has these moments",
        ),
        ("position = [0, 0, 0]", 'position = ["L", 0, 0]', r"position\[0\]: .*write the number"),
        ("unit =", "divisions = 7\nunit =", r"divisions"),
    ],
)
def test_formulas_are_checked_with_line_and_key(old: str, new: str, wanted: str) -> None:
    with pytest.raises(SceneError, match=wanted):
        scene_from_toml(SCENE.replace(old, new, 1))


def test_a_parameter_that_is_wrong_is_one_problem() -> None:
    with pytest.raises(SceneError) as caught:
        scene_from_toml(SCENE.replace("L = 150", "L = nan"))
    assert [problem.key for problem in caught.value.problems] == ["parameters.L"]


def test_many_wrong_formulas_end_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []

    def parse(text: str, names: Collection[str]) -> Expression:
        read.append(text)
        return parse_expression(text, names)

    monkeypatch.setattr(design_numbers, "parse_expression", parse)
    points = ", ".join(f'{{ mass = "k{k}", at = [0, 0, 0] }}' for k in range(MOST_FOUND + 50))
    with pytest.raises(SceneError, match="at least"):
        scene_from_toml(SCENE.replace("center =", f"mass_points = [{points}]\ncenter ="))
    assert [text for text in read if not text.startswith("k")] == ["m", "L/2", "m*L^2/12"]
    assert len(read) == 3 + MOST_FOUND


def test_a_coordinate_is_no_parameter() -> None:
    text = (
        SCENE.replace('mass = "m"', 'mass = "m + turn"') + '[coordinates.turn]\njoint = "hinge"\n'
    )
    with pytest.raises(SceneError, match="column 5: depends on turn, which moves"):
        scene_from_toml(text)


def test_a_parameter_that_stands_in_a_number_only_is_used() -> None:
    other = SCENE.replace('"L/2"', "1").replace("m*L^2/12", "m*900")
    known = [dict(system_of(scene_from_toml(text)).parameters) for text in (SCENE, other)]
    assert [("m" in one, "L" in one) for one in known] == [(True, True), (True, False)]


def test_a_system_varies_where_its_formulas_reach_and_nowhere_else() -> None:
    system = system_of(scene_from_toml(SCENE))
    (bar,) = system.bodies
    assert is_varying(bar.mass)
    assert [is_varying(x) for x in bar.inertia] == [False, True, True]
    assert [is_varying(x) for x in bar.origin_b] == [True, False, False]
    assert not is_varying((*bar.r, *bar.p, *bar.v, *bar.omega_b, *bar.axes_b))
    numbers = system_of(with_numbers(scene_from_toml(SCENE)))
    assert fixed_system(system).bodies == numbers.bodies
    assert fixed_system(system).constraints == numbers.constraints
    assert fixed_system(system).positive == numbers.positive == ()
    assert fixed_system(numbers) is numbers


def test_parameters_that_turn_principal_axes_in_space_are_refused() -> None:
    first = '{ mass = 1, ends = [[0, 0, 0], ["L", 1, 2]] }'
    other = '{ mass = 1, ends = [[0, 3, 0], [1, 0, "L"]] }'
    mass = SCENE[SCENE.index('mass = "m"') : SCENE.index("[joints")]
    text = SCENE.replace(mass, f"rods = [{first}, {other}]\n")
    with pytest.raises(SceneError, match=r"bodies\.bar: has principal axes that parameters turn"):
        system_of(scene_from_toml(text.replace("m = 2.0\n", "")))


def test_the_schema_says_where_a_formula_may_stand() -> None:
    path = Path(__file__).parents[3] / "model" / "scene.schema.json"
    records = json.loads(path.read_text(encoding="utf-8"))["$defs"]
    mass = records["Body"]["properties"]["mass"]["anyOf"]
    assert {"type": "string"} in mass
    assert {"maximum": 1e50, "type": "number", "exclusiveMinimum": 0} in mass
    body = records["Body"]["properties"]
    assert [body[key]["$ref"] for key in ("position", "center")] == [
        "#/$defs/vector",
        "#/$defs/place",
    ]
    assert "anyOf" in records["formula"]
    assert "anyOf" not in records["number"]
