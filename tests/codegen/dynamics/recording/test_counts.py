"""The costs that are reported are those of the program, and they do not grow by accident."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.counts import counts, operations
from kousoku.codegen.dynamics.recording.inline import inline
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program

ACCELERATIONS = ("geometry", "acceleration")


def cost_of_accelerations(program: Program) -> int:
    return sum(count.operations for count in counts(program) if count.segment in ACCELERATIONS)


def test_counts_hold_every_task_once(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.chain(3)), ["energies"])
    found = counts(program)
    assert sum(count.tasks for count in found) == sum(len(x.tasks) for x in program.segments)
    by_title = {(count.segment, count.title): count for count in found}
    orientation = by_title["geometry", "orientation"]
    assert (orientation.kernels, orientation.tasks, orientation.operations) == (1, 3, 3 * 26)
    assert operations(program) == sum(count.operations for count in found)


def test_accelerations_of_a_chain_cost_about_a_thousand_operations_a_body(
    mechanisms: SimpleNamespace,
) -> None:
    cost = [cost_of_accelerations(compose(all_rows(mechanisms.chain(n)))) for n in (20, 40)]
    # 18 of them keep digits: γ of p1 from the relative angular velocity, where less cancels.
    assert (cost[1] - cost[0]) / 20 <= 1020


def test_forty_four_bars_cost_few_operations(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.four_bars(40)))
    assert program.is_planar
    assert len(program.rows) == 242
    assert cost_of_accelerations(inline(program, limit=100_000)) <= 13_150


def test_asking_for_less_costs_less(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.four_bars(2)
    least = compose(all_rows(system))
    assert operations(least) < operations(compose(all_rows(system), ["energies"]))
    assert least.size < compose(all_rows(system), ["reactions"]).size


def test_a_planar_scene_costs_a_fifth_of_the_spatial_one(mechanisms: SimpleNamespace) -> None:
    pendulum = mechanisms.planar_pendulum(2)
    spatial = compose(all_rows(pendulum, may_be_planar=False))
    assert not spatial.is_planar
    assert cost_of_accelerations(compose(all_rows(pendulum))) < cost_of_accelerations(spatial) / 5
