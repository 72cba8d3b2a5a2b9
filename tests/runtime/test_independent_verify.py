"""What is composed wrongly, and generated anew with its own references, is refused by `verify`.

Each fault is planted in the composition, the operations, the simplification or the integrator, then
the scene is generated. Its references follow the fault; each body's own equations do not.
"""

from __future__ import annotations

import gzip
import inspect
import json
import math
import sys
import textwrap
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from typer.testing import CliRunner

from kousoku.cli.app import app
from kousoku.codegen.dynamics.checking import reference, root_functions
from kousoku.codegen.dynamics.composition import (
    combinations,
    compose,
    energies,
    momentum,
    record_coordinates,
    record_forces,
    switching,
)
from kousoku.codegen.dynamics.elements import along as elements_along
from kousoku.codegen.dynamics.elements import coordinate_spring, load, spring_damper
from kousoku.codegen.dynamics.emission import emit
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.operations import (
    applied_forces,
    coordinates,
    elimination,
    mechanics,
)
from kousoku.codegen.dynamics.operations import joint_projections as joint_operations
from kousoku.codegen.dynamics.recording import recorder
from kousoku.codegen.emit import MESSAGES, runtime_sources
from kousoku.codegen.generate import write_tree
from kousoku.model.expressions import enclosure, linear_sums
from kousoku.model.reading.read import read_scene, scene_from_dict, scene_from_toml
from kousoku.runtime import dynamics_verify, verify
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.function_bounds import DISTANCES
from kousoku.runtime.integrate import dense_output, methods
from kousoku.runtime.order import (
    shown_order_problems,
    table_problems,
    trees,
    wrong_conditions,
    wrong_inside,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.model.records.scene import Scene

SCENES = Path(__file__).parents[2] / "scenes"
WANTED = ("accelerations", "coordinates", "reactions", "energies")
pytestmark = pytest.mark.usefixtures("warm_cache")

RICH = """
name = "rich"
unit = "m"
gravity = [1, 2, -9.81]
parameters = { k = 40 }

[bodies.top]
position = [0, 0, 0]
mass = 3
center = [0.1, 0.5, 0.2]
inertia = { xx = 0.2, yy = 0.3, zz = 0.45 }

[bodies.arm]
position = [0, 1, 0]
mass = 2
center = [0.3, 0, 0.1]
inertia = { xx = 0.1, yy = 0.25, zz = 0.2 }

[bodies.wheel]
position = [3, 0, 0]
mass = 4
center = [0.2, 0, 0]
inertia = { xx = 0.3, yy = 0.35, zz = 0.4 }

[joints]
tip = { type = "spherical", bodies = ["ground", "top"], at = [0, 0, 0] }
elbow = { type = "revolute", bodies = ["top", "arm"], at = [0, 1, 0], axis = [1, 1, 0] }
axle = { type = "revolute", bodies = ["ground", "wheel"], at = [3, 0, 0], axis = [0, 0, 1] }

[coordinates]
bend = { joint = "elbow" }
reach = { bodies = ["ground", "arm"], points = [[1, 2, 2], [0.3, 0, 0.2]] }

[drivers]
motor = { joint = "axle", value = "2*t + 0.5*t^2" }

[forces]
pull = { type = "along", coordinate = "bend", force = "5*cos(bend) - 0.3*bend_dot" }
push = { type = "force", body = "arm", point = [0.4, 0.2, 0.1], force = [7, "3*sin(2*t)", 2] }
blow = { type = "force", body = "top", point = [0, 0.3, 0.2], force_b = [1, -2, 6] }
twist = { type = "torque", body = "top", torque = [2, 3, -4] }
screw = { type = "torque", body = "arm", torque_b = [3, -1, 2] }

[forces.line]
type = "spring_damper"
bodies = ["ground", "arm"]
points = [[2, 2, 1], [0.2, 0.1, 0]]
stiffness = 30
damping = 4
free_length = 0.5

[forces.law]
type = "spring_damper"
bodies = ["ground", "top"]
points = [[-2, 1, 0], [0, 0.4, 0.1]]
tension = "20*x^3 + 2*v"

[forces.hinge]
type = "rotational_spring_damper"
joint = "elbow"
stiffness = "k"
damping = 3
free_angle = 0.4
"""

WALL = """
name = "wall"
unit = "mm"

[bodies]
cart = { position = [0, 0, 0], velocity = [10, 0, 0], boxes = [{ mass = 1, size = [2, 2, 2] }] }

[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }

[coordinates]
x = { joint = "rail" }

[forces]
wall = { type = "along", coordinate = "x", force = "-1e6*max(0, x - 49.9)*max(0, 50.1 - x)" }
"""

#: A cart that a spring draws while it is as long as a law says.
DRAWN = """
name = "drawn"
unit = "mm"
[bodies]
cart = { position = [0, 0, 0], velocity = [10, 0, 0], boxes = [{ mass = 1, size = [2, 2, 2] }] }
[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }
[forces.spring]
type = "spring_damper"
bodies = ["ground", "cart"]
points = [[-1, 0, 0], [0, 0, 0]]
tension = "2 - 1e5*max(0, 1 - abs(x - 1.6)*1e4)"
"""

OF_LOAD = "forces = (*zeros, *(orientation.T @ vector).flat)"
#: A cart with every sort of function that a run watches.
WATCHED = """
name = "watched"
unit = "m"
parameters = { w = 0.5 }
[bodies.cart]
position = [0, 0, 0]
velocity = [1, 0, 0]
boxes = [{ mass = 1, size = [0.2, 0.2, 0.2] }]
[bodies.led]
position = [0, 1, 0]
boxes = [{ mass = 1, size = [0.2, 0.2, 0.2] }]
[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }
slide = { type = "prismatic", bodies = ["ground", "led"], at = [0, 1, 0], axis = [1, 0, 0] }
[coordinates]
x = { joint = "rail" }
y = { joint = "slide" }
[drivers]
motor = { coordinate = "y", value = "sqrt(1 + t^2) + sin(3*t)" }
[forces]
push = { type = "along", coordinate = "x", force = "max(0, t - w)*exp(-(t/w)^2)" }
wall = { type = "along", coordinate = "x", force = "-max(0, x*x_dot - w) - sign(x_dot^2 - x)" }
pole = { type = "along", coordinate = "x", force = "1/(x - w) + 1/(x + w)^2 + sin(x*x_dot)" }
near = { type = "along", coordinate = "x", force = "-w*x/sqrt((x - w*t)^2 + x_dot^2)" }
[forces.rope]
type = "spring_damper"
bodies = ["ground", "cart"]
points = [[0.2, 0, 0], [0, 0, 0]]
stiffness = 2
[events]
there = { when = "x_dot*sin(x) - w/(1 + x^2)", action = "record" }
"""
#: What is wrong, by name: the scene, and where: a module or class, its function, what stands there,
#: and what is written instead.
FAULTS: dict[str, tuple[str, Any, str, str, str]] = {
    # the two of these that everybody thinks of first
    "gyroscopic sign": (
        *("rich", mechanics.FreeAcceleration, "__call__"),
        *("mul(ratios[k],", "mul(trace.graph.neg(ratios[k]),"),
    ),
    "kinetic energy doubled": (
        *("rich", energies, "record_energies"),
        *("[mass / 2] * 3 + [number(x) / 2", "[mass] * 3 + [number(x)"),
    ),
    # bodies
    "order of inertia": (
        *("rich", compose, "gyroscopic_ratios"),
        *("moments[(k + 2) % 3]", "moments[(k + 3) % 3]"),
    ),
    "sign of gravity": (
        *("rich", mechanics.FreeAcceleration, "__call__"),
        *("(*gravity, *spin)", "(*map(trace.graph.neg, gravity), *spin)"),
    ),
    "kinetic energy without turning": (
        *("rich", mechanics.Energy, "__call__"),
        *("(*v, *omega), strict=True", "v, strict=False"),
    ),
    "sign of potential energy": (
        *("rich", record_forces.ForceRecorder, "weight"),
        *("[-mass *", "[mass *"),
    ),
    "rates of Euler parameters": (
        *("rich", mechanics, "orientation_of"),
        *("Matrix.of(trace.graph, nodes, 3)", "Matrix.of(trace.graph, nodes, 3).T"),
    ),
    # loads
    "frame of a torque": ("rich", load.LoadEffect, "__call__", OF_LOAD, OF_LOAD.replace(".T", "")),
    "frame of a torque in the body": (
        *("rich", load.LoadEffect, "__call__"),
        *("forces = (*zeros, *vector.flat)", "forces = (*zeros, *(orientation @ vector).flat)"),
    ),
    "frame of a force in the body": (
        *("rich", load.LoadEffect, "__call__"),
        *("*(orientation @ vector).flat, *torque", "*vector.flat, *torque"),
    ),
    "force without its torque": (
        *("rich", applied_forces, "at_point"),
        *('*resultant["N_b"]', "*zeros[:3]"),
    ),
    "power of a force": (
        *("rich", load.LoadEffect, "__call__"),
        *("(*v.flat, *omega.flat)", "(*v.flat, *map(trace.graph.neg, omega.flat))"),
    ),
    "second formula of a force left out": (
        *("rich", load.LoadEffect, "__call__"),
        *("sum(constants[1:], constants[0])", "constants[0]"),
    ),
    # springs
    "law of a spring": (
        *("rich", spring_damper.SpringEffect, "_tension"),
        *('length["l"] - free', 'length["l"] + free'),
    ),
    "tension of a spring": (
        *("rich", spring_damper.SpringEffect, "__call__"),
        *('length | law)["T"]', 'length | law)["V"]'),
    ),
    "power of a damper": (
        *("rich", spring_damper.SpringEffect, "__call__"),
        *("return *effect, -(damped", "return *effect, (damped"),
    ),
    "energy of a spring": (
        *("rich", spring_damper.SpringEnergy, "__call__"),
        *('["V"].flat', '["T"].flat'),
    ),
    "sign of a rotational spring": (
        *("rich", coordinate_spring.CoordinateSpringEffect, "__call__"),
        *("(value - free) + damped", "(value + free) + damped"),
    ),
    "damping of a rotational spring": (
        *("rich", coordinate_spring.CoordinateSpringEffect, "__call__"),
        *("damped = damping @ rate", "damped = damping @ rate + damping @ rate"),
    ),
    "energy of a rotational spring": (
        *("rich", coordinate_spring.CoordinateSpringEnergy, "__call__"),
        *("graph.const(2)", "graph.const(1)"),
    ),
    "one side of a force along a coordinate": (
        *("rich", elements_along.AlongEffect, "__call__"),
        *("left.scaled(inverse_mass_i).T @ tau", "-(left.scaled(inverse_mass_i).T @ tau)"),
    ),
    # coordinates
    "second derivative of a coordinate": (
        *("rich", record_coordinates.CoordinateRecorder, "show"),
        *("self.gamma(index), into", "None, into"),
    ),
    "curvature of a coordinate": (
        *("rich", coordinates.CoordinateGamma, "__call__"),
        *('[outputs["gamma"][0]]', '[trace.graph.neg(outputs["gamma"][0])]'),
    ),
    # joints
    "gamma of joints": (
        *("rich", mechanics.Rates, "__call__"),
        *("(total - stack(", "(total + stack("),
    ),
    "Jacobian of body j": (
        *("rich", mechanics, "_by_body"),
        *("side * COLUMNS + k", "k"),
    ),
    "coupling of joints": (
        *("four_bar", elimination, "_updated"),
        *("graph.sub(", "graph.add("),
    ),
    "backward substitution": (
        *("rich", elimination.Backward, "__call__"),
        *("graph.sub(total", "graph.add(total"),
    ),
    "reaction of a joint with the ground": (
        *("rich", joint_operations.JointWrench, "__call__"),
        *(".T - others", ".T + others"),
    ),
    "arm of a joint with the ground": (
        *("rich", joint_operations.BiasAcceleration, "__call__"),
        *("point.cross(omega)", "omega.cross(point)"),
    ),
    "body of a reaction": (
        *("rich", compose._ProgramComposer, "_by_body"),
        *("region.part(blocks.v, len(blocks.columns))", "region.part(0, len(blocks.columns))"),
    ),
    # drivers
    "effort of a driver": (
        *("rich", joint_operations.DriverPower, "__call__"),
        *("(second - free)", "(second + free)"),
    ),
    "acceleration of a driver": (
        *("rich", combinations.Combinations, "rate"),
        *("self.law(instance, 2)", "self.law(instance, 1)"),
    ),
    "factor of a combination": (
        *("gears", combinations.Combinations, "_weighted"),
        *("constant((term.factor,))", "constant((abs(term.factor),))"),
    ),
    # momenta
    "linear momentum": (
        *("free", momentum.BodyMomentum, "__call__"),
        *("momentum, arm = v @ mass", "momentum, arm = (v + v) @ mass"),
    ),
    "spin in the angular momentum": (
        *("free", momentum.BodyMomentum, "__call__"),
        *("orientation @ spin_b", "spin_b"),
    ),
    # what steps are made of, beside accelerations
    "shift of a body onto its joints": (
        *("four_bar", mechanics.Move, "__call__"),
        *("(r + dr)", "(r - dr)"),
    ),
    "turn of a body onto its joints": (
        *("four_bar", mechanics.Move, "__call__"),
        *("p + euler_rates(trace, p, dtheta)", "p - euler_rates(trace, p, dtheta)"),
    ),
    "value and rate of what a formula reads": (
        *("wall", switching, "record_switching"),
        *("region.part(2 * k, 1), region.part(2 * k + 1, 1)",),
        *("region.part(2 * k + 1, 1), region.part(2 * k, 1)",),
    ),
    "value and rate of what distances are of": (
        *("watched", switching.Valued, "__call__"),
        *("((measure.name, measure.rate) for", "((measure.rate, measure.name) for"),
    ),
    "lengths in place of distances": (
        *("watched", switching, "record_switching"),
        *('"distances": functions.distances', '"distances": functions.lengths'),
    ),
    "a distance too few": (
        *("watched", switching, "record_switching"),
        *('"distances": functions.distances', '"distances": ()'),
    ),
    "length and rate of a spring": (
        *("drawn", spring_damper.SpringLength, "__call__"),
        *('return length["l"], length["l_dot"]', 'return length["l_dot"], length["l"]'),
    ),
    # bounds of functions
    "a crossing too few": (
        *("watched", switching, "record_switching"),
        *('"crossings": functions.crossings', '"crossings": functions.crossings[:-1]'),
    ),
    "no crossings": (
        *("watched", switching, "record_switching"),
        *('"crossings": functions.crossings', '"crossings": ()'),
    ),
    "value in place of a rate": (
        *("watched", switching.Enclosed, "_bounds"),
        *("without_overflow(_rate(substituted, rates))", "substituted"),
    ),
    "rate of what a formula reads": (
        *("watched", switching.Enclosed, "_bounds"),
        *("rates[measure.name] = symbol(measure.rate)", "rates[measure.name] = ONE"),
    ),
    "second derivative in a rate": (
        *("watched", switching.Enclosed, "_bounds"),
        *('f"{measure.rate}{SECOND}"', "measure.rate"),
    ),
    "motion that both share": (
        *("watched", linear_sums, "_bounds"),
        *("reach = add(mul(HALF, apply(Op.ABS, slope), h), spread)", "reach = spread"),
    ),
    "what leaves it": (
        *("watched", linear_sums, "_bounds"),
        *("off = add(", "off = mul(HALF, "),
    ),
    "least and most of what is read": (
        *("watched", switching.Enclosed, "__call__"),
        *("for end in (LEAST, MOST)", "for end in (MOST, LEAST)"),
    ),
    "order of functions": (
        *("watched", switching, "record_switching"),
        *('"crossings": functions.crossings', '"crossings": functions.crossings[::-1]'),
    ),
    "bounds of a product": (
        *("watched", enclosure, "product_of"),
        *("Bounds(_least(*products), _most(*products))", "Bounds(products[0], products[-1])"),
    ),
    "bounds of a quotient": (
        *("watched", enclosure, "_reciprocal"),
        *("_most(x.least, neg(x.most), ZERO)", "_most(x.least, neg(x.most))"),
    ),
    "bounds of a sine": (
        *("watched", enclosure, "_wave"),
        *("add(mul(slope, r), div(mul(r, r), number(2)))", "mul(slope, r)"),
    ),
}
#: One of each part; the others are tried for a release.
ALWAYS = {
    *("gyroscopic sign", "kinetic energy doubled", "sign of potential energy"),
    *("frame of a force in the body", "law of a spring", "sign of a rotational spring"),
    *("second derivative of a coordinate", "gamma of joints", "coupling of joints"),
    *("reaction of a joint with the ground", "effort of a driver", "factor of a combination"),
    *("linear momentum", "shift of a body onto its joints"),
    *("value and rate of what a formula reads", "value in place of a rate"),
}
#: What a scene's faults are told by.
TOLD_BY = {"watched": "bounds"}


def scene_named(name: str) -> Scene:
    texts = {"rich": RICH, "wall": WALL, "watched": WATCHED, "drawn": DRAWN}
    if name in texts:
        return scene_from_toml(texts[name])
    file = {"free": "free_body", "gears": "gear_train", "four_bar": "lever_crank_bodies"}[name]
    return read_scene(SCENES / f"{file}.toml")


def wanted_of(scene: Scene) -> tuple[str, ...]:
    return tuple(x for x in WANTED if x != "coordinates" or scene.coordinates)


def plant(patch: pytest.MonkeyPatch, owner: Any, name: str, old: str, new: str) -> None:
    """Write a function of a module or class anew with something else in one place."""
    was = getattr(owner, name)
    source = textwrap.dedent(inspect.getsource(was))
    assert source.count(old) >= 1, (owner, name, old)
    module = sys.modules[was.__module__]
    found = dict(vars(module))
    exec(f"from __future__ import annotations\n{source.replace(old, new)}", found)
    patch.setattr(owner, name, found[name])
    if inspect.ismodule(owner) and owner is not module:
        return
    if inspect.ismodule(owner):  # where it was imported by its name
        for other in [*sys.modules.values()]:
            is_ours = getattr(other, "__name__", "").startswith("kousoku.codegen")
            if is_ours and vars(other).get(name) is was:
                patch.setattr(other, name, found[name])


@pytest.fixture
def no_old_traces(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Trace operations anew, with the fault and then without; leave states of the program out."""
    monkeypatch.setattr(reference, "_states", lambda *_: [])
    recorder._traced_kernel.cache_clear()
    yield
    recorder._traced_kernel.cache_clear()


def verified(folder: Path) -> tuple[int, str]:
    found = CliRunner().invoke(app, ["verify", str(folder), "--target", "numpy"])
    return found.exit_code, found.output


@pytest.mark.usefixtures("no_old_traces")
@pytest.mark.parametrize("name", ["rich", "free", "gears", "four_bar", "watched", "drawn"])
def test_what_is_right_is_verified(tmp_path: Path, name: str) -> None:
    scene = scene_named(name)
    write_tree(tmp_path / "right", generate_dynamics(scene, wanted_of(scene), references=True))
    report = verify(tmp_path / "right", target="numpy")

    assert report.problems == ()
    outputs = {row.output for row in report.rows if row.kernel == "newton_euler"}
    assert {"acceleration", "angular_acceleration", "energy", "C", "C_ddot", "dv"} <= outputs
    if name == "rich":
        assert {"force", "moment", "power", "coordinate_acceleration"} <= outputs
    bounds = {row.output for row in report.rows if row.kernel == "bounds"}
    if name == "watched":
        regions = {*root_functions.REGIONS} - {"gaps"}  # of drivers of distances
        assert bounds == regions | {f"{region} in a box" for region in regions - {*DISTANCES}}


@pytest.mark.usefixtures("no_old_traces")
@pytest.mark.parametrize(
    "fault",
    [x if x in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in FAULTS],
)
def test_a_fault_in_the_composition_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    name, owner, function, old, new = FAULTS[fault]
    monkeypatch.setattr(dynamics_verify, "table_problems", lambda *_: [])
    scene = scene_named(name)
    plant(monkeypatch, owner, function, old, new)
    write_tree(tmp_path / "wrong", generate_dynamics(scene, wanted_of(scene), references=True))

    code, output = verified(tmp_path / "wrong")
    assert code == 1
    assert f"WRONG: {TOLD_BY.get(name, 'newton_euler')}:" in output


@pytest.mark.parametrize(
    "law",
    ["1/(cos(x) - 1)", "1/(sin(3*x)*sin(3*x_dot) - 1)", "x^0.3*sign(x_dot)", "sign(w - 0.1)*x"],
)
def test_bounds_at_the_ends_of_domains_are_verified(tmp_path: Path, law: str) -> None:
    text = WATCHED.replace("w = 0.5", "w = 0.1").replace("1/(x - w) + 1/(x + w)^2", law)
    text = text.partition("[events]")[0]
    write_tree(tmp_path / "ends", generate_dynamics(scene_from_toml(text), references=True))
    report = verify(tmp_path / "ends", target="numpy")
    assert not [problem for problem in report.problems if problem.startswith("bounds")]
    assert any(row.output == "crossings in a box" for row in report.rows)


#: A block on a mount that is relaxed: what its forces and energies are, is rounding of its place.
RELAXED = """
name = "relaxed"
unit = "dm"
outputs = ["energies"]
[bodies.block]
position = [1.25, -5, -7.5]
mass = 1.71875
inertia = { xx = 143.75, yy = 179.6875, zz = 107.8125, xy = 14.375, yz = -28.75, zx = 7.1875 }
[forces.mount]
type = "bushing"
bodies = ["ground", "block"]
at = [1.25, -5, -7.5]
stiffness = [30, 30, 30, 100, 200, 300]
"""


def test_rounding_in_a_relaxed_spring_is_no_error(tmp_path: Path) -> None:
    write_tree(tmp_path / "relaxed", generate_dynamics(scene_from_toml(RELAXED), references=True))
    report = verify(tmp_path / "relaxed", target="numpy")
    assert report.problems == ()
    assert {"energy", "angular_acceleration"} <= {
        row.output for row in report.rows if row.kernel == "newton_euler"
    }


#: Moments of which one parameter leads those of one body or of the other beyond the triangle rule.
NEARLY_FLAT = """
name = "nearly_flat"
unit = "m"
parameters = { c = 1.999 }
[bodies]
one = { position = [0, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = "c" } }
other = { position = [1, 0, 0], mass = 1, inertia = { xx = "c", yy = 1, zz = 2.998 } }
"""


def test_other_parameters_of_references_are_possible(tmp_path: Path) -> None:
    write_tree(tmp_path / "flat", generate_dynamics(scene_from_toml(NEARLY_FLAT), references=True))
    report = verify(tmp_path / "flat", target="numpy")
    assert report.problems == ()
    data = json.loads(gzip.decompress((tmp_path / "flat" / "reference.json.gz").read_bytes()))
    assert data["points"][-1]["label"] == "near the start, other parameters"


#: A number of ``dop853`` as it is printed, and a wrong one: of a stage, of the end of a step, of a
#: stage for dense output, of an estimate, and of the polynomial.
COEFFICIENTS = {
    "a stage": ("-43.48988418106996", "-43.48988418206996"),
    "the end": ("0.04471061572777259", "0.04471061572877259"),
    "a stage inside": ("2.9475147891527724", "2.9475147791527724"),
    "a node": ("0.6512820512820513", "0.6512820512920513"),
    "an estimate": ("-0.4957589496572502", "-0.4957589486572502"),
    "dense output": ("387.0373087493518", "387.0373088493518"),
}


def changed(method: methods.RungeKuttaMethod, old: float, new: float) -> methods.RungeKuttaMethod:
    """Method with one number in place of another."""

    def with_new(table: Any) -> Any:
        if isinstance(table, tuple):
            return tuple(map(with_new, table))
        return new if table == old else -new if table == -old else table

    tables = {name: with_new(getattr(method, name)) for name in ("c", "a", "errors", "dense")}
    return replace(method, **tables)


@pytest.mark.usefixtures("no_old_traces")
@pytest.mark.parametrize("where", COEFFICIENTS)
def test_a_changed_coefficient_in_all_files_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    old, new = COEFFICIENTS[where]
    wrong = changed(methods.DOP853, float(old), float(new))
    assert wrong != methods.DOP853
    integrator = runtime_sources("integrate", MESSAGES)
    text = integrator["integrate/methods.py"]
    assert old in text
    integrator["integrate/methods.py"] = text.replace(old, new)
    monkeypatch.setattr(emit, "METHODS", (methods.DOPRI5, wrong))
    monkeypatch.setattr(emit, "runtime_sources", lambda *_: integrator)
    scene = read_scene(SCENES / "pendulum.toml")
    write_tree(tmp_path / "wrong", generate_dynamics(scene, references=True))

    code, output = verified(tmp_path / "wrong")
    assert code == 1
    assert "WRONG: dop853:" in output


def test_tables_that_c_and_python_do_not_share_are_refused(tmp_path: Path) -> None:
    tree = generate_dynamics(read_scene(SCENES / "pendulum.toml"), references=True)
    header = tree["integrate/methods.h"]
    tree["integrate/methods.h"] = header.replace("387.0373087493518", "387.0373087493517")
    assert tree["integrate/methods.h"] != header
    files = {name: text.encode() for name, text in tree.items()}
    (problem,) = table_problems(tmp_path, files)
    assert "dop853: integrate/methods.h has other numbers" in problem


def test_there_are_as_many_trees_as_conditions() -> None:
    assert [len(trees(n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@pytest.mark.parametrize("method", methods.METHODS, ids=lambda one: one.name)
def test_each_coefficient_matters(method: methods.RungeKuttaMethod) -> None:
    assert not [*wrong_conditions(method), *wrong_inside(method, dense_output)]
    numbers = [method.c, *method.a, *method.errors, *method.dense]
    for number in islice({x for row in numbers for x in row if x not in {0.0, 1.0}}, 0, None, 9):
        wrong = changed(method, number, number * (1 + 1e-9))
        assert [*wrong_conditions(wrong), *wrong_inside(wrong, dense_output)], number


@pytest.mark.usefixtures("compiler")
def test_halved_steps_show_the_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A table that is wrong shows in the motion, too."""
    scene = read_scene(SCENES / "pendulum.toml")
    wrong = changed(methods.DOP853, 4.450312892752409, 4.4503)
    for name, used in (("right", methods.DOP853), ("wrong", wrong)):
        monkeypatch.setattr(emit, "METHODS", (methods.DOPRI5, used))
        write_tree(tmp_path / name, generate_dynamics(scene))
        solver = load_dynamics(tmp_path / name, target="c")
        problems = [*shown_order_problems(solver, methods.METHODS)]
        assert [problem.partition(":")[0] for problem in problems] == (
            ["solver, dop853"] if name == "wrong" else []
        )


@pytest.mark.usefixtures("compiler")
def test_what_stands_upright_shows_no_order(bodies_folder: Callable[..., Path]) -> None:
    """Rounding grows there, and halved steps make nothing of it smaller."""
    turned = {"axis": [0.0, 0.0, 1.0], "angle": math.pi / 2}
    moments = dict.fromkeys(("xx", "yy", "zz"), 0.1)
    bar = {"mass": 1.0, "center": [0.5, 0.0, 0.0], "inertia": moments}
    pins = {
        "a": (("ground", "crank"), [0, 0, 0]),
        "b": (("crank", "coupler"), [0, 1, 0]),
        "c": (("coupler", "rocker"), [2, 1, 0]),
        "d": (("rocker", "ground"), [2, 0, 0]),
    }
    scene = {
        "name": "upright",
        "unit": "m",
        "gravity": [0, -9.81, 0],
        "bodies": {
            "crank": {"position": [0, 0, 0], "orientation": turned, **bar},
            "coupler": {"position": [0, 1, 0], **bar, "center": [1.0, 0.0, 0.0]},
            "rocker": {"position": [2, 0, 0], "orientation": turned, **bar},
        },
        "joints": {
            name: {"type": "revolute", "bodies": [*bodies], "at": at, "axis": [0, 0, 1]}
            for name, (bodies, at) in pins.items()
        },
    }
    solver = load_dynamics(bodies_folder(scene_from_dict(scene), ()), target="c")
    assert not [*shown_order_problems(solver, methods.METHODS)]
