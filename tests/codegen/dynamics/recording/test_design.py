"""Numbers that depend on parameters in a program: computed once, where there are some."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.lump import lump
from kousoku.model.errors import SceneError
from kousoku.model.expressions.design_numbers import with_numbers
from kousoku.model.lowering.held import require_kept
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers.varying import is_varying
from kousoku.model.reading.read import scene_from_toml
from tests.analysed import all_rows

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System

FOLDER = Path(__file__).parents[3] / "scenes" / "design"
SCENES = {path.stem: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.toml"))}
FOUR_BAR, PENDULUM = (SCENES[name] for name in ("four_bar", "pendulum"))
WANTED = ("checks", "energies", "reactions")
TWO = """
name = "two"
unit = "m"
gravity = [0, 0, -9.81]
[parameters]
m = 2.0
s = 0.0
[bodies.arm]
position = [0, 0, 0]
boxes = [{ mass = "m", size = [1, 0.1, 0.1], at = [0.5, 0, 0] }]
[bodies.bob]
position = [1, 0, 0]
spheres = [{ mass = 3, radius = 0.1 }]
[joints.hinge]
type = "revolute"
bodies = ["ground", "arm"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.weld]
type = "fixed"
bodies = ["arm", "bob"]
points = [[1, 0, 0], ["s", 0, 0]]
"""


def system(text: str) -> System:
    return system_of(scene_from_toml(text))


def test_a_program_without_such_numbers_has_no_setup() -> None:
    program = compose(all_rows(system_of(with_numbers(scene_from_toml(FOUR_BAR)))), WANTED)
    assert not program.design
    assert "setup" not in [one.name for one in program.on_demand]
    assert "design" not in [region.name for region in program.regions]


def test_numbers_of_the_design_are_computed_once_and_cost_a_step_little() -> None:
    varying, fixed = (
        compose(all_rows(one), WANTED)
        for one in (
            system(FOUR_BAR),
            system_of(with_numbers(scene_from_toml(FOUR_BAR))),
        )
    )
    assert varying.is_planar
    assert varying.design.names == ("a", "b", "c", "g", "rho")
    assert operations(varying) == operations(fixed)
    assert [one.name for one in varying.on_demand].count("setup") == 1
    assert varying.region("design").size == len(dict(varying.design.places))


@pytest.mark.parametrize("make", [lambda x: x, inline])
def test_the_workspace_has_the_numbers_of_its_parameters(make: object) -> None:
    assert callable(make)
    program = make(compose(all_rows(system(PENDULUM)), WANTED))
    work = ProgramInterpreter(program)
    places = dict(program.design.places)
    keys = dict(program.design.positive)
    assert work["design"][places[keys["bodies.bar.mass"]]] == 2.0
    work["parameters"] = [3.0, 80.0]
    work.run("setup")
    assert work["design"][places[keys["bodies.bar.mass"]]] == 3.0
    assert work["design"][places[keys["bodies.bar.inertia"]]] == pytest.approx(3 * 0.8**2 / 12)


def test_a_number_that_is_zero_in_the_scene_is_no_structural_zero() -> None:
    text = PENDULUM.replace('"L/2", 0, 0', '"L/2", 0, "L-150"')
    varying, fixed = (
        compose(all_rows(one), WANTED)
        for one in (system(text), system_of(with_numbers(scene_from_toml(text))))
    )
    assert operations(varying) > operations(fixed)


def test_a_height_that_parameters_change_leaves_the_plane() -> None:
    assert compose(all_rows(system(PENDULUM)), WANTED).is_planar
    assert not compose(
        all_rows(system(PENDULUM.replace('["L/2", 0, 0]', '["L/2", "L/9", 0]'))), ()
    ).is_planar


def test_masses_are_joined_and_points_that_parameters_move_are_not() -> None:
    free = lump(system(TWO))
    assert len(free.system.bodies) == 2
    joined = lump(system(TWO.replace('["s", 0, 0]', "[0, 0, 0]").replace("s = 0.0\n", "")))
    (body,) = joined.system.bodies
    assert is_varying(body.mass)
    assert is_varying(body.origin_b)
    assert float(body.mass) == 5.0


def test_what_is_held_cannot_be_kept_where_parameters_move_it() -> None:
    text = FOUR_BAR.replace("[bodies.crank]\n", '[bodies.crank]\nhold = ["orientation"]\n')
    with pytest.raises(SceneError, match=r"bodies\.crank\.hold: .*parameters of the scene only"):
        generate_dynamics(scene_from_toml(text))
    only_the_centre = PENDULUM.replace(
        "[bodies.bar]\n", '[bodies.bar]\nhold = ["x", "orientation"]\n'
    )
    require_kept(system(only_the_centre))
    with pytest.raises(SceneError, match=r"bodies\.bar\.hold: .*what hinge connects"):
        require_kept(
            system(only_the_centre.replace("[[0, 0, 0], [0, 0, 0]]", '[[0, 0, 0], ["L", 0, 0]]'))
        )


def test_a_joint_between_what_stands_still_is_kept_where_parameters_open_it() -> None:
    weld = 'type = "fixed"\nbodies = ["ground", "arm"]\npoints = [[0, 0, 0], [0, 0, 0]]\n'
    text = TWO[: TWO.index("[joints.hinge]")] + f"[joints.base]\n{weld}"
    text += f"[joints.top]\n{weld.replace('arm', 'bob').replace('[[0,', '[[1,')}"
    text += """[joints.pin]
type = "spherical"
bodies = ["arm", "bob"]
points = [["1 + s", 0, 0], [0, 0, 0]]
"""
    text += "[bodies.loose]\nposition = [5, 0, 0]\nmass = 1\npoint = true\n"
    fixed = text.replace('"1 + s"', "1").replace("s = 0.0\n", "")
    assert [body.name for body in lump(system(fixed)).system.bodies] == ["loose"]
    assert len(lump(system(text)).system.bodies) == 3
