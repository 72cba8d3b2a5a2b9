"""Bodies of scenes that drivers move need no mass; what depends on masses is refused by name."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.errors import SceneError
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.model.records.scene import Scene

HEAVY = {"mass": 3, "inertia": {"xx": 2, "yy": 5, "zz": 4}}
MOTOR = {"motor": {"joint": "a", "value": "0.5*t + 0.1*sin(3*t)"}}


def slider_crank(bodies: dict[str, Any], **tables: Any) -> Scene:
    """Crank and rod of 1 m and 2 m and a slider on the x-axis, and what they weigh."""
    start = {"crank": [0, 0, 0], "rod": [0.6, 0.8, 0], "slider": [0.6 + 3.36**0.5, 0, 0]}
    axis = {"axis": [0, 0, 1], "type": "hinge"}
    joints = {
        "a": {"bodies": ["ground", "crank"], "at": start["crank"], **axis},
        "b": {"bodies": ["crank", "rod"], "at": start["rod"], **axis},
        "c": {"bodies": ["rod", "slider"], "at": start["slider"], **axis},
        "d": {"type": "slider", "bodies": ["ground", "slider"], "at": [0, 0, 0], "axis": [1, 0, 0]},
    }
    return scene_from_dict(
        {
            **{"name": "slider_crank_driven", "unit": "m", "joints": joints},
            "bodies": {
                name: {"position": at, **bodies.get(name, {})} for name, at in start.items()
            },
            **{"outputs": ["accelerations"], **tables},
        }
    )


@pytest.mark.usefixtures("compiler")
def test_a_driven_motion_is_the_same_with_and_without_masses(tmp_path: Path) -> None:
    motions = []
    for name, masses in (
        ("light", {}),
        ("heavy", dict.fromkeys(("crank", "rod", "slider"), HEAVY)),
    ):
        tree = generate_dynamics(slider_crank(masses, drivers=MOTOR))
        assert json.loads(tree["motion.json"])["is_driven"] is True
        write_tree(tmp_path / name, tree)
        solver = load_dynamics(tmp_path / name, target="c")
        motions.append(solver.simulate(1.5, samples=4))

    light, heavy = motions
    assert light.ledger.energy is None and light.ledger.energy_error is None
    assert not light.ledger.works and "energy" not in str(light.ledger)
    assert heavy.ledger.energy_error is not None and heavy.ledger.works
    for body in ("crank", "rod", "slider"):
        assert np.abs(light.position[body] - heavy.position[body]).max() < 1e-14
        assert np.abs(light.acceleration[body] - heavy.acceleration[body]).max() < 1e-13
    assert np.ptp(light.position["slider"][:, 0]) > 0.5


@pytest.mark.parametrize("wanted", ["reactions", "energies"])
def test_what_depends_on_a_mass_that_is_missing_names_it(wanted: str) -> None:
    masses = {"crank": HEAVY, "slider": HEAVY}
    scene = slider_crank(masses, drivers=MOTOR, outputs=[wanted])

    with pytest.raises(SceneError, match=rf"^outputs: asks for {wanted}.*bodies\.rod\.mass"):
        generate_dynamics(scene)


def test_a_moment_that_is_missing_is_named_where_the_body_turns() -> None:
    """The slider does not turn, but has a column for it, and the rod turns about z."""
    masses = {"crank": HEAVY, "rod": {"mass": 1}, "slider": HEAVY}
    scene = slider_crank(masses, drivers=MOTOR, outputs=["reactions"])

    with pytest.raises(SceneError, match=r"bodies\.rod\.inertia"):
        generate_dynamics(scene)


def test_freedoms_that_drivers_leave_need_masses() -> None:
    bodies = {"one": {"position": [0, 0, 0]}, "two": {"position": [5, 0, 0], "mass": 1}}
    joints = {
        f"at_{name}": {
            "type": "hinge",
            "bodies": ["ground", name],
            "at": [x, 0, 0],
            "axis": [0, 0, 1],
        }
        for name, x in (("one", 0), ("two", 5))
    }
    drivers = {"motor": {"joint": "at_one", "value": "t"}}
    scene = scene_from_dict(
        {"name": "s", "unit": "m", "bodies": bodies, "joints": joints, "drivers": drivers}
    )

    with pytest.raises(SceneError, match=r"^bodies\.one\.mass: is missing, and drivers leave 1 of"):
        generate_dynamics(scene)


@pytest.mark.parametrize(
    ("drivers", "says"),
    [
        (("a", "b"), r"^outputs: asks for reactions, .* bodies\.rod\.inertia, and it has a moment"),
        (("a",), r"^bodies\.rod\.inertia: has a moment of zero, as of a rod .* leave 1 of"),
    ],
)
def test_a_rod_without_thickness_is_not_said_to_lack_its_inertia(
    drivers: tuple[str, ...], says: str
) -> None:
    rods = {"rods": [{"mass": 1, "ends": [[0, 0, 0], [1, 0, 0]]}]}
    scene = scene_from_dict(
        {
            **{"name": "wrist", "unit": "m", "outputs": ["reactions"], "gravity": [0, 0, -9]},
            "bodies": {
                "arm": {"position": [0, 0, 0], **HEAVY},
                "rod": {"position": [0, 1, 0], **rods},
            },
            "joints": {
                "a": {"type": "hinge", "bodies": ["ground", "arm"], "at": [0, 0, 0]}
                | {"axis": [0, 0, 1]},
                "b": {"type": "hinge", "bodies": ["arm", "rod"], "at": [0, 1, 0]}
                | {"axis": [1, 0, 0]},
            },
            "drivers": {f"of_{joint}": {"joint": joint, "value": "t"} for joint in drivers},
        }
    )

    with pytest.raises(SceneError, match=says) as caught:
        generate_dynamics(scene)
    assert "missing" not in str(caught.value)
    assert "thickness, as of a cylinder" in str(caught.value)
