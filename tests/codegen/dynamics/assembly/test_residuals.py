"""Rows evaluated in 50 digits and in doubles are the same, and C_q is the derivative of C."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.pose import Pose
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers import precise
from kousoku.model.reading.read import read_scene

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System

SCENES = Path(__file__).parents[4] / "scenes"
COUPLED = ["gear_train", "falling_nut", "constant_velocity", "oldham_coupling"]


def anywhere(name: str) -> System:
    """Scene whose bodies stand and turn where its joints do not hold."""
    system = system_of(read_scene(SCENES / f"{name}.toml"))
    numbers = np.random.default_rng(len(name))
    bodies = []
    for body in system.bodies:
        w, x, y, z = numbers.normal(size=4) + 3 * np.array(body.p)
        size = float(np.sqrt(w * w + x * x + y * y + z * z))
        r = tuple((np.array(body.r) + 0.1 * numbers.normal(size=3)).tolist())
        p = (float(w) / size, float(x) / size, float(y) / size, float(z) / size)
        bodies.append(replace(body, r=(r[0], r[1], r[2]), p=p))
    return replace(system, bodies=tuple(bodies))


@pytest.mark.parametrize("name", COUPLED)
def test_rows_are_the_same_in_doubles_and_in_fifty_digits(name: str) -> None:
    system = anywhere(name)
    rows = Residuals.of(system, system.constraints)
    values, jacobian = rows.at(Pose.of(system.bodies, system.coordinates))
    r = np.array([*(body.r for body in system.bodies), (0.0, 0.0, 0.0)])
    p = np.array([*(body.p for body in system.bodies), (1.0, 0.0, 0.0, 0.0)])
    c, matrix = rows.doubles(r, p)

    assert np.abs(c - [float(x) for x in values]).max() < 1e-15
    assert np.abs(matrix - jacobian.dense()).max() < 1e-15


@pytest.mark.parametrize("name", COUPLED)
def test_the_jacobian_of_coupled_rows_is_their_derivative(name: str) -> None:
    system = anywhere(name)
    rows = Residuals.of(system, system.constraints)
    pose = Pose.of(system.bodies, system.coordinates)
    _, jacobian = rows.at(pose)
    step = [precise.number(0.3 + k % 7) * precise.number(1e-18) for k in range(rows.columns)]
    ahead, _ = rows.at(pose.moved(step))
    behind, _ = rows.at(pose.moved([-x for x in step]))

    for slope, after, before in zip(jacobian.times(step), ahead, behind, strict=True):
        assert abs((after - before) / 2 - slope) < 1e-46


def test_an_angle_is_counted_from_the_one_that_is_near() -> None:
    system = anywhere("gear_train")
    turned = tuple(replace(one, near=one.near + 12 * np.pi) for one in system.coordinates)
    rows, other = (
        Residuals.of(replace(system, coordinates=coordinates), system.constraints)
        for coordinates in (system.coordinates, turned)
    )
    here = rows.counted(Pose.of(system.bodies, system.coordinates)).near
    there = other.counted(Pose.of(system.bodies, turned)).near

    turned_by = {
        coordinate.name: float(two - one)
        for one, two, coordinate in zip(here, there, system.coordinates, strict=True)
        if coordinate.counts_turns
    }
    assert turned_by == pytest.approx({"pinion_angle": 12 * np.pi, "wheel_angle": 12 * np.pi})
