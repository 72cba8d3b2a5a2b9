"""Points on the manifold of a constraint."""

import math

import sympy

from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.manifold import solve_constraint
from kousoku.codegen.points import ordinary
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.dual import evaluate_dual
from kousoku.symbolic import derive
from kousoku.symbolic.derivation import DerivedOutput, Function
from kousoku.symbolic.matrices import elements


def test_newton_finds_the_manifold() -> None:
    function = derive("n2").functions[0]
    components = freeze_components(function)
    start = ordinary(function.inputs, Sha256Random("s"))
    solution = solve_constraint(components, "C", start)
    assert solution is not None
    assert abs(evaluate_dual(components, start)["C"][0].value) > 1e-3
    assert abs(evaluate_dual(components, solution)["C"][0].value) < 1e-14
    assert math.isclose(math.hypot(*solution["p_i"]), 1, rel_tol=1e-15)


def test_newton_gives_up_where_the_constraint_repeats_the_norm() -> None:
    p = Quantity("p", (4,), "-", "")
    norm = Quantity("C", (1,), "-", "")
    components = sympy.ImmutableDenseMatrix([sum(e**2 for e in elements(p)) - 1])
    output = DerivedOutput(norm, sympy.S.Zero, components)
    frozen = freeze_components(Function("constraint", "", "", "", (p,), (output,)))
    assert solve_constraint(frozen, "C", {"p": (1.0, 2.0, 3.0, 4.0)}) is None
