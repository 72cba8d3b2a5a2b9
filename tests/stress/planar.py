"""Planar bodies on hinges and springs: accelerations and forces in 60 digits, by hand.

Nothing here is kousoku's: a body has the angle φ of its frame, each hinge two rows, and the
equations M a + C_qᵀ λ = f, C_q a = γ are solved as one dense system.

The independent evaluator says the same of a loop to 40 digits (``test_independent.py``), and is no
substitute: it takes 0.44 s where this takes 0.012 s, a scene of `extremes` asks 21 times, and rows
that are 1e-12 from dependent ones it takes as dependent, where these are solved as they stand.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import mpmath

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    Pair = Sequence[float]

MP = mpmath.mp.clone()
MP.dps = 60
GROUND = "ground"


@dataclass(frozen=True, slots=True)
class Bar:
    """A body: where it is drawn, its mass, its centre in its own frame, its moment about that."""

    at: Pair
    mass: float
    center: Pair
    moment: float
    angle: float = 0.0
    omega: float = 0.0


@dataclass(frozen=True, slots=True)
class Hinge:
    """Two bodies and the point that they share, in the frame of each."""

    i: str
    j: str
    s_i: Pair
    s_j: Pair


@dataclass(frozen=True, slots=True)
class Spring:
    """A spring between points of two bodies, with its stiffness and its free length."""

    i: str
    j: str
    s_i: Pair
    s_j: Pair
    stiffness: float
    free: float


@dataclass(frozen=True, slots=True)
class State:
    """A body's origin, angle, and their rates."""

    r: Sequence[Any]
    angle: Any
    v: Sequence[Any]
    omega: Any


@dataclass(frozen=True, slots=True)
class Scene:
    """Bodies, hinges and springs in the plane, under gravity along −y.

    Parameters
    ----------
    bars, hinges, springs : mapping
        By name.
    gravity : float
        In m/s².
    nearly : float
        By how much rows are not redundant that are so without it, in metres or radians.
    leans : bool
        Whether that is how far the axis of the last hinge leans.
    """

    bars: Mapping[str, Bar]
    hinges: Mapping[str, Hinge]
    springs: Mapping[str, Spring] = field(default_factory=dict)
    gravity: float = 9.81
    nearly: float = 0.0
    leans: bool = False

    def without(self, hinge: str) -> Scene:
        """Scene without a hinge."""
        kept = {name: x for name, x in self.hinges.items() if name != hinge}
        return replace(self, hinges=kept)

    @property
    def tree(self) -> dict[str, Any]:
        """The scene as kousoku reads it; the last hinge is the one that leans."""
        last = [*self.hinges][-1]
        return {
            "name": "planar",
            "unit": "m",
            "gravity": [0, -self.gravity, 0],
            "outputs": ["accelerations", "reactions", "energies"],
            "bodies": {
                name: {
                    "position": [*bar.at, 0],
                    "orientation": {"axis": [0, 0, 1], "angle": bar.angle},
                    "mass": bar.mass,
                    "center": [*bar.center, 0],
                    "inertia": dict.fromkeys(("xx", "yy", "zz"), bar.moment),
                    "angular_velocity": [0, 0, bar.omega],
                }
                for name, bar in self.bars.items()
            },
            "joints": {
                name: {
                    "type": "hinge",
                    "bodies": [hinge.i, hinge.j],
                    "points": [[*hinge.s_i, 0], [*hinge.s_j, 0]],
                    "axis": [self.nearly * (self.leans and name == last), 0, 1],
                }
                for name, hinge in self.hinges.items()
            },
            "forces": {
                name: {
                    "type": "spring_damper",
                    "bodies": [spring.i, spring.j],
                    "points": [[*spring.s_i, 0], [*spring.s_j, 0]],
                    "stiffness": spring.stiffness,
                    "free_length": spring.free,
                }
                for name, spring in self.springs.items()
            },
        }


@dataclass(frozen=True, slots=True)
class Solution:
    """What the equations give.

    Parameters
    ----------
    accelerations : dict of str to tuple
        Of each body's origin along x and y, and of its angle.
    forces : dict of str to tuple
        Of each hinge on body j, along x and y.
    """

    accelerations: dict[str, tuple[Any, Any, Any]]
    forces: dict[str, tuple[Any, Any]]

    def numbers(self) -> dict[str, Any]:
        """All numbers by name."""
        found: dict[str, Any] = {}
        for name, values in self.accelerations.items():
            found |= {f"{name}.{k}": x for k, x in zip(("ax", "ay", "alpha"), values, strict=True)}
        for name, pair in self.forces.items():
            found |= {f"{name}.{k}": x for k, x in zip(("fx", "fy"), pair, strict=True)}
        return found


Factor = Callable[[], Any]


def _once() -> Any:
    return MP.one


def solution(scene: Scene, states: Mapping[str, State], factor: Factor = _once) -> Solution:
    """Accelerations and forces at a state, in 60 digits.

    Parameters
    ----------
    scene : Scene
        Whose numbers are taken as the doubles that they are.
    states : mapping of str to State
        Of each body.
    factor : callable
        By what each number is multiplied as it is read: 1, or 1 ± u to see what rounding costs.

    Raises
    ------
    ZeroDivisionError
        The rows are dependent.
    """
    names = [*scene.bars]
    motions = {name: _motion(states[name], factor) for name in names}
    motions[GROUND] = _motion(State((0, 0), 0, (0, 0), 0), _once)
    n, m = 3 * len(names), 2 * len(scene.hinges)
    matrix, right = MP.zeros(n + m, n + m), MP.zeros(n + m, 1)
    fall = MP.mpf(scene.gravity) * factor()
    centers = {}
    for k, (name, bar) in enumerate(scene.bars.items()):
        mass, moment = MP.mpf(bar.mass) * factor(), MP.mpf(bar.moment) * factor()
        for row, x in enumerate((mass, mass, moment)):
            matrix[3 * k + row, 3 * k + row] = x
        right[3 * k + 1] = -mass * fall
        centers[name] = _read(bar.center, factor)
    centers[GROUND] = (MP.zero, MP.zero)
    for spring in scene.springs.values():
        _pull(scene, spring, motions, centers, right, factor)
    for h, hinge in enumerate(scene.hinges.values()):
        for sign, name, point in ((-1, hinge.i, hinge.s_i), (1, hinge.j, hinge.s_j)):
            s = _read(point, factor)
            if name == GROUND:
                continue
            k, motion = names.index(name), motions[name]
            arm = motion.turned((s[0] - centers[name][0], s[1] - centers[name][1]))
            for axis, lever in enumerate((-arm[1], arm[0])):
                row = n + 2 * h + axis
                for column, x in ((3 * k + axis, MP.one), (3 * k + 2, lever)):
                    matrix[row, column] += sign * x
                    matrix[column, row] += sign * x
                right[row] += sign * motion.omega**2 * arm[axis]
    found: Any = MP.lu_solve(matrix, right)
    accelerations: dict[str, tuple[Any, Any, Any]] = {}
    forces: dict[str, tuple[Any, Any]] = {}
    for k, name in enumerate(names):
        x, y, alpha = (found[3 * k + j] for j in range(3))
        c, rate = motions[name].turned(centers[name]), motions[name].omega
        accelerations[name] = (
            x + alpha * c[1] + rate**2 * c[0],
            y - alpha * c[0] + rate**2 * c[1],
            alpha,
        )
    for h, name in enumerate(scene.hinges):
        forces[name] = (-found[n + 2 * h], -found[n + 2 * h + 1])
    return Solution(accelerations, forces)


@dataclass(frozen=True, slots=True)
class _Motion:
    r: tuple[Any, ...]
    v: tuple[Any, ...]
    cos: Any
    sin: Any
    omega: Any

    def turned(self, s: Sequence[Any]) -> tuple[Any, Any]:
        return self.cos * s[0] - self.sin * s[1], self.sin * s[0] + self.cos * s[1]

    def point(self, s: Sequence[Any]) -> tuple[Any, Any]:
        x, y = self.turned(s)
        return self.r[0] + x, self.r[1] + y


def _read(numbers: Sequence[Any], factor: Factor) -> tuple[Any, ...]:
    return tuple(MP.mpf(x) * factor() for x in numbers)


def _motion(state: State, factor: Factor) -> _Motion:
    angle = MP.mpf(state.angle) + (factor() - 1)
    (omega,) = _read((state.omega,), factor)
    return _Motion(
        _read(state.r, factor), _read(state.v, factor), MP.cos(angle), MP.sin(angle), omega
    )


def _pull(
    scene: Scene,
    spring: Spring,
    motions: Mapping[str, _Motion],
    centers: Mapping[str, Sequence[Any]],
    right: Any,
    factor: Factor,
) -> None:
    """Add what a spring does to its bodies."""
    ends = [(spring.i, _read(spring.s_i, factor)), (spring.j, _read(spring.s_j, factor))]
    (a, b), (c, d) = (motions[name].point(s) for name, s in ends)
    line = (c - a, d - b)
    size = MP.hypot(*line)
    stiffness, free = _read((spring.stiffness, spring.free), factor)
    tension = stiffness * (size - free)
    for sign, (name, s) in zip((1, -1), ends, strict=True):
        if name == GROUND or size == 0:
            continue
        k = [*scene.bars].index(name)
        center = centers[name]
        arm = motions[name].turned((s[0] - center[0], s[1] - center[1]))
        fx, fy = (sign * tension * x / size for x in line)
        right[3 * k] += fx
        right[3 * k + 1] += fy
        right[3 * k + 2] += arm[0] * fy - arm[1] * fx


def units(scene: Scene, states: Mapping[str, State], seed: int, samples: int = 6) -> dict[str, Any]:
    """Change of each number that rounding all that is given can make, about.

    Changes of ±u of each number, of random sign, are tried; the largest is taken, twice.
    """
    draw = random.Random(seed)

    def rounded() -> Any:
        return 1 + draw.choice((-1, 1)) * MP.mpf(2) ** -53

    exact = solution(scene, states).numbers()
    found = {name: size * MP.mpf(2) ** -53 for name, size in _sizes(scene, states, exact).items()}
    for _ in range(samples):
        other = solution(scene, states, factor=rounded).numbers()
        for name, x in other.items():
            found[name] = max(found[name], 2 * abs(x - exact[name]))
    return found


def _sizes(scene: Scene, states: Mapping[str, State], exact: Mapping[str, Any]) -> dict[str, Any]:
    """Largest of each number's kind, which a solver's roundings are parts of.

    The acceleration of an origin is that of the centre less what the body turns; they may cancel.
    """
    sizes: dict[str, Any] = {}
    for name, bar in scene.bars.items():
        alpha, line = exact[f"{name}.alpha"], MP.hypot(exact[f"{name}.ax"], exact[f"{name}.ay"])
        turned = MP.hypot(*bar.center) * (abs(alpha) + MP.mpf(states[name].omega) ** 2)
        for kind, size in (("alpha", abs(alpha)), ("ax", line + turned), ("ay", line + turned)):
            sizes[kind] = max(sizes.get(kind, MP.zero), size)
    for name in scene.hinges:
        for kind in ("fx", "fy"):
            size = MP.hypot(exact[f"{name}.fx"], exact[f"{name}.fy"])
            sizes[kind] = max(sizes.get(kind, MP.zero), size)
    return {name: sizes[name.split(".")[1]] for name in exact}
