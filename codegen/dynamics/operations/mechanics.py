"""Rows of joints and bodies: operations on the blocks of two bodies, from the frozen kinds.

Each operation is a frozen record, so that equal operations on equal patterns share a kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.own_frames import framed
from kousoku.codegen.dynamics.recording.matrix import Matrix, square, stack
from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.records.own_kind import is_own, kind_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate
    from kousoku.model.operations.kernel import Kernel

#: Columns of a Jacobian for one body: δr in frame O, then δθ′ in the frame of the body.
COLUMNS = 6


@cache
def frozen(package: str, name: str) -> Kernel:
    """Kernel of a kind that is shipped, or of one's own, for principal frames."""
    derived = load_frozen(package)
    if is_own(package):
        derived = framed(derived, frozen("rotation", "orientation"))
    return next(kernel for kernel in derived.kernels if kernel.name == name)


def lengths_of(source: Instance | RelativeCoordinate) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Constants that are lengths [m], with ``i`` or ``j`` for points of a body, else ``""``.

    Points s′ (3,) of lecture 8.2, (8.8), are in the principal frame of the body, frame O of the
    ground.
    """
    scalars, points = {"length"}, {"s_i_b", "s_j_b"}
    if is_own(source.kind):
        lengths = [x for x in frozen(source.kind, "constraint").inputs if x.unit == "m"]
        scalars = {x.name for x in lengths if is_own(x.name) and not x.shape}
        fixed = {x.name[-4:] for x in lengths if is_own(x.name) and x.shape}
        ends = (("s_i_b", source.i), ("s_j_b", source.j))
        # The origin of frame O is no point of a joint.
        points = {name for name, body in ends if body != GROUND_INDEX or name[1:] in fixed}
    for name, values in source.constants:
        if name in points:
            yield name[2], values
        elif name in scalars:
            yield "", values


def inputs_of(source: Instance | RelativeCoordinate) -> tuple[tuple[str, tuple[float, ...]], ...]:
    """Constant inputs of kernels: kinds of one's own do not read s_i_b and s_j_b."""
    unread = {"s_i_b", "s_j_b"} if is_own(source.kind) else set()
    return tuple((name, values) for name, values in source.constants if name not in unread)


@dataclass(frozen=True, slots=True)
class InstanceRows:
    """The rows of one instance in a joint.

    Parameters
    ----------
    kind : str
        The package of its kind.
    rows : tuple of int
        The rows that are kept.
    constants : tuple of str
        Names of the inputs that are fixed; their blocks follow those of the bodies. A combination
        has none: what follows is its residual and its Jacobian body by body, or ν or γ.
    """

    kind: str
    rows: tuple[int, ...]
    constants: tuple[str, ...]

    @property
    def is_combination(self) -> bool:
        """Whether they combine coordinates, and have no kernels."""
        return self.kind == COMBINATION


@dataclass(frozen=True, slots=True)
class BodyOrientation:
    """A of one body, body components to frame O: lecture 7.1, (4.3). Blocks: p (4,) [-]."""

    title: str = "orientation"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """A (3, 3) [-]."""
        return (orientation_of(trace, blocks[0]),)


def orientation_of(trace: Trace, p: Matrix) -> Matrix:
    """Matrix A (3, 3) [-] of a body, p (4, 1): body components to frame O, lecture 7.1, (4.3)."""
    nodes = trace.inline(frozen("rotation", "orientation"), {"p": p.flat})["A"]
    return Matrix.of(trace.graph, nodes, 3)


def share(trace: Trace, p: Matrix, orientation: Matrix) -> None:
    """Let A (3, 3) [-] be read where a kind computes it from p (4, 1) [-]."""
    trace.is_known(orientation_of(trace, p).flat, orientation.flat)


def inputs_of_body(
    trace: Trace, body: str, r: Matrix, p: Matrix, orientation: Matrix, *motion: Matrix
) -> dict[str, Matrix]:
    """Inputs r and p of kernels for body ``i`` or ``j``, and of its motion v and ω′, by name.

    r (3,) [m], v (3,) [m/s] and A (3, 3) [-] are of frame O, p (4,) [-] and ω′ (3,) [rad/s] of the
    principal frame. A is read where a kind computes it from p, unless it has no entries.
    """
    if orientation.flat:
        share(trace, p, orientation)
    moving = zip((f"v_{body}", f"omega_{body}_b"), motion, strict=False)
    return {f"r_{body}": r, f"p_{body}": p, **dict(moving)}


def euler_rates(trace: Trace, p: Matrix, omega: Matrix) -> Matrix:
    """Rates ½ p ∘ (0, ω′) (4, 1), lecture 7.1, (5.16): [1/s] of ω′ [rad/s], [-] of a turn [rad]."""
    inputs = {"p": p.flat, "omega_b": omega.flat}
    return Matrix.of(trace.graph, trace.inline(frozen("rotation", "euler_rates"), inputs)["p_dot"])


def normalised(w: Matrix) -> Matrix:
    """Euler parameters w/|w| (4, 1) [-] of norm one."""
    graph = w.graph
    norm = graph.sqrt(graph.sum(graph.mul(x, x) for x in w.flat))
    return w @ Matrix.of(graph, [graph.div(graph.const(1), norm)])


def _title(parts: Sequence[InstanceRows]) -> str:
    return " + ".join(kind_name(part.kind) for part in parts)


def _evaluate(
    trace: Trace,
    part: InstanceRows,
    kernel: str,
    state: Mapping[str, Matrix],
    constants: Sequence[Matrix],
) -> dict[str, list[int]]:
    """Inline a kernel of a part."""
    inputs = {name: block.flat for name, block in state.items()}
    fixed = (block.flat for block in constants)
    inputs |= dict(zip(part.constants, fixed, strict=True))
    return trace.inline(frozen(part.kind, kernel), inputs)


def _kept_rows(trace: Trace, nodes: Sequence[int], part: InstanceRows, width: int) -> Matrix:
    """Kept rows of an output."""
    rows = tuple(tuple(nodes[row * width : (row + 1) * width]) for row in part.rows)
    return Matrix(trace.graph, rows, width)


@dataclass(frozen=True, slots=True)
class JointSystem:
    """Residual, Jacobian, and the joint's own block of the Schur complement S = C_q M⁻¹ C_qᵀ.

    Blocks: r (3,) [m], p (4,), A (3, 3) and the diagonal of M⁻¹ (1, c) [1/kg, 1/(kg m²)] of body i,
    those of body j, that diagonal of the other bodies, R of each body that is reduced, and the
    operands of the parts. A body that is reduced has (Rᵀ M R)⁻¹ for M⁻¹. C is that of the kinds,
    lecture 8.2, (8.9) to (8.16); C_q has the columns δr in frame O, δθ′ in the principal frame.

    Parameters
    ----------
    parts : tuple of InstanceRows
        Rows of the constraints that the joint is composed of.
    columns : tuple of tuple of int
        Columns of each body that are coordinates: none of the ground.
    reduced : tuple of int
        Which of the bodies have velocities R u.
    """

    parts: tuple[InstanceRows, ...]
    columns: tuple[tuple[int, ...], ...]
    reduced: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        """Name the kinds."""
        return f"joint {_title(self.parts)}: C, C_q, C_q M^-1, C_q M^-1 C_q^T"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """C (n,), C_q (n, c) of i, of j and of the others, C_q M⁻¹ of them, C_q M⁻¹ C_qᵀ (n, n).

        Of a body that is reduced it is C_q R and C_q R (Rᵀ M R)⁻¹; C_q itself stands last.
        """
        others, count = len(self.columns) - 2, len(self.reduced)
        rest = blocks[8:]
        inverse_masses = (blocks[3], blocks[7], *rest[:others])
        bases = dict(zip(self.reduced, rest[others : others + count], strict=True))
        residuals, full = rows_of_parts(
            trace, self.parts, self.columns, (*blocks[:3], *blocks[4:7], *rest[others + count :])
        )
        jacobians = [c_q @ bases[k] if k in bases else c_q for k, c_q in enumerate(full)]
        scaled = [
            block @ inverse if k in bases else block.scaled(inverse)
            for k, (block, inverse) in enumerate(zip(jacobians, inverse_masses, strict=True))
        ]
        pairs = list(zip(scaled, jacobians, strict=True))
        graph = trace.graph
        lower = [
            [graph.sum(_dot(a, b, i, j) for a, b in pairs) for j in range(i + 1)]
            for i in range(len(jacobians[0].rows))
        ]
        unreduced = [full[k] for k in self.reduced]
        return residuals, *jacobians, *scaled, square(lower, graph), *unreduced


@dataclass(frozen=True, slots=True)
class JointRows:
    """Residual C and Jacobian C_q alone, δC = C_q (δr, δθ′). Blocks: r, p, A of i, j, of parts.

    Shapes, units, frames and the source are those of :class:`JointSystem`.

    Parameters
    ----------
    parts : tuple of InstanceRows
        Rows of the constraints that the joint is composed of.
    columns : tuple of tuple of int
        Columns of each body that are coordinates: none of the ground.
    """

    parts: tuple[InstanceRows, ...]
    columns: tuple[tuple[int, ...], ...]

    @property
    def title(self) -> str:
        """Name the kinds."""
        return f"rows {_title(self.parts)}: C, C_q"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """C (n,) [m, rad or -], C_q (n, c) of i, of j and of the others."""
        residuals, jacobians = rows_of_parts(trace, self.parts, self.columns, blocks)
        return residuals, *jacobians


def rows_of_parts(
    trace: Trace,
    parts: Sequence[InstanceRows],
    columns: Sequence[tuple[int, ...]],
    blocks: Sequence[Matrix],
) -> tuple[Matrix, list[Matrix]]:
    """C (n,) [m, rad or -] and C_q (n, c) by body of the parts of a joint: δC = C_q (δr, δθ′).

    δr [m] is in frame O, δθ′ [rad] in the principal frame; each kind has its equation of lecture
    8.2.
    """
    i, j, operands = blocks[:3], blocks[3:6], iter(blocks[6:])
    state = inputs_of_body(trace, "i", *i) | inputs_of_body(trace, "j", *j)
    residuals: list[Matrix] = []
    by_body: list[list[Matrix]] = [[] for _ in columns]
    for part in parts:
        if part.is_combination:
            residuals.append(next(operands))
            c_q = [next(operands) for _ in columns]
        else:
            constants = [next(operands) for _ in part.constants]
            outputs = _evaluate(trace, part, "constraint", state, constants)
            residuals.append(_kept_rows(trace, outputs["C"], part, 1))
            c_q = _by_body(_kept_rows(trace, outputs["C_q"], part, 2 * COLUMNS), columns)
        for body, matrix in zip(by_body, c_q, strict=True):
            body.append(matrix)
    graph = trace.graph
    jacobians = [stack(graph, rows, len(kept)) for rows, kept in zip(by_body, columns, strict=True)]
    return stack(graph, residuals, 1), jacobians


def _by_body(jacobian: Matrix, columns: Sequence[tuple[int, ...]]) -> list[Matrix]:
    """Cut the Jacobian of a kind, which knows bodies i and j only."""
    blocks = [
        jacobian.columns([side * COLUMNS + k for k in kept])
        for side, kept in enumerate(columns[:2])
    ]
    zero = jacobian.graph.const(0)
    for kept in columns[2:]:
        rows = ((zero,) * len(kept),) * len(jacobian.rows)
        blocks.append(Matrix(jacobian.graph, rows, len(kept)))
    return blocks


def _dot(a: Matrix, b: Matrix, i: int, j: int) -> int:
    graph = a.graph
    return graph.sum(graph.mul(x, y) for x, y in zip(a.rows[i], b.rows[j], strict=True))


@dataclass(frozen=True, slots=True)
class Rates:
    """Difference C_q x − ν or C_q x − γ of a joint, x being velocities or accelerations.

    Blocks: p, A, v (3,) [m/s] in frame O and ω′ (3,) [rad/s] in the principal frame of body i, then
    its x and its Jacobian; the same of body j; r of both; x and Jacobian of each other body; then
    the operands of the parts.

    Parameters
    ----------
    parts : tuple of InstanceRows
        Rows of the constraints that the joint is composed of.
    output : str
        ``nu`` for C_q v − ν, ``gamma`` for C_q M⁻¹f − γ: Ċ = C_q v − ν and C̈ = C_q v̇ − γ.
    others : int
        Bodies beside i and j.
    """

    parts: tuple[InstanceRows, ...]
    output: str
    others: int = 0

    @property
    def title(self) -> str:
        """Name the output and the kinds."""
        return f"{self.output} {_title(self.parts)}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Difference (n,) [unit of C per s or s²]."""
        (*i, x_i, left), (*j, x_j, right) = blocks[:6], blocks[6:12]
        r_i, r_j, *rest = blocks[12:]
        state = inputs_of_body(trace, "i", r_i, *i) | inputs_of_body(trace, "j", r_j, *j)
        others, operands = rest[: 2 * self.others], iter(rest[2 * self.others :])
        rates = []
        for part in self.parts:
            if part.is_combination:
                rates.append(next(operands))
            else:
                constants = [next(operands) for _ in part.constants]
                outputs = _evaluate(trace, part, "rates", state, constants)
                rates.append(_kept_rows(trace, outputs[self.output], part, 1))
        total = left @ x_i + right @ x_j
        for x, jacobian in zip(others[::2], others[1::2], strict=True):
            total += jacobian @ x
        return (total - stack(trace.graph, rates, 1),)


@dataclass(frozen=True, slots=True)
class FreeAcceleration:
    """M⁻¹f of a body under gravity. Blocks: gravity, ω′, ratios such as (I₂ − I₃)/I₁.

    Gravity (3,) [m/s²] is in frame O, ω′ (3,) [rad/s] and the ratios (3,) [-] in the principal
    frame; three mass points, (newton-euler-moment).

    Parameters
    ----------
    columns : tuple of int
        The body's coordinates.
    """

    columns: tuple[int, ...]
    title: str = "free acceleration"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Acceleration of each coordinate, (c,) [m/s², rad/s²], with I dω′/dt = −ω′ × I ω′."""
        gravity, omega, ratios = (block.flat for block in blocks)
        mul = trace.graph.mul
        spin = [
            mul(ratios[k], mul(omega[(k + 1) % 3], omega[(k + 2) % 3])) for k in range(len(omega))
        ]
        full = (*gravity, *spin)
        return (Matrix.of(trace.graph, [full[k] for k in self.columns]),)


@dataclass(frozen=True, slots=True)
class PoseRate:
    """Time derivative of the coordinates. Blocks: p, v, ω′, as far as there are any.

    p (4,) [-], v (3,) [m/s] in frame O, ω′ (3,) [rad/s] in the principal frame; lecture 7.1,
    (5.16).

    Parameters
    ----------
    coordinates : tuple of int
        Places in (r, p) that are coordinates.
    """

    coordinates: tuple[int, ...]
    title: str = "motion"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Rates (v, ½ p ∘ (0, ω′)) at the coordinates, (c,) [m/s, 1/s]."""
        p, v, omega = blocks
        full = (*v.flat, *euler_rates(trace, p, omega).flat)
        return (Matrix.of(trace.graph, [full[k] for k in self.coordinates]),)


@dataclass(frozen=True, slots=True)
class Move:
    """Coordinates after a correction. Blocks: r, p, δr, δθ′.

    r (3,), δr (3,) [m] are in frame O, δθ′ (3,) [rad] in the principal frame: updated on the right.

    Parameters
    ----------
    coordinates : tuple of int
        Places in (r, p) that are coordinates.
    """

    coordinates: tuple[int, ...]
    title: str = "move"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Moved position: r + δr and w/|w|, w = p ∘ (1, ½ δθ′), its coordinates (c,) [m, -]."""
        r, p, dr, dtheta = blocks
        moved = list((r + dr).flat)
        if any(place > 2 for place in self.coordinates):
            moved += normalised(p + euler_rates(trace, p, dtheta)).flat
        return (Matrix.of(trace.graph, [moved[k] for k in self.coordinates]),)


@dataclass(frozen=True, slots=True)
class Energy:
    """Energy of a body. Blocks: r, v, ω′, half the mass and moments, and minus the weight.

    r (3,) [m], v (3,) [m/s] and −m g (3,) [N] are in frame O, ω′ (3,) [rad/s] in the principal
    frame.
    """

    title: str = "energy"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Kinetic and potential energy (2,) [J]: ½ m v·v + ½ ω′·I ω′, −m g·r."""
        r, v, omega, halves, weight = (block.flat for block in blocks)
        graph = trace.graph
        kinetic = graph.sum(
            graph.mul(half, graph.mul(x, x)) for half, x in zip(halves, (*v, *omega), strict=True)
        )
        potential = graph.sum(graph.mul(a, b) for a, b in zip(weight, r, strict=True))
        return (Matrix.of(graph, [kinetic, potential]),)
