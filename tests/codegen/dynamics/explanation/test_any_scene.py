"""Of any scene, fewer outputs and fewer dimensions cost less and change no acceleration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.explain import ALL
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_dict
from tests.analysed import all_rows, independent

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

NUMBERS = st.floats(0.3, 1.5).map(lambda x: round(x, 3))
JOINTS = st.sampled_from(["revolute", "cylindrical", "spherical", "parallel_axes"])


def linkage(lengths: list[tuple[float, float]], kinds: list[str], *, in_plane: bool) -> System:
    """Bodies one behind the other, whose last point stays in a plane."""
    bodies: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    at, before = (0.0, 0.0, 0.0), "ground"
    for k, ((x, y), kind) in enumerate(zip(lengths, kinds, strict=True)):
        z = 0.0 if in_plane else x * y - 0.5
        box = {"mass": x, "size": (x, y, 0.2), "at": (x / 2, y / 3, z / 2)}
        bodies[f"b{k}"] = {"position": at, "boxes": [box], "angular_velocity": (0, 0, y)}
        axis = {} if kind == "spherical" else {"axis": (0, 0, 1) if in_plane else (x, y, 1)}
        point = {} if kind == "parallel_axes" else {"at": at}
        joints[f"j{k}"] = {"type": kind, "bodies": (before, f"b{k}")} | axis | point
        at, before = (at[0] + x, at[1] + (y if k % 2 else -y), at[2] + z), f"b{k}"
    end = {"type": "inplane", "bodies": ("ground", before), "at": at, "axis": (1, 0.3, 0)}
    tree = {"name": "any_scene", "unit": "m", "gravity": (1, -9.81, 0), "bodies": bodies}
    return assemble(system_of(scene_from_dict(tree | {"joints": joints | {"end": end}})))


def accelerations(program: Program) -> list[float]:
    """Accelerations of all bodies at the start; 0 of those left out."""
    workspace = ProgramInterpreter(program)
    for segment in ("geometry", "acceleration"):
        workspace.run(segment)
    base, v_dot = program.region("v").base, workspace["v_dot"]
    places = [place for body in program.bodies for place in (*body.v, *body.omega_b)]
    return [float(v_dot[x.slot - base]) if x.slot >= 0 else 0.0 for x in places]


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    parts=st.lists(st.tuples(st.tuples(NUMBERS, NUMBERS), JOINTS), min_size=2, max_size=4),
    wanted=st.lists(st.sampled_from(ALL), unique=True, max_size=len(ALL) - 1),
)
def test_fewer_outputs_cost_less_and_change_nothing(
    parts: list[tuple[tuple[float, float], str]], wanted: list[str]
) -> None:
    system = linkage([x for x, _ in parts], [kind for _, kind in parts], in_plane=False)
    some, everything = (compose(all_rows(system), names) for names in (wanted, ALL))
    assert operations(some) < operations(everything)
    assert accelerations(some) == accelerations(everything)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(lengths=st.lists(st.tuples(NUMBERS, NUMBERS), min_size=2, max_size=4))
def test_a_plane_costs_less_and_moves_as_in_space(lengths: list[tuple[float, float]]) -> None:
    system = linkage(lengths, ["revolute"] * len(lengths), in_plane=True)
    flat = compose(all_rows(system))
    spatial = compose(independent(system, may_be_planar=False))
    assert 2 * operations(flat) < operations(spatial)
    assert accelerations(flat) == pytest.approx(accelerations(spatial), rel=1e-9, abs=1e-9)
