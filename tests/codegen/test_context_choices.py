"""Choices of rows: one package, whose kernels share what they compute alike."""

from __future__ import annotations

import itertools
from importlib import import_module
from typing import TYPE_CHECKING

import pytest

import kousoku.generated.kinds
from kousoku.codegen.context import package_context
from kousoku.codegen.context_choices import merged_kernel
from kousoku.codegen.kernel_json import load_frozen, shipped_kinds
from kousoku.generated.kinds import p1, p2
from kousoku.model.operations.interpret import ARRAY, evaluate

if TYPE_CHECKING:
    import numpy as np

FAMILIES = list(itertools.product(("p1", "p2"), ("constraint", "rates", "reaction")))


@pytest.mark.parametrize(("kind", "name"), FAMILIES)
def test_together_each_choice_gives_its_own_bits(
    kind: str, name: str, rng: np.random.Generator
) -> None:
    family = [k for k in load_frozen(kind).kernels if k.name.startswith(name)]
    merged = merged_kernel(family)
    assert len(merged.nodes) < sum(len(kernel.nodes) for kernel in family)
    values = {q.name: list(rng.normal(size=q.size)) for q in merged.inputs}
    count = len(family[0].outputs)
    for choice, kernel in enumerate(family):
        alone = evaluate(kernel, values, ARRAY)
        for k, output in enumerate(kernel.outputs):
            part = merged.results[choice * count + k]
            one = type(merged)(
                "one", "", "", "", merged.inputs, (output,), merged.nodes, (part,), ()
            )
            assert evaluate(one, values, ARRAY)[output.name] == alone[output.name]


def test_what_the_choices_share_stands_once() -> None:
    context = package_context(load_frozen("p2"), "0", "0" * 64)
    first, *others = [kernel for kernel in context.kernels if kernel.family == "constraint"]
    assert first.is_first and not any(kernel.is_first for kernel in others)
    text = first.body.c
    assert len(text.tails) == 3
    assert len(text.head) > 2 * max(len(tail.statements) for tail in text.tails)


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(("kind", "axis"), list(itertools.product(("p1", "p2"), "xyz")))
def test_a_choice_of_rows_has_its_name(kind: str, axis: str) -> None:
    module = import_module(f"kousoku.generated.kinds.{kind}_{axis}")
    assert getattr(kousoku.generated.kinds, f"{kind}_{axis}") is module
    package = {"p1": p1, "p2": p2}[kind]
    for name in ("constraint", "rates", "reaction"):
        assert getattr(module, name) is getattr(package, f"{name}_{axis}")
    with pytest.raises(AttributeError, match="has no attribute 'constraint_x'"):
        _ = module.constraint_x
    frozen = load_frozen(f"{kind}_{axis}")
    assert (frozen.name, frozen.regenerate) == (f"{kind}_{axis}", f"kousoku generate {kind}_{axis}")
    assert [kernel.name for kernel in frozen.kernels] == ["constraint", "rates", "reaction"]


def test_the_kinds_that_are_shipped_count_each_choice() -> None:
    assert {"n1", "p1_x", "p1_y", "p2_z"} <= set(shipped_kinds())
    assert "p1" not in shipped_kinds()
