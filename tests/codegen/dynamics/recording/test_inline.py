"""Straight-line programs compute what the tasks compute."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.recording.program import (
    AFTER_GEOMETRY,
    meaning_of,
    reads,
    writes,
)
from kousoku.model.numbers.digits import HIGH
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

RESULTS = (
    *("C", "dq", "q_moved", "dv", "q_dot", "v_dot", "lam", "reactions", "energies"),
    *("C_dot", "C_ddot"),
)


def system_of(mechanisms: SimpleNamespace, name: str) -> System:
    builders = {
        "chain": lambda: mechanisms.chain(4),
        "star": lambda: mechanisms.star(4),
        "bars": lambda: mechanisms.four_bars(2),
        "points": mechanisms.point_on_rod,
        "mixed": mechanisms.mixed,
    }
    system: System = builders[name]()
    return system


@pytest.mark.parametrize("name", ["chain", "star", "bars", "points", "mixed"])
@pytest.mark.parametrize("statements", [40, 500])
def test_straight_line_code_computes_what_the_tasks_compute(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str, statements: int
) -> None:
    program = compose(
        all_rows(system_of(mechanisms, name)), ["reactions", "coordinates", "energies", "checks"]
    )
    straight = inline(program, limit=100_000, statements=statements)
    one, other = ProgramInterpreter(program), ProgramInterpreter(straight)
    noise = {name: rng.normal(scale=0.05, size=len(one[name])) for name in ("q", "v")}
    for workspace in (one, other):
        for region, change in noise.items():
            workspace[region] = [a + b for a, b in zip(workspace[region], change, strict=True)]
        workspace.run(*(segment.name for segment in program.segments))
    for region in RESULTS:
        wanted = np.array(one[region])
        scale = np.abs(wanted).max(initial=1.0)
        np.testing.assert_allclose(other[region], wanted, rtol=0, atol=1e-11 * scale)


def test_tasks_and_straight_line_code_agree_in_fifty_digits(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.four_bars(1)), ["reactions"])
    workspaces = [
        ProgramInterpreter(one, HIGH) for one in (program, inline(program, limit=100_000))
    ]
    for workspace in workspaces:
        workspace["v"] = [HIGH.number(Fraction(k, 7)) for k in range(len(workspace["v"]))]
        workspace.run("geometry", "acceleration")
    for a, b in zip(workspaces[0]["v_dot"], workspaces[1]["v_dot"], strict=True):
        assert abs(a - b) < 1e-40
    assert max(map(abs, workspaces[0]["v_dot"])) > 0.1


def test_straight_line_code_has_fewer_operations_and_short_functions(
    mechanisms: SimpleNamespace,
) -> None:
    program = compose(all_rows(mechanisms.four_bars(3)))
    straight = inline(program, limit=100_000, statements=60)
    assert operations(straight) < operations(program)
    assert max(kernel.operations.total() for kernel in straight.kernels) <= 60
    assert straight.constants == ()
    assert straight.size < program.size


def test_what_rows_alone_need_is_not_computed_with_every_stage(mechanisms: SimpleNamespace) -> None:
    """A free body has momenta that should not change; its accelerations need no matrix."""
    straight = inline(compose(all_rows(mechanisms.star(0)), ["energies", "checks"]))
    counts = {
        segment.name: sum(
            straight.kernels[task.kernel].operations.total() for task in segment.tasks
        )
        for segment in straight.segments
    }
    assert counts["geometry"] == 0
    assert counts["momentum"] > 20
    assert all(kernel.outputs for kernel in straight.kernels)
    assert not straight.segment("check").tasks


def test_large_programs_stay_tasks(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.chain(3)))
    assert inline(program, limit=operations(program) - 1) is program


@pytest.mark.parametrize("form", ["tasks", "straight"])
def test_segments_share_only_the_regions_and_what_the_geometry_left(
    mechanisms: SimpleNamespace, form: str
) -> None:
    program = compose(all_rows(mechanisms.four_bars(2)), ["energies"])
    if form == "straight":
        program = inline(program, limit=100_000, statements=80)
    named = {
        slot for region in program.regions for slot in range(region.base, region.base + region.size)
    }
    geometry = slots_of(program, "geometry")
    for segment in program.segments:
        known = named | (geometry if segment.name in AFTER_GEOMETRY else set())
        for number, task in enumerate(segment.tasks):
            read = {
                base + node.symbol[1]
                for (base, _), quantity in zip(
                    reads(program, task), program.kernels[task.kernel].inputs, strict=True
                )
                for node in program.kernels[task.kernel].nodes
                if node.symbol is not None and node.symbol[0] == quantity.name
            }
            assert read <= known, (segment.name, number)
            known |= {
                slot
                for base, length in writes(program, task)
                for slot in range(base, base + length)
            }


def slots_of(program: Program, name: str) -> set[int]:
    return {
        slot
        for task in program.segment(name).tasks
        for base, length in writes(program, task)
        for slot in range(base, base + length)
    }


def test_the_head_of_a_straight_segment_names_only_what_it_reads(
    mechanisms: SimpleNamespace,
) -> None:
    """A function takes the whole workspace; no constraint here depends on time."""
    straight = inline(compose(all_rows(system_of(mechanisms, "chain")), ["checks"]), limit=100_000)
    heads = {one.name: meaning_of(straight, one).split(" -> ")[0] for one in straight.segments}
    assert heads["geometry"] == "q"
    assert heads["move"] == "q, dq"
    assert heads["velocity"] == heads["acceleration"] == "v"
