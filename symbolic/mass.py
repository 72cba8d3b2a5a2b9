"""Newton-Euler in the 6×6 form: mass points, and a rigid body given by mass, centre and inertia.

After "three mass points" (2020): frame A is fixed to the points, its origin anywhere. The unknowns
are the acceleration of the origin in frame O and the angular acceleration in the body frame,
``M (a, dω′/dt) = h``. The kernels ``inertia`` and ``resultant`` of ``mass_points`` give what the
kernel ``newton_euler`` of ``rigid_body`` takes, so that both go through the same kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy import Integer, S
from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import Flow, cross, dot, half_turn, rotate, rotate_back
from kousoku.symbolic.derivation import Derivation, Function, Step, output_of
from kousoku.symbolic.mass_steps import (
    OMEGA_B,
    A,
    P,
    balance_steps,
    motion_steps,
    reduction_steps,
)
from kousoku.symbolic.matrices import (
    NamedMatrix,
    NamedScalar,
    add,
    elements,
    mul,
    neg,
    skew,
    symbol,
    transpose,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix

SOURCE = "three mass points"
MASS = Quantity("mass", (), "kg", "total mass")
R_AG_B = Quantity("r_AG_b", (3,), "m", "centre of mass from the origin, body frame")
I_A_B = Quantity("I_A_b", (3, 3), "kg m^2", "inertia about the origin, body frame, symmetric")
FORCE = Quantity("F", (3,), "N", "total force, frame O")
TORQUE_B = Quantity("N_b", (3,), "N m", "total torque about the origin, body frame")
MATRIX = Quantity("M", (6, 6), "kg, kg m, kg m^2", "mass matrix; rows force, torque")
RIGHT = Quantity("h", (6,), "N, N m", "right-hand side of M (a, dω′/dt) = h")


@dataclass(frozen=True, slots=True)
class BodyTerms:
    """The matrix level of moving bodies; equations of three mass points.

    Parameters
    ----------
    mass : NamedScalar [kg]
        Total mass, Σ m, (total-mass).
    moment : NamedMatrix (3, 1) [kg m]
        First moment, mass times r_AG, body frame, (centre-of-mass).
    inertia : NamedMatrix (3, 3) [kg m²]
        About the origin, body frame, Σ m s̃′ᵀs̃′, (inertia).
    force, torque : NamedMatrix (3, 1) [N], [N m]
        Resultants, frame O and body frame, (resultants).
    second : NamedMatrix (3, 3) [kg m²], optional
        Second moment K = Σ m s′s′ᵀ, where it is known: I = tr(K) − K, and ω̃′Iω′ = −ω̃′Kω′ without
        the trace, which cancels.
    """

    mass: NamedScalar
    moment: NamedMatrix
    inertia: NamedMatrix
    force: NamedMatrix
    torque: NamedMatrix
    second: NamedMatrix | None = None


def derive(package: str) -> Derivation:
    """Derivation of ``mass_points`` (three of them) or ``rigid_body``.

    M (v̇, ω̇′) = h, (6, 6) and (6,): the first three rows in frame O [N], the others in the body
    frame [N m]; "three mass points" (2020).
    """
    return derive_mass_points(3) if package == "mass_points" else derive_rigid_body()


def newton_euler(body: BodyTerms) -> tuple[SymbolicMatrix, SymbolicMatrix]:
    """Matrix M (6, 6) and h (6,) of M (v̇, ω̇′) = h; three mass points, (matrix-form).

    M = [[m I, −A c̃], [c̃ Aᵀ, I_A]] in kg, kg m and kg m², h = (F + A ω̃′c̃ ω′, N′ − ω̃′I_A ω′) in
    N and N m, with the first moment c [kg m] in the body frame: force and v̇ in frame O, torque
    about the origin and ω̇′ in the body frame.
    """
    spin, arm = skew(symbol(OMEGA_B)), skew(body.moment)
    coupling = mul(A, arm)
    matrix = BlockMatrix(
        [[mul(body.mass, Identity(3)), neg(coupling)], [mul(arm, transpose(A)), body.inertia]]
    )
    omega = symbol(OMEGA_B)
    turning = neg(body.inertia) if body.second is None else body.second
    right = BlockMatrix(
        [
            [add(body.force, mul(A, spin, arm, omega))],
            [add(body.torque, mul(spin, turning, omega))],
        ]
    )
    return matrix, right


def _spin_flow() -> Flow:
    p = elements(P)
    change = dict(zip(p, half_turn(p, elements(OMEGA_B)), strict=True))
    return Flow(change, (*p, *elements(OMEGA_B)))


def _unit_flows() -> list[Flow]:
    p = elements(P)
    units = [[Integer(k == n) for n in range(3)] for k in range(3)]
    return [Flow(dict(zip(p, half_turn(p, unit), strict=True)), p) for unit in units]


def _coupling_components(moment: Sequence[Any]) -> list[list[Any]]:
    """Derivative ∂(A c)/∂θ′, by differentiating the polynomial."""
    turned = rotate(elements(P), moment)
    return [[flow(x) for flow in _unit_flows()] for x in turned]


def _matrix_components(
    mass: Any, moment: Sequence[Any], inertia: Sequence[Sequence[Any]]
) -> list[Any]:
    coupling = _coupling_components(moment)
    upper = [[mass if j == i else S.Zero for j in range(3)] + coupling[i] for i in range(3)]
    lower = [[coupling[j][i] for j in range(3)] + list(inertia[i]) for i in range(3)]
    return [cell for row in (*upper, *lower) for cell in row]


def _centrifugal_components(moment: Sequence[Any]) -> list[Any]:
    """Acceleration d²(A c)/dt² at constant ω′."""
    flow = _spin_flow()
    return [flow(flow(x)) for x in rotate(elements(P), moment)]


def derive_rigid_body() -> Derivation:
    """Derivation of a body given by mass, centre and inertia: three mass points, (matrix-form).

    M (v̇, ω̇′) = h, (6, 6) and (6,), in the units and frames of :func:`newton_euler`, of the mass
    [kg], the centre (3,) [m] and the inertia (3, 3) [kg m²] about the origin, body frame.
    """
    body = BodyTerms(
        symbol(MASS),
        NamedMatrix("c", mul(symbol(MASS), symbol(R_AG_B))),
        symbol(I_A_B),
        symbol(FORCE),
        symbol(TORQUE_B),
    )
    matrix, right = newton_euler(body)
    (mass,), omega = elements(MASS), elements(OMEGA_B)
    moment = [mass * x for x in elements(R_AG_B)]
    cells = elements(I_A_B)
    inertia = [cells[3 * k : 3 * k + 3] for k in range(3)]
    gyroscopic = cross(omega, [dot(row, omega) for row in inertia])
    forces = [f - x for f, x in zip(elements(FORCE), _centrifugal_components(moment), strict=True)]
    torques = [n - x for n, x in zip(elements(TORQUE_B), gyroscopic, strict=True)]
    title = "rigid body"
    function = Function(
        "newton_euler",
        f"{title}: Newton-Euler equations",
        "M (a, dω′/dt) = h",
        f"{SOURCE}, (matrix-form)",
        (MASS, R_AG_B, I_A_B, P, OMEGA_B, FORCE, TORQUE_B),
        (
            output_of(MATRIX, matrix, _matrix_components(mass, moment, inertia)),
            output_of(RIGHT, right, [*forces, *torques]),
        ),
    )
    steps = (
        Step(MatrixSymbol("c", 3, 1), body.moment.value, "first moment", "centre-of-mass"),
        *motion_steps(body),
        *_form_steps(matrix, right),
        *reduction_steps(symbol(MASS), symbol(I_A_B), symbol(FORCE), symbol(TORQUE_B)),
    )
    return Derivation("rigid_body", "rigid_body", title, SOURCE, steps, (function,))


def _form_steps(matrix: SymbolicMatrix, right: SymbolicMatrix) -> tuple[Step, ...]:
    return (
        Step(MatrixSymbol("M", 6, 6), matrix, "mass matrix: M (a, dω′/dt) = h", "matrix-form"),
        Step(MatrixSymbol("h", 6, 1), right, "right-hand side", "matrix-form"),
    )


def derive_mass_points(n: int) -> Derivation:
    """Derivation of ``n`` mass points that are fixed in frame A.

    F = Σ f_k and N′ = Σ s̃′_k Aᵀ f_k (3,) [N, N m], I_A = Σ m_k s̃′_kᵀ s̃′_k (3, 3) [kg m²]: three
    mass points, (total-force), (torque-definition), (inertia); f_k in frame O, s′_k, N′ and I_A in
    the body frame.

    Parameters
    ----------
    n : int
        How many points, at least 1.

    Raises
    ------
    DerivationError
        There are fewer.
    """
    if n < 1:
        raise DerivationError(f"{n} mass points have no mass; give at least 1")
    points = _Points.of(n)
    body = points.body()
    matrix, right = newton_euler(body)
    title = f"{n} mass points"
    steps = (
        *balance_steps(points.masses, points.places, body),
        *_form_steps(matrix, right),
        *reduction_steps(body.mass, body.inertia, body.force, body.torque),
    )
    equations = Function(
        "newton_euler",
        f"{title}: Newton-Euler equations",
        "M (a, dω′/dt) = h",
        f"{SOURCE}, (matrix-form)",
        (points.m, points.s_b, P, OMEGA_B, points.f),
        (
            output_of(MATRIX, matrix, points.matrix_components()),
            output_of(RIGHT, right, points.right_components()),
        ),
    )
    functions = (_inertia(points, body, title), _resultant(points, body, title), equations)
    return Derivation("mass_points", "mass_points", title, SOURCE, steps, functions)


def _inertia(points: _Points, body: BodyTerms, title: str) -> Function:
    masses = elements(points.m)
    total = sum(masses, S.Zero)
    return Function(
        "inertia",
        f"{title}: total mass, centre, inertia",
        "mass = Σ m_k, mass r_AG = Σ m_k s′_k, I_A = Σ m_k s′_k~^T s′_k~",
        f"{SOURCE}, (total-mass), (centre-of-mass), (inertia)",
        (points.m, points.s_b),
        (
            output_of(MASS, body.mass, [total]),
            output_of(
                R_AG_B,
                mul(1 / body.mass, body.moment),
                [x / total for x in points.moment_components()],
            ),
            output_of(I_A_B, body.inertia, [x for row in points.inertia_components() for x in row]),
        ),
    )


def _resultant(points: _Points, body: BodyTerms, title: str) -> Function:
    return Function(
        "resultant",
        f"{title}: total force and torque",
        "F = Σ f_k, N′ = Σ s′_k~ A^T f_k",
        f"{SOURCE}, (total-force), (torque-definition)",
        (points.s_b, P, points.f),
        (
            output_of(FORCE, body.force, points.force_components()),
            output_of(TORQUE_B, body.torque, points.torque_components()),
        ),
    )


@dataclass(frozen=True, slots=True)
class _Points:
    """The arrays of n mass points on both levels."""

    m: Quantity
    s_b: Quantity
    f: Quantity

    @classmethod
    def of(cls, n: int) -> _Points:
        return cls(
            Quantity("m", (n,), "kg", "masses"),
            Quantity("s_b", (n, 3), "m", "places of the points, body frame, one a row"),
            Quantity("f", (n, 3), "N", "external forces on the points, frame O, one a row"),
        )

    def _row(self, quantity: Quantity, k: int) -> SymbolicMatrix:
        unit = [[Integer(k == row)] for row in range(quantity.shape[0])]
        return mul(transpose(symbol(quantity)), ImmutableDenseMatrix(unit))

    @property
    def masses(self) -> list[Scalar]:
        return [symbol(self.m)[k, 0] for k in range(self.m.size)]

    @property
    def places(self) -> list[SymbolicMatrix]:
        return [NamedMatrix(f"s_{k + 1}_b", self._row(self.s_b, k)) for k in range(self.m.size)]

    @property
    def forces(self) -> list[SymbolicMatrix]:
        return [NamedMatrix(f"f_{k + 1}", self._row(self.f, k)) for k in range(self.m.size)]

    def body(self) -> BodyTerms:
        pairs = list(zip(self.masses, self.places, strict=True))
        unit_inertias = (
            NamedMatrix(f"J_{k}", neg(mul(skew(s), skew(s)))) for k, s in enumerate(self.places, 1)
        )
        torques = (
            mul(skew(s), transpose(A), f) for s, f in zip(self.places, self.forces, strict=True)
        )
        return BodyTerms(
            NamedScalar("mass", sum(self.masses, S.Zero)),
            NamedMatrix("c", add(*(mul(m, s) for m, s in pairs))),
            NamedMatrix(
                "I_A", add(*(mul(m, j) for m, j in zip(self.masses, unit_inertias, strict=True)))
            ),
            NamedMatrix("F", add(*self.forces)),
            NamedMatrix("N_b", add(*torques)),
            NamedMatrix("K", add(*(mul(m, s, transpose(s)) for m, s in pairs))),
        )

    def _rows(self, quantity: Quantity) -> list[tuple[Any, ...]]:
        flat = elements(quantity)
        return [flat[3 * k : 3 * k + 3] for k in range(self.m.size)]

    def _sum(self, vectors: Sequence[Sequence[Any]]) -> list[Any]:
        return [sum(values, S.Zero) for values in zip(*vectors, strict=True)]

    def moment_components(self) -> list[Any]:
        masses, places = elements(self.m), self._rows(self.s_b)
        return self._sum([[m * x for x in s] for m, s in zip(masses, places, strict=True)])

    def _unit_velocities(self) -> list[list[list[Any]]]:
        """Velocities e_a × s_k for the three unit rotations a and all points k."""
        units = [[Integer(k == n) for n in range(3)] for k in range(3)]
        return [[cross(unit, s) for s in self._rows(self.s_b)] for unit in units]

    def inertia_components(self) -> list[list[Any]]:
        """Twice the kinetic energy of unit rotations, as a bilinear form."""
        velocities = self._unit_velocities()
        return [
            [
                sum((m * dot(u, v) for m, u, v in zip(elements(self.m), a, b, strict=True)), S.Zero)
                for b in velocities
            ]
            for a in velocities
        ]

    def matrix_components(self) -> list[Any]:
        return _matrix_components(
            sum(elements(self.m), S.Zero), self.moment_components(), self.inertia_components()
        )

    def force_components(self) -> list[Any]:
        return self._sum(self._rows(self.f))

    def torque_components(self) -> list[Any]:
        p = elements(P)
        pairs = zip(self._rows(self.s_b), self._rows(self.f), strict=True)
        return self._sum([cross(s, rotate_back(p, f)) for s, f in pairs])

    def right_components(self) -> list[Any]:
        """Right-hand side: forces less those that hold points on their circles at constant ω′."""
        omega = elements(OMEGA_B)
        circling = [cross(omega, cross(omega, s)) for s in self._rows(self.s_b)]
        torques = [
            sum(
                (m * dot(u, c) for m, u, c in zip(elements(self.m), a, circling, strict=True)),
                S.Zero,
            )
            for a in self._unit_velocities()
        ]
        forces = _centrifugal_components(self.moment_components())
        applied = [*self.force_components(), *self.torque_components()]
        return [x - y for x, y in zip(applied, [*forces, *torques], strict=True)]
