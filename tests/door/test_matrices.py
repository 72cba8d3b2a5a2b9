"""M v̇ + C_qᵀλ = f of scenes as they are written, against what their solvers compute.

Accelerations, forces of joints and energies come from the generated solvers, which have merged,
reduced and left out what they could.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from msgspec.structs import astuple

import kousoku as ks
from kousoku.body_equations import equations_of
from kousoku.codegen.linkage.generate import generate_linkage
from kousoku.model.errors import SolveError
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.body_tables import written_state
from kousoku.runtime.integrate.euler_parameters import composed, crossed, rotated
from kousoku.runtime.linkage import load_linkage
from kousoku.state_matrices import evaluate, matrices
from tests.random_scenes import COUNT, numbered_scenes

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.state_matrices import Evaluation, Matrices

SCENES = Path(__file__).parents[2] / "scenes"
FILES = {path.stem: path for folder in (SCENES, SCENES / "adams") for path in folder.glob("*.toml")}
READ = {name: read_scene(path) for name, path in sorted(FILES.items())}
OF_BODIES = [name for name, scene in READ.items() if scene.is_spatial]
#: Small scenes say nearly all; these are for a release, and so are most random ones.
LARGE = {
    *("andrews_squeezer_a03", "constant_velocity", "engine", "mounted_motor", "n_four_bar"),
    *("oldham_coupling", "piston_crank_bodies"),
}
OF_NODES = [name for name, scene in READ.items() if not scene.is_spatial]
#: A bar on a hinge with a spring that counts turns.
WOUND = """
name = "wound"
unit = "m"
outputs = ["coordinates", "accelerations"]
coordinates = { a = { joint = "h" } }
[bodies.b]
position = [0, 0, 0]
cylinders = [{ mass = 1, radius = 0.1, ends = [[0, 0, 0], [1, 0, 0]] }]
[joints]
h = { type = "hinge", bodies = ["ground", "b"], at = [0, 0, 0], axis = [0, 0, 1] }
[forces]
s = { type = "along", coordinate = "a", force = "-5*a" }
"""
#: Relative to the largest number that a sum is made of.
RESIDUAL_ROUNDING = 1e-9
#: All rows at all of its states, but where these lie in other positions than the rest of the way.
TIMES = (0.0, 0.11, 0.37, 0.5)


def chosen(cases: Iterable[Any], for_a_release: Collection[Any]) -> list[Any]:
    """Cases of a test, some of them marked as those for a release."""
    mark = pytest.mark.release
    return [pytest.param(x, marks=mark) if x in for_a_release else x for x in cases]


def require_equations_hold(found: Matrices, v: Array, v_dot: Array, length: float) -> None:
    """Assert C = 0, C_q v = ν and C_q v̇ = γ."""
    sizes = np.abs(found.C_q)
    speed = 1.0 + float(np.abs(v).max())
    assert np.abs(found.C).max(initial=0.0) < RESIDUAL_ROUNDING * length
    assert (np.abs(found.C_q @ v - found.nu) <= RESIDUAL_ROUNDING * (sizes @ abs(v) + speed)).all()
    bent = sizes @ abs(v_dot) + abs(found.gamma) + speed**2 * max(1.0, length)
    assert (np.abs(found.C_q @ v_dot - found.gamma) <= RESIDUAL_ROUNDING * bent).all()


def require_forces_balance(found: Matrices, told: Evaluation, length: float) -> None:
    """Assert M v̇ + C_qᵀλ = f; torques count as forces on a length of the scene."""
    arms = np.array([1 / length if "theta" in name else 1.0 for name in found.columns])
    parts = [arms * x for x in (found.M @ told.v_dot, found.C_q.T @ told.lam, found.f)]
    size = max(float(np.abs(part).max(initial=0.0)) for part in parts)
    assert np.abs(parts[0] + parts[1] - parts[2]).max(initial=0.0) <= RESIDUAL_ROUNDING * size


@pytest.mark.parametrize("name", chosen(OF_BODIES, LARGE))
def test_the_equations_of_committed_scenes_hold_along_a_motion(
    name: str, bodies_folder: Callable[..., Path], compiler: object
) -> None:
    scene = READ[name]
    has_masses = equations_of(scene).has_masses
    energies = ("energies",) if has_masses else ()
    outputs = tuple(dict.fromkeys((*scene.outputs, "accelerations", *energies)))
    solver = load_dynamics(bodies_folder(scene, outputs), target="c")
    motion = solver.simulate(times=TIMES)
    length = equations_of(scene).length

    for k in range(len(TIMES)):
        t, q, v = motion.state(k)
        found = matrices(scene, t, q, v)
        v_dot = np.concatenate(
            [
                table[body.name][k]
                for body in solver.bodies
                for table in (motion.acceleration, motion.angular_acceleration)
                if body.name in table
            ]
        )
        require_equations_hold(found, v, v_dot, length)
        rows = np.where(np.array(found.units) == "rad", length, 1.0)[:, np.newaxis]
        columns = [1 / length if "theta" in column else 1.0 for column in found.columns]
        scaled = rows * found.C_q * columns
        if found.C.size and name != "bricard":  # its rows depend on others along its branch only
            sizes = np.linalg.svd(scaled[~found.redundant], compute_uv=False)
            assert sizes.min() > 1e-6 * sizes.max()
            assert np.linalg.matrix_rank(scaled, tol=1e-7 * sizes.max()) == len(sizes)
        if not has_masses:
            continue
        told = evaluate(scene, solver, t, q, v)
        size = float(np.abs(v_dot).max() + np.abs(v).max() ** 2)
        assert told.v_dot == pytest.approx(v_dot, rel=1e-9, abs=RESIDUAL_ROUNDING * size)
        require_forces_balance(found, told, length)
        kinetic = motion.energy["kinetic"][k]
        assert v @ found.M @ v / 2 == pytest.approx(kinetic, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("name", ["bricard", "engine", "gear_train", "loop", "revolute_case02"])
def test_multipliers_are_the_forces_of_joints(
    name: str, bodies_folder: Callable[..., Path], compiler: object
) -> None:
    scene = READ[name]
    solver = load_dynamics(bodies_folder(scene, ("accelerations", "reactions")), target="c")
    motion = solver.simulate(times=TIMES)
    compared = 0
    for k in range(len(TIMES)):
        t, q, v = motion.state(k)
        found, told = matrices(scene, t, q, v), evaluate(scene, solver, t, q, v)
        size = float(np.abs(told.lam).max())
        for place in solver.layout.reactions:
            own = [n for n, row in enumerate(found.rows) if row.startswith(f"{place.joint}: ")]
            if place.joint in motion.not_unique or not own or not told.is_unique[own].all():
                continue
            force, torque = _wrench(solver, found, told, place, own, motion, k)
            wanted = [table[place.joint][k] for table in (motion.force, motion.torque)]
            for mine, theirs in zip((force, torque), wanted, strict=True):
                there = np.isfinite(theirs)
                assert mine[there] == pytest.approx(theirs[there], rel=1e-8, abs=1e-8 * size)
            compared += 1
    assert compared == 0 if name == "bricard" else compared > len(TIMES) - 1


def _wrench(
    solver: DynamicsSolver,
    found: Matrices,
    told: Evaluation,
    place: Any,
    rows: list[int],
    motion: Any,
    k: int,
) -> tuple[Array, Array]:
    """Force and torque −C_qᵀλ of some rows on body j of a joint, at its point, frame O."""
    body = solver.bodies[place.body]
    columns = [n for n, name in enumerate(found.columns) if name.rpartition(".")[0] == body.name]
    wrench = -found.C_q[np.ix_(rows, columns)].T @ told.lam[rows]
    r, p = (motion.position[body.name][k], motion.orientation[body.name][k])
    point = np.array(place.point_b)
    if place.j >= 0:
        other = solver.bodies[place.j]
        back = np.array(other.axes_b) * [1, -1, -1, -1]
        inside = rotated(back, point - np.array(other.origin_b)) / solver.unit
        point = motion.position[other.name][k] + rotated(motion.orientation[other.name][k], inside)
    else:
        point = point / solver.unit
    force, torque = wrench[:3], rotated(p, wrench[3:])
    torque = torque + crossed(r - point, force)
    return (force, torque) if place.j >= 0 else (-force, -torque)


@pytest.mark.parametrize("number", chosen(range(0, COUNT, 3), {k for k in range(COUNT) if k % 9}))
def test_the_equations_of_random_scenes_hold_with_any_parameters(
    number: int, bodies_folder: Callable[..., Path]
) -> None:
    scene = scene_from_dict(numbered_scenes()[number])
    folder = bodies_folder(scene, tuple({*scene.outputs, "accelerations"}))
    solver = load_dynamics(folder, target="numpy")
    length = equations_of(scene).length
    changed = {name: value * 1.001 for name, value in solver.parameters}
    for parameters in ({}, changed):
        there = solver.at(parameters)
        q, v = there.q, there.v
        for _ in range(8):
            q = there.evaluate(0.0, q, v, parameters)["q_moved"].copy()
        v = v + there.evaluate(0.0, q, v, parameters)["dv"]
        left = there.evaluate(0.0, q, v, parameters)["C_left_out"]
        if np.abs(left).max(initial=0.0) > 1e-9 * solver.length:
            continue  # only with the parameters of the scene its loops are closed
        state = written_state(there.bodies, q, v, solver.unit)
        found = matrices(scene, 0.0, *state, parameters)
        if found.without:
            continue
        told = evaluate(scene, solver, 0.0, *state, parameters)
        require_equations_hold(found, state[1], told.v_dot, length)
        require_forces_balance(found, told, length)


@pytest.mark.parametrize("name", ["falling_nut", "loop", "lever_crank_bodies", "gear_train"])
def test_jacobian_and_right_hand_sides_are_derivatives_of_the_residuals(
    name: str, rng: np.random.Generator
) -> None:
    """At any state, where C is not zero either: Ċ = C_q v − ν and, with v̇ = 0, C̈ = −γ."""
    scene = READ[name]
    equations = equations_of(scene)
    unit = equations.length
    q = np.concatenate([_start(scene, body) for body in equations.bodies])
    v = rng.normal(size=equations.sizes[1])
    q = _moved(equations, q, 0.1 * unit * rng.normal(size=len(v)))
    v *= np.array([1.0 if "theta" in column else unit for column in equations.columns])
    step, t = 1e-5, 0.2
    here = matrices(scene, t, q, v)
    after, before = (matrices(scene, t + h, _moved(equations, q, h * v), v) for h in (step, -step))
    rate = here.C_q @ v - here.nu
    size = np.abs(here.C_q) @ np.abs(v) + np.abs(here.nu) + np.abs(here.gamma) + 1e-3 * unit
    assert np.abs((after.C - before.C) / (2 * step) - rate).max() < 1e-6 * size.max()
    bent = (after.C_q @ v - after.nu) - (before.C_q @ v - before.nu)
    assert np.abs(bent / (2 * step) + here.gamma).max() < 1e-6 * size.max()


def _start(scene: Scene, body: Any) -> Array:
    given = scene.bodies[body.name]
    return np.array([*given.position, *((1.0, 0, 0, 0) if body.p else ())])


def _moved(equations: Any, q: Array, change: Array) -> Array:
    """Coordinates q after δr and δθ′, which turns about a fixed axis."""
    found = q.copy()
    pairs = (pairwise(equations.starts[k]) for k in (0, 1))
    for body, (first, _), (at, end) in zip(equations.bodies, *pairs, strict=True):
        found[first : first + 3] += change[at : at + 3]
        if body.p:
            turn = change[at + 3 : end]
            angle = np.linalg.norm(turn)
            axis = turn / angle
            p = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
            found[first + 3 : first + 7] = composed(q[first + 3 : first + 7], p)
    return found


@pytest.mark.parametrize("name", OF_NODES)
def test_the_equations_of_linkages_hold_and_they_have_no_masses(
    name: str, shared_tree: Callable[..., Path]
) -> None:
    import msgspec

    scene = msgspec.structs.replace(READ[name], outputs=("velocities", "accelerations"))
    folder = shared_tree(scene.name, ("linkage", astuple(scene)), lambda: generate_linkage(scene))
    found = load_linkage(folder, target="numpy").solve()
    for k in range(0, len(found.residual), 7):
        t, q, v = found.state(k)
        v_dot = np.concatenate([found.accelerations[node][k] for node in scene.nodes])
        there = matrices(scene, t, q, v)
        length = float(np.abs(q).max())
        require_equations_hold(there, v, v_dot, length)
        assert np.linalg.matrix_rank(there.C_q) == len(q) == len(there.C)
    with pytest.raises(SolveError, match="no M and no f: a linkage of nodes has no masses"):
        _, *_ = there
    assert "no masses" in repr(there)


@pytest.mark.parametrize("name", ["pendulum", "piston_crank"])
def test_the_door_takes_the_states_of_its_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: object
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    mechanism = ks.load(FILES[name])
    run = mechanism.simulate(times=[0.0, 0.25])
    t, q, v = run.state(-1)
    found = mechanism.matrices(t, q, v)
    assert t == 0.25
    assert np.abs(found.C).max() < 1e-12
    assert found.C_q @ v == pytest.approx(found.nu, abs=1e-12)
    with pytest.raises(IndexError, match="no row 2: there are 2"):
        run.state(2)
    if name == "pendulum":
        assert mechanism.evaluate(t, q, v).is_unique.all()


BAR = {
    "name": "bar",
    "unit": "cm",
    "gravity": [0, -981, 0],
    "bodies": {
        "bar": {
            "position": [0, 0, 0],
            "mass": 2,
            "center": [30, 0, 0],
            "inertia": {"xx": 5, "yy": 600, "zz": 600},
        }
    },
    "joints": {
        "pin": {"type": "revolute", "bodies": ["ground", "bar"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    },
    "forces": {"spring": {"type": "rotational_spring_damper", "joint": "pin", "stiffness": 7.0}},
}
STATE = [0, 0, 0, 1, 0, 0, 0], [0, 0, 0, 0, 0, 3]


def test_the_matrices_of_a_bar_about_its_end() -> None:
    """M, f and γ by hand: the centre of mass is 30 cm from the origin, ω′ = 3 rad/s."""
    M, C_q, nu, gamma, f = found = matrices(scene_from_dict(BAR), 0.0, *STATE)

    assert found.columns == tuple(
        f"bar.{x}" for x in ("x", "y", "z", "theta_x", "theta_y", "theta_z")
    )
    assert found.rows == (
        "pin: point x",
        "pin: point y",
        "pin: point z",
        "pin: p1 x′",
        "pin: p1 y′",
    )
    assert found.units == ("cm", "cm", "cm", "rad", "rad")
    wanted = np.diag([2, 2, 2, 5, 600 + 1800, 600 + 1800]).astype(float)
    wanted[1, 5] = wanted[5, 1] = 60
    wanted[2, 4] = wanted[4, 2] = -60
    assert pytest.approx(wanted, abs=1e-12) == M
    assert f == pytest.approx([2 * 9 * 30, -2 * 981, 0, 0, 0, -2 * 981 * 30], abs=1e-9)
    assert C_q[:3, :3] == pytest.approx(np.eye(3), abs=1e-15)
    assert not nu.any()
    assert gamma == pytest.approx(np.zeros(5), abs=1e-12)
    assert not found.redundant.any()
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.M, M)
    assert repr(again) == repr(found)
    assert len(repr(found).splitlines()) < 10
    assert "<td>1</td>" in found._repr_html_()


def test_turns_that_positions_do_not_tell_can_be_given() -> None:
    scene = scene_from_dict(BAR)
    (name,) = (one.name for one in equations_of(scene).system.coordinates)
    moments = [
        matrices(scene, 0.0, *STATE, angles={name: turns * 2 * np.pi}).f[5] for turns in (0, 1, -2)
    ]
    assert np.diff(moments) == pytest.approx([-7 * 2 * np.pi, 7 * 6 * np.pi])


def test_rows_that_depend_on_others_are_labelled() -> None:
    scene = READ["n_four_bar"]
    found = matrices(scene, 0.0, *_standing(scene))
    rest = found.C_q[~found.redundant]
    assert found.redundant.sum() == 6
    assert np.linalg.matrix_rank(rest) == len(rest) == np.linalg.matrix_rank(found.C_q)
    assert "redundant: " in repr(found)


def _standing(scene: Scene) -> tuple[Array, Array]:
    equations = equations_of(scene)
    system = equations.system
    q = np.concatenate([[*body.r, *body.p] for body in system.bodies])
    return written_state(equations.bodies, q, np.zeros(equations.sizes[1]), system.unit)


def test_a_scene_with_parameters_has_the_matrices_of_the_scene_with_those_numbers() -> None:
    scene = READ["loop_free"]
    q, v = _standing(scene)
    heavy = matrices(scene, 0.0, q, v, {"mass": 5.0})
    light = matrices(scene, 0.0, q, v)
    ratio = heavy.M[np.nonzero(light.M)] / light.M[np.nonzero(light.M)]
    assert set(ratio.round(9)) == {1.0, round(5 / scene.parameters["mass"], 9)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": [0.0] * 6}, r"bar: q has the shape \(6,\); wanted 7 numbers"),
        ({"v": [np.nan] * 6}, r"bar: v\[0\] is nan; wanted a finite number"),
        ({"q": [0.0] * 7}, "bar: q has no Euler parameters of bar: all four are 0"),
        ({"t": "now"}, "bar: time 'now'; wanted a number"),
        ({"parameters": {"k": 1.0}}, "bar: no parameter 'k': its formulas have none"),
        ({"angles": {"pim": 1.0}}, "bar: no angle 'pim': there are pin.angle"),
    ],
)
def test_what_cannot_be_is_refused(change: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"t": 0.0, "q": STATE[0], "v": STATE[1]} | change
    with pytest.raises(SolveError, match=message):
        matrices(scene_from_dict(BAR), **given)


def test_a_state_that_the_solver_cannot_have_is_refused(
    bodies_folder: Callable[..., Path],
) -> None:
    scene = READ["lever_crank_bodies"]
    solver = load_dynamics(bodies_folder(scene, ("accelerations",)), target="numpy")
    q, v = written_state(solver.bodies, solver.q, solver.v, solver.unit)
    q[2] += 1.0
    with pytest.raises(SolveError, match="is 1 from where the solver can have it: it moves in a"):
        evaluate(scene, solver, 0.0, q, v)


def test_joints_that_a_state_leaves_open_are_told(bodies_folder: Callable[..., Path]) -> None:
    solver = load_dynamics(bodies_folder(READ["loop_free"], ("accelerations",)), target="numpy")
    mechanism = ks.Mechanism(solver, FILES["loop_free"].read_text(encoding="utf-8"))
    q, v = written_state(solver.bodies, solver.q, solver.v, solver.unit)
    q[7] += 1e-5  # less than the closure tolerance
    assert mechanism.evaluate(0.0, q, v).notes == ()
    q[7] += 0.1 - 1e-5  # of the coupler, between the joints b and c
    with pytest.warns(
        UserWarning, match=r"open: joints\.[bc] by 0\.1 m, joints\.[bc] by 0\.1 m$"
    ) as told:
        found = mechanism.evaluate(0.0, q, v)
    assert [str(one.message) for one in told] == [*found.notes]
    assert Path(told[0].filename) == Path(__file__)
    assert repr(found).endswith(found.notes[0])
    q[7] -= 0.1
    v[0] += 0.3
    with pytest.warns(UserWarning, match="joints come apart: joints.a by 0.3 m/s"):
        mechanism.evaluate(0.0, q, v)


def test_scenes_without_all_masses_have_all_but_m_and_f() -> None:
    scene = READ["spatial_four_bar"]
    found = matrices(scene, 0.0, *_standing(scene))
    assert found.C_q.shape == (18, 18)
    with pytest.raises(SolveError, match="no M and no f: no mass of rocker; take C, C_q"):
        _ = found.f


def test_matrices_start_no_sympy() -> None:
    program = f"""
import sys
from kousoku.state_matrices import matrices
from kousoku.model.reading.read import read_scene
matrices(read_scene({str(FILES["pendulum"])!r}), 0, [0, 0, 0, 1, 0, 0, 0], [0] * 6)
assert "sympy" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.usefixtures("compiler")
def test_a_row_of_a_run_has_its_parameters_and_its_turns() -> None:
    engine = ks.load(SCENES / "engine.toml", outputs=["accelerations"])
    run = engine.simulate(0.01, samples=3, parameters={"crank": 0.055})
    assert np.abs(engine.matrices(*run.state(-1)).C).max() < 1e-12
    t, q, v = run.state(-1)
    assert np.abs(engine.matrices(t, np.array(q), v).C).max() > 1e-3  # numbers of one's own
    found = engine.evaluate(*run.state(-1))
    assert dict(zip(found.columns, found.v_dot, strict=True))["piston.x"] == pytest.approx(
        run.body("piston").acceleration[-1, 0], rel=1e-9
    )
    wound = ks.load(WOUND)
    run = wound.simulate(1, samples=2, initial={"a": "400 deg"})
    assert wound.evaluate(*run.state(0)).v_dot[-1] == pytest.approx(run["a_ddot"][0], rel=1e-12)
