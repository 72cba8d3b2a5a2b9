"""Operations of bodies with velocities v = R u + β: projections onto their joint with the ground.

R has the columns of the freedoms of the joint: turns with (A (s′ × a′), a′) for each axis a′, s′
being the point of the joint in the body, and a displacement with (a, 0). A turn about an axis is
taken from ω′ by a′ᵀω′, a displacement from v by aᵀv. The remainder is removed by the vectors across
the axis, so that rounding of the axis itself neither speeds up nor slows down.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from kousoku.codegen.dynamics.operations.mechanics import euler_rates, normalised, orientation_of
from kousoku.codegen.dynamics.recording.matrix import Matrix, stack

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace

Block = TypeVar("Block")

#: What a body on a joint with the ground can rotate about.
NOTHING, AXIS, POINT = "nothing", "an axis", "a point"


class GroundJointBlocks(NamedTuple, Generic[Block]):
    """Blocks of a joint with the ground, with its numbers at the start.

    :class:`~kousoku.codegen.dynamics.simplification.ground_joints.VelocityTransformation` has
    the numbers.

    Parameters
    ----------
    point, point_b : (3,) [m]
        The point of the joint: place in frame O, and s′ in the principal frame of the body.
    p, r : (4,) [-] and (3,) [m]
        Euler parameters and centre of mass of the body, frame O.
    across : (3, n) [-]
        Vectors across the axis in frame O, by columns.
    beside : (4, n) [-]
        p ∘ (0, b′) of vectors b′ across the axis: no turn about it has any of these.
    p_turned : (4,) [-]
        p ∘ (0, a′).
    axis : (3,) [-]
        a, in frame O.
    """

    point: Block
    point_b: Block
    p: Block
    r: Block
    across: Block
    beside: Block
    p_turned: Block
    axis: Block


@dataclass(frozen=True, slots=True)
class ProjectPosition:
    """Position on the joint: r = r_joint − A s′ + a x, lecture 7.1, (4.3).

    Blocks: r (3,) [m] in frame O, p (4,) [-], δr (3,) [m] in frame O, δθ′ (3,) [rad] in the
    principal frame, of p ∘ (1, ½ δθ′), (5.16); those of :class:`GroundJointBlocks`; then the
    driven turn [rad] and displacement x [m].

    Parameters
    ----------
    coordinates : tuple of int
        Places in (r, p) that are coordinates.
    rotates_about : str
        Axis, point or nothing that the body rotates about.
    slides, drives_rotation, drives_slide : bool
        Whether it can be displaced, and which motions are driven.
    """

    coordinates: tuple[int, ...]
    rotates_about: str
    slides: bool
    drives_rotation: bool
    drives_slide: bool
    title: str = "onto the joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Position r, p that meets the joint, p of norm one: its coordinates, (c,) [m, -]."""
        (r, p, dr, dtheta), joint = blocks[:4], GroundJointBlocks(*blocks[4:12])
        graph, driven = trace.graph, iter(blocks[12:])
        if self.rotates_about == NOTHING:
            euler, foot = joint.p, joint.r
        else:
            if self.drives_rotation:
                half = graph.div(next(driven).flat[0], graph.const(2))
                cosine, sine = (Matrix.of(graph, [x]) for x in (graph.cos(half), graph.sin(half)))
                euler = joint.p @ cosine + joint.p_turned @ sine
            else:
                euler = self._turned(trace, p, dtheta, joint.beside)
            foot = joint.point - orientation_of(trace, euler) @ joint.point_b
        if self.drives_slide:
            foot += joint.axis @ next(driven)
        elif self.slides:
            moved = r + dr
            foot = moved - joint.across @ (joint.across.T @ (moved - foot))
        rows = (*foot.rows, *euler.rows)
        return (Matrix(graph, tuple(rows[k] for k in self.coordinates), 1),)

    def _turned(self, trace: Trace, p: Matrix, dtheta: Matrix, beside: Matrix) -> Matrix:
        """Euler parameters p ∘ (1, ½ δθ′), of turns about the axis alone, of norm one."""
        new = p + euler_rates(trace, p, dtheta)
        if self.rotates_about == AXIS:
            new -= beside @ (beside.T @ new)
        return normalised(new)


@dataclass(frozen=True, slots=True)
class ProjectVelocity:
    """Velocities v = R u + β that fit the joint, u = (Rᵀ M R)⁻¹ Rᵀ M (v − β).

    Blocks: v (3,) [m/s] in frame O, ω′ (3,) [rad/s] in the principal frame, the arm (3, k) [m],
    a′ and a by columns, the vectors across each of them, (Rᵀ M R)⁻¹ m [1/m²] of k turns, and (Rᵀ
    M R)⁻¹ a′ᵀ I′ where the axis is skew; then the rates that drive turn and displacement.

    The change is least in the metric of the masses, as the correction by all rows: a turn follows
    from both ω′ and v.

    Parameters
    ----------
    columns : tuple of int
        The body's columns.
    rotates_about : str
        Axis, point or nothing that it rotates about.
    slides, drives_rotation, drives_slide : bool
        Whether it can be displaced, and which motions are driven.
    is_skew : bool
        Whether a′ is no principal axis: ω′ across it contributes to the turn, too.
    """

    columns: tuple[int, ...]
    rotates_about: str
    slides: bool
    drives_rotation: bool
    drives_slide: bool
    is_skew: bool
    title: str = "velocity on the joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Velocities u (f,), the differences R u + β − v, and β, (c,) [m/s, rad/s]."""
        v, omega, arm, axis_b, axis, across_b, across, masses, *rest = blocks
        graph, operands = trace.graph, iter(rest)
        free: list[Matrix] = []
        zero = v - v
        beta, spin = zero, zero
        if self.rotates_about == NOTHING:
            turning, d_omega = zero, -omega
        elif self.drives_rotation:
            rate = next(operands)
            beta, spin = arm @ rate, axis_b @ rate
            turning, d_omega = beta, spin - omega
        else:
            turn = axis_b.T @ omega
            correction = masses @ (arm.T @ (v - arm @ turn))
            if self.is_skew:
                correction += next(operands) @ (omega - axis_b @ turn)
            d_omega = axis_b @ correction
            if self.rotates_about == AXIS:
                d_omega -= across_b @ (across_b.T @ omega)
            free.append(turn + correction)
            turning = arm @ free[0]
        if self.drives_slide:
            slide = axis @ next(operands)
            beta += slide
            d_v = turning + slide - v
        elif self.slides:
            free.append(axis.T @ v)
            d_v = turning - across @ (across.T @ v)
        else:
            d_v = turning - v
        return (
            stack(graph, free, 1),
            _selected(d_v, d_omega, self.columns),
            _selected(beta, spin, self.columns),
        )


@dataclass(frozen=True, slots=True)
class BiasAcceleration:
    """Bias acceleration η, of u̇ = 0: v̇ = R u̇ + η.

    Blocks: ω′ (3,) [rad/s] in the principal frame, the arm (3, k) [m] in frame O, A (3, 3) [-],
    axes a′ in the principal frame and a in frame O by columns [-], the point s′ (3,) [m] of the
    joint in the principal frame; then the second derivatives that drive turn and
    displacement. About a point it is A (ω′ × (s′ × ω′)), about an axis a × arm u².

    Parameters
    ----------
    columns : tuple of int
        The body's columns.
    rotates_about : str
        Axis, point or nothing that it rotates about.
    drives_rotation, drives_slide : bool
        Which motions are driven.
    """

    columns: tuple[int, ...]
    rotates_about: str
    drives_rotation: bool
    drives_slide: bool
    title: str = "acceleration on the joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Bias acceleration η in the columns, (c,) [m/s², rad/s²]."""
        omega, arm, orientation, axis_b, axis, point, *rates = blocks
        driven = iter(rates)
        zero = omega - omega
        linear, angular = zero, zero
        if self.rotates_about == POINT:
            linear = orientation @ omega.cross(point.cross(omega))
        elif self.rotates_about == AXIS:
            rate = axis_b.T @ omega
            linear = axis.cross(arm) @ (rate @ rate)
        if self.drives_rotation:
            second = next(driven)
            linear, angular = linear + arm @ second, axis_b @ second
        if self.drives_slide:
            linear += axis @ next(driven)
        return (_selected(linear, angular, self.columns),)


@dataclass(frozen=True, slots=True)
class ReduceForces:
    """Rates u̇ (f,) of a body without other joints: Rᵀ M R u̇ = Rᵀ (f − M η).

    Blocks: M⁻¹f in the columns (c,) [m/s², rad/s²], δr in frame O and δθ′ in the principal frame,
    the arm (3, k) [m] and a (3,) in frame O, η in the columns, then (Rᵀ M R)⁻¹ m and (Rᵀ M R)⁻¹
    a′ᵀ I′ of k turns.

    Parameters
    ----------
    columns : tuple of int
        The body's columns.
    rotates_about : str
        Axis, point or nothing that it rotates about.
    slides : bool
        Whether it can be displaced.
    """

    columns: tuple[int, ...]
    rotates_about: str
    slides: bool
    title: str = "free acceleration on the joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Accelerations (Rᵀ M R)⁻¹ Rᵀ M (M⁻¹f − η) (f,) of all turns and the displacement."""
        free, arm, axis, eta, masses, moments = blocks
        if self.rotates_about == POINT:  # else Rᵀ M η is zero for what is free
            free -= eta
        graph = trace.graph
        full = [graph.const(0)] * 6
        for index, node in zip(self.columns, free.flat, strict=True):
            full[index] = node
        linear, angular = (Matrix.of(graph, full[k : k + 3]) for k in (0, 3))
        rates = []
        if self.rotates_about != NOTHING:
            rates.append(masses @ (arm.T @ linear) + moments @ angular)
        if self.slides:
            rates.append(axis.T @ linear)
        return (stack(graph, rates, 1),)


@dataclass(frozen=True, slots=True)
class DriverPower:
    """Power of the driver of a freedom.

    Blocks: its mass m (1, 1) [kg or kg m²], ü that it prescribes, u̇ without it, its column (c, 1)
    of R, forces of all other joints, −Σ C_qᵀλ (c,) [N in frame O, N m in the principal frame], and
    the rate.
    """

    title: str = "power of a driver of a joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Power (m (ü − u̇) − Rᵀ(−Σ C_qᵀλ)) · rate [W]."""
        mass, second, free, column, others, rate = blocks
        effort = mass @ (second - free) - column.T @ others
        return (effort @ rate,)


@dataclass(frozen=True, slots=True)
class JointWrench:
    """Wrench w of the joint and its drivers on the body: M v̇ + Σ C_qᵀλ = f + w.

    Blocks: the diagonal of M (1, c) [kg, kg m²], v̇ (c,) and M⁻¹f (c,) [m/s², rad/s²], forces of
    all other joints, −Σ C_qᵀλ (c,): [N] in frame O, [N m] in the principal frame.
    """

    title: str = "force of a joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """M v̇ − f + Σ C_qᵀλ in the columns, (c,): [N] in frame O, [N m] in the principal frame."""
        masses, second, free, others = blocks
        return ((second - free).T.scaled(masses).T - others,)


@dataclass(frozen=True, slots=True)
class DriverWrench:
    """Share Jᵀ (Rᵀ w) of a driver in the wrench w. Blocks: w, a column of R, J of the coordinate.

    w (c,) is [N] in frame O, [N m] in the principal frame, as is the share.

    Parameters
    ----------
    sign : int
        Of the freedom in the coordinate that is driven.
    """

    sign: int
    title: str = "force of a driver of a joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Wrench of the driver, and the rest for others, (c,)."""
        wrench, column, jacobian = blocks
        effort = column.T @ wrench
        share = jacobian.T @ (effort if self.sign > 0 else -effort)
        return share, wrench - share


@dataclass(frozen=True, slots=True)
class PrescribedValue:
    """Value of a driven freedom, u = ±(f(t) − u₀). Blocks: its formula, and u₀ at the start.

    Parameters
    ----------
    sign : int
        Of the freedom in the coordinate that is driven.
    """

    sign: int
    title: str = "driven joint with the ground"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Turn or displacement (1,) [rad or m] since the start, or derivatives where u₀ is zero."""
        law, start = blocks
        difference = law - start
        return (difference if self.sign > 0 else -difference,)


def _selected(linear: Matrix, angular: Matrix, columns: Sequence[int]) -> Matrix:
    """Components of a linear and an angular vector in the columns of a body."""
    rows = (*linear.rows, *angular.rows)
    return Matrix(linear.graph, tuple(rows[k] for k in columns), 1)
