"""Sums of many blocks: right, in few small tasks, and in the order of the parts."""

from __future__ import annotations

import pytest

from kousoku.codegen.dynamics.operations.sums import CHUNK, summed
from kousoku.codegen.dynamics.recording.recorder import Recorder


@pytest.mark.parametrize("count", [1, 2, CHUNK, CHUNK + 1, 3 * CHUNK * CHUNK + 2])
def test_no_task_of_a_sum_has_more_than_a_few_terms(count: int) -> None:
    recorder = Recorder()
    region, total = recorder.region("x", 3 * count), recorder.region("total", 3)
    recorder.begin("sum")
    parts = [region.part(3 * k, 3) for k in range(count)]
    found = summed(recorder, parts, total)
    assert found.entries == total.entries
    segments, _, _ = recorder.finish()
    (segment,) = segments
    terms = [len(recorder.kernels[task.kernel].inputs) for task in segment.tasks]
    assert max(terms) <= CHUNK
    assert sum(terms) - len(terms) + 1 >= count


def test_one_part_alone_is_the_sum() -> None:
    recorder = Recorder()
    region = recorder.region("x", 3)
    recorder.begin("sum")
    assert summed(recorder, [region]) is region
