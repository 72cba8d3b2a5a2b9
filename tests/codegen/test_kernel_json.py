"""Frozen kernels as text and back, without SymPy."""

import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import pytest

from kousoku.codegen.kernel_json import dump, load_frozen, parse
from kousoku.model.errors import LoadError
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel, Package


def test_a_package_reads_back_equal(n1_package: Package) -> None:
    assert parse(dump(n1_package)) == n1_package


def test_every_kind_of_node_reads_back() -> None:
    graph = Graph()
    x, y = graph.input("x", 0), graph.input("x", 1)
    third = graph.const(Fraction(1, 3))
    nodes = (
        graph.div(graph.sin(x), graph.sub(y, third)),
        graph.neg(graph.add(graph.cos(x), graph.sqrt(y))),
        graph.mul(third, graph.atan2(y, x)),
    )
    kernel = Kernel(
        "k",
        "",
        "",
        "",
        (Quantity("x", (2,), "m", "ω′"),),
        (Quantity("f", (3,), "-", ""),),
        tuple(graph.nodes),
        (nodes,),
        ((nodes[0], "t"),),
    )
    package = Package("scene", "", "", (kernel,))
    assert parse(dump(package)) == package


@pytest.mark.parametrize(
    ("damage", "wanted"),
    [
        (lambda text: text[: len(text) // 2], "JSONDecodeError"),
        (lambda text: text.replace('"format": 2', '"format": 0'), "format 0 instead of 2"),
        (lambda text: re.sub(r"\d+\+", "plus ", text, count=1), "'plus' is not a valid Op"),
        (
            lambda text: re.sub(r"\d+\+\d+", "tan 0", text, count=1),
            "tan is no operation of a kernel",
        ),
        (lambda text: text.replace('"0*', '"999*', 1), "999 is used before"),
        (lambda text: text.replace('"shape":[3]', '"shape":[2]'), "do not fit its outputs"),
        (lambda text: "[]", "TypeError"),
    ],
)
def test_a_damaged_file_is_refused_with_the_reason(
    n1_package: Package, damage: Callable[[str], str], wanted: str
) -> None:
    damaged = damage(dump(n1_package))
    assert damaged != dump(n1_package)
    with pytest.raises(LoadError, match=wanted):
        parse(damaged)


def test_an_unknown_kind_is_named() -> None:
    with pytest.raises(LoadError, match="no kind sponge is shipped; there are"):
        load_frozen("sponge")


def test_equal_packages_give_equal_bytes(n1_package: Package) -> None:
    again = replace(n1_package, kernels=tuple(replace(k) for k in n1_package.kernels))
    assert dump(again) == dump(n1_package)


def test_reading_frozen_kernels_starts_no_sympy() -> None:
    program = (
        "import sys; from kousoku.codegen.kernel_json import load_frozen\n"
        "try: load_frozen('n1')\n"
        "except Exception as problem: assert 'is shipped' in str(problem), problem\n"
        "assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
