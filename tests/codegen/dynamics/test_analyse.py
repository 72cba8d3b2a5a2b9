"""What is decided before a system is composed is what its program has, and is decided once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.dynamics import analyse as analysing
from kousoku.codegen.dynamics import choose
from kousoku.codegen.dynamics.analyse import analyse, in_xy_plane
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import compose_scene
from kousoku.codegen.dynamics.simplification.axis_permutation import permuted
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import read_scene
from tests.analysed import all_rows, independent, jointed

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.analyse import Analysed
    from kousoku.codegen.dynamics.recording.program import Program

SCENES = Path(__file__).parents[3] / "scenes"


def columns_of(program: Program) -> tuple[tuple[int, ...], ...]:
    """Velocities that bodies of a program have."""
    return tuple(
        tuple(k for k, place in enumerate((*body.v, *body.omega_b)) if place.slot >= 0)
        for body in program.bodies
    )


def check(found: Analysed) -> Program:
    """Compare what was decided with what was composed, and return that."""
    program = compose(found)
    assert program.is_planar == found.outline.is_planar
    assert columns_of(program) == found.outline.columns
    assert program.region("v").size == found.outline.velocities
    assert program.rows == tuple(found.solved)
    assert program.left_out == tuple(found.left_out)
    assert program.satisfied == tuple(found.satisfied)
    return program


@pytest.mark.parametrize("shift", [0, 1, 2])
def test_rows_and_columns_in_any_plane_are_those_that_are_composed(
    mechanisms: SimpleNamespace, shift: int
) -> None:
    found = all_rows(permuted(mechanisms.four_bars(1), shift))
    assert found.outline.normal == (2 - shift) % 3
    assert found.outline.columns[0] == ((0, 1, 5), (0, 2, 4), (1, 2, 3))[shift]
    assert in_xy_plane(found).outline == all_rows(mechanisms.four_bars(1)).outline
    program = check(found)
    assert len(program.rows) == 8


def test_rows_in_space_are_those_that_are_composed(mechanisms: SimpleNamespace) -> None:
    assert len(check(all_rows(mechanisms.chain(3))).rows) == 15
    program = check(independent(mechanisms.four_bars(1), may_be_planar=False))
    assert len(program.left_out) == 3


def test_rows_that_hold_by_themselves_have_no_multipliers(mechanisms: SimpleNamespace) -> None:
    found = jointed(mechanisms.chain(2))
    assert len(check(found).rows) == 5
    assert {row.joint for row in found.satisfied}.isdisjoint(row.joint for row in found.solved)


def test_analyses_tell_what_they_found() -> None:
    builder = SceneBuilder("welded", unit="m")
    for name, x in (("a", 0), ("b", 1)):
        builder.body(name, position=(x, 0, 0), boxes=[{"mass": 1, "size": (1, 2, 3)}])
    builder.joint("hinge", type="revolute", bodies=("ground", "a"), at=(0, 0, 0), axis=(0, 0, 1))
    builder.joint("weld", type="fixed", bodies=("a", "b"), at=(1, 0, 0))
    system = system_of(builder.build())
    found, apart = (analyse(system, wanted) for wanted in ((), ("reactions",)))
    assert (found.lumped, len(found.system.bodies)) == (("weld",), 1)
    assert (apart.lumped, len(apart.system.bodies)) == ((), 2)
    for one in (found, apart):
        assert one.outline.is_planar
        assert one.mobility.degrees == 1
        assert one.missing == ()


def test_masses_that_are_missing_are_named_where_drivers_move() -> None:
    builder = SceneBuilder("crank", unit="m").body("a", position=(0, 0, 0))
    builder.joint("hinge", type="revolute", bodies=("ground", "a"), at=(0, 0, 0), axis=(0, 0, 1))
    builder.driver("motor", joint="hinge", value="t")
    found = analyse(system_of(builder.build()), ())
    assert found.missing == ("bodies.a.mass",)
    assert found.system.bodies[0].mass == 1.0


@pytest.mark.parametrize(("name", "programs"), [("bricard", 1), ("pendulum", 2), ("engine", 2)])
def test_a_plane_is_looked_for_once_and_a_program_composed_for_each_way_to_solve_it(
    monkeypatch: pytest.MonkeyPatch, name: str, programs: int
) -> None:
    calls: list[str] = []

    def counted(module: Any, function: str) -> None:
        real = getattr(module, function)

        def call(*args: Any) -> Any:
            calls.append(function)
            return real(*args)

        monkeypatch.setattr(module, function, call)

    counted(analysing, "plane_of")
    counted(choose, "compose")
    compose_scene(read_scene(SCENES / f"{name}.toml"), ())
    assert calls == ["plane_of", *["compose"] * programs]
