"""From a constraint between two bodies to all that a solver needs of it, on both levels."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from sympy import S, Symbol
from sympy.matrices.expressions import BlockMatrix, MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.bodies import CONFIGURATION, MOTION, motion_flow, unit_flows
from kousoku.symbolic.check import check_constraint, check_functions
from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function, output_of
from kousoku.symbolic.forms import Constraint, Forms, collect, steps, with_abbreviations
from kousoku.symbolic.matrices import elements, mul, symbol, transpose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.components import Flow
    from kousoku.symbolic.sympy_types import SymbolicMatrix


__all__ = ["Constraint", "derive_constraint"]


def derive_constraint(c: Constraint) -> Derivation:
    """Derivation of a constraint C = 0 (m,): Jacobian, right-hand sides, reaction.

    C_q (m, 12) has the columns δr_i, δθ′_i, δr_j, δθ′_j: δr [m] in frame O, δθ′ [rad] in the body
    frame, by δA = A δθ̃′, lecture 7.1, (7.16). Ċ = C_q v − ν and C̈ = C_q v̇ − γ. The reaction
    C_qᵀλ (12,) has a force [N] in frame O and a torque [N m] in the body frame for each body; its
    derivative at fixed λ is (12, 12), in the same columns.

    Raises
    ------
    DerivationError
        The value is no column of as many rows as there are components, holds undeclared symbols, or
        has no linear form; the message says which.
    """
    check_constraint(c, [*(q.name for q in (*CONFIGURATION, *MOTION)), "lam"])
    forms = collect(c)
    derivation = Derivation(
        name=c.name,
        kind=c.kind,
        title=c.title,
        source=c.source,
        steps=with_abbreviations((*c.steps, *steps(c, forms))),
        functions=_functions(c, forms),
    )
    check_functions(derivation)
    return derivation


def _functions(c: Constraint, forms: Forms) -> tuple[Function, ...]:
    flows = unit_flows()
    jacobian = [flow(x) for x in c.components for flow in flows]
    return (
        _constraint(c, forms, jacobian),
        _rates(c, forms),
        _reaction(c, forms, jacobian, flows),
    )


def _constraint(c: Constraint, forms: Forms, jacobian: Sequence[Any]) -> Function:
    m = len(c.components)
    unit = "-, m" if c.unit == "m" else "1/m, -"
    columns = "Jacobian; columns δr_i, δθ′_i, δr_j, δθ′_j"
    outputs = (
        output_of(Quantity("C", (m,), c.unit, "constraint"), c.value, c.components),
        output_of(
            Quantity("C_q", (m, 12), unit, columns),
            BlockMatrix([list(forms.jacobian)]),
            jacobian,
            () if c.closed is None else (BlockMatrix([list(c.closed.plain.jacobian)]),),
        ),
    )
    return _function(c, "constraint", "constraint and Jacobian", c.formula, outputs)


def _rates(c: Constraint, forms: Forms) -> Function:
    m, motion = len(c.components), motion_flow()
    unit = "m" if c.unit == "m" else "1"
    nu = Quantity("nu", (m,), f"{unit}/s", "dC/dt = C_q v − nu")
    gamma = Quantity("gamma", (m,), f"{unit}/s^2", "d²C/dt² = C_q dv/dt − gamma")
    outputs = (
        output_of(nu, forms.nu, [S.Zero] * m),
        output_of(
            gamma,
            forms.gamma if c.gamma is None else c.gamma.right,
            [-motion(motion(x)) for x in c.components],
            () if c.closed is None else (*c.closed.through, c.closed.plain.gamma),
        ),
    )
    formula = f"{nu.meaning}, {gamma.meaning}"
    return _function(c, "rates", "right-hand sides", formula, outputs)


def _reaction(
    c: Constraint, forms: Forms, jacobian: Sequence[Any], flows: Sequence[Flow]
) -> Function:
    lam = elements(c.lam)
    forces = [
        sum((factor * x for factor, x in zip(lam, jacobian[k::12], strict=True)), S.Zero)
        for k in range(12)
    ]
    force = Quantity(
        "reaction",
        (12,),
        "N, N m",
        "C_qᵀλ: force in frame O and torque in the body frame, of i, then of j",
    )
    stiffness = Quantity(
        "reaction_q",
        (12, 12),
        "N/m, N, N m",
        "(C_qᵀλ)_q at fixed λ; columns δr_i, δθ′_i, δr_j, δθ′_j",
    )
    plain = None if c.closed is None else c.closed.plain
    number = symbol(c.lam)[0, 0]
    outputs = (
        output_of(
            force,
            BlockMatrix([[f] for f in forms.reaction]),
            forces,
            ()
            if plain is None
            else (BlockMatrix([[mul(number, transpose(x))] for x in plain.jacobian]),),
        ),
        output_of(
            stiffness,
            BlockMatrix([list(row) for row in forms.stiffness]),
            [flow(f) for f in forces for flow in flows],
            ()
            if plain is None
            else (BlockMatrix([[mul(number, x) for x in row] for row in plain.second]),),
        ),
    )
    title, formula = "reaction and its derivative", "C_qᵀλ and (C_qᵀλ)_q"
    return _function(c, "reaction", title, formula, outputs, c.lam)


def _function(
    c: Constraint,
    name: str,
    title: str,
    formula: str,
    outputs: tuple[DerivedOutput, ...],
    *extra: Quantity,
) -> Function:
    held = set().union(*(_held(output.expression) for output in outputs))
    used = held or _held(c.value)  # right-hand sides that all vanish are called with something too
    inputs = tuple(q for q in (*CONFIGURATION, *c.inputs, *MOTION) if q.name in used)
    outputs = tuple(replace(x, at_pole=c.at_pole.get(x.quantity.name)) for x in outputs)
    return Function(name, f"{c.title}: {title}", formula, c.source, (*inputs, *extra), outputs)


def _held(x: SymbolicMatrix) -> set[str]:
    return {str(atom.name) for atom in x.atoms(Symbol, MatrixSymbol)}
