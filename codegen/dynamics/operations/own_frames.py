"""Kernels of one's own for bodies whose frames are the principal ones.

A constraint is stated in the frames that a scene gives to its bodies: r is where their origin is.
A solver moves centres of mass and principal axes. With the origin s′ of the stated frame and the
rotation R from it to the principal frame it is

    r̂ = r + A s′,  Â = A R,  v̂ = v + A (ω′ × s′),  ω̂′ = Rᵀ ω′,

by Ȧ = A ω̃′, lecture 7.1, (5.16). By (7.19) a row (f, n) of its Jacobian at r̂ and Â is here
(f, R n + s′ × Aᵀ f). The accelerations of r̂ hold A (ω′ × (ω′ × s′)) beside the products of the
new Jacobian, so

    γ = γ̂ − Σ f · A (ω′ × (ω′ × s′)),

summed over the two bodies. Where both frames are the same all of it folds away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix, stack
from kousoku.codegen.passes.rebuild import drop_dead, substitute
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.records.own_kind import FRAMES, ORIGINS, input_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.kernel import Kernel, Package

#: Columns of a Jacobian for one body.
COLUMNS = 6
#: Inputs of a body with shape and unit: its position, and the velocities that rates have, too.
PLACES = (("r_{}", 3, "m"), ("p_{}", 4, "-"))
RATES = (("v_{}", 3, "m/s"), ("omega_{}_b", 3, "rad/s"))


def framed(package: Package, orientation: Kernel) -> Package:
    """Constraint and rates of a package, for principal frames: r = r_G + A s′, p = p_G ∘ p′.

    The frame in which the package is stated is at s′ (3,) [m] in the principal frame, turned by p′
    (4,).

    Parameters
    ----------
    package : Package
        As derived.
    orientation : Kernel
        A of Euler parameters p, of the kind ``rotation``.

    Returns
    -------
    Package
        Its kernels take ``origin_i``, ``frame_i`` and those of j, and own inputs by the names that
        :func:`kousoku.model.records.own_kind.input_name` gives them.
    """
    constraint, rates = (
        next(kernel for kernel in package.kernels if kernel.name == name)
        for name in ("constraint", "rates")
    )
    own = own_inputs(package)
    kernels = (
        _Framed(constraint, own, orientation).constraint(),
        _Framed(rates, own, orientation).rates(constraint),
    )
    return replace(package, kernels=kernels)


def own_inputs(package: Package) -> tuple[Quantity, ...]:
    """Inputs of a package that are no state of a body, in the order of its kernels."""
    known = {name.format(body) for name, *_ in (*PLACES, *RATES) for body in "ij"}
    wanted = (k for k in package.kernels if k.name in {"constraint", "rates"})
    quantities = {x.name: x for kernel in wanted for x in kernel.inputs}
    return tuple(x for name, x in quantities.items() if name not in known)


@dataclass(frozen=True, slots=True)
class _End:
    """A body, in its principal frame and as a constraint knows it."""

    point: Matrix
    orientation: Matrix
    turn: Matrix
    r: Matrix
    p: Matrix


class _Framed:
    """A kernel while it is put into other frames."""

    def __init__(self, kernel: Kernel, own: Sequence[Quantity], orientation: Kernel) -> None:
        self.graph, self.kernel, self.own = Graph(), kernel, own
        self._orientation = orientation
        self.inputs: dict[str, Quantity] = {}
        self.ends = {
            body: self._end(body, *names)
            for body, *names in zip("ij", ORIGINS, FRAMES, strict=True)
        }
        self.substitutions: dict[str, Sequence[int]] = {
            x.name: self._input(input_name(x.name), x.shape, x.unit, x.meaning).flat for x in own
        }
        for body, end in self.ends.items():
            self.substitutions |= {f"r_{body}": end.r.flat, f"p_{body}": end.p.flat}

    def constraint(self) -> Kernel:
        """C and C_q."""
        outputs = substitute(self.graph, self.kernel, self.substitutions)
        rows = [self._row(outputs["C_q"], row) for row in range(len(outputs["C"]))]
        return self._kernel({"C": outputs["C"], "C_q": [node for row in rows for node in row]})

    def rates(self, constraint: Kernel) -> Kernel:
        """Right-hand sides ν and γ of a constraint, from the kernel of its rates."""
        graph, swings = self.graph, []
        for body, end in self.ends.items():
            v, omega = (self._input(name.format(body), (n,), unit) for name, n, unit in RATES)
            arm = omega.cross(end.point)
            self.substitutions[f"v_{body}"] = (v + end.orientation @ arm).flat
            self.substitutions[f"omega_{body}_b"] = (end.turn.T @ omega).flat
            swings.append(end.orientation @ omega.cross(arm))
        swing = stack(graph, swings, 1)
        outputs = substitute(graph, self.kernel, self.substitutions)
        jacobian = substitute(graph, constraint, self.substitutions)["C_q"]
        gamma = []
        for row, node in enumerate(outputs["gamma"]):
            first = row * 2 * COLUMNS
            forces = [jacobian[first + side * COLUMNS + k] for side in (0, 1) for k in range(3)]
            (extra,) = (Matrix.of(graph, forces).T @ swing).flat
            gamma.append(graph.sub(node, extra))
        return self._kernel({"nu": outputs["nu"], "gamma": gamma})

    def _row(self, jacobian: Sequence[int], row: int) -> tuple[int, ...]:
        """Row of the Jacobian by δr and δθ′ of principal frames."""
        entries: list[int] = []
        for side, end in enumerate(self.ends.values()):
            first = (2 * row + side) * COLUMNS
            force = Matrix.of(self.graph, jacobian[first : first + 3])
            moment = Matrix.of(self.graph, jacobian[first + 3 : first + COLUMNS])
            turned = end.turn @ moment + end.point.cross(end.orientation.T @ force)
            entries += (*force.flat, *turned.flat)
        return tuple(entries)

    def _end(self, body: str, origin: str, frame: str) -> _End:
        r, p = (self._input(name.format(body), (n,), unit) for name, n, unit in PLACES)
        point = self._input(origin, (3,), "m", f"origin of the frame of {body}")
        axes = self._input(frame, (4,), "-", f"from the frame of {body} to the principal frame")
        orientation, turn = self._turning(p), self._turning(axes)
        return _End(point, orientation, turn, r + orientation @ point, self._composed(p, axes))

    def _turning(self, p: Matrix) -> Matrix:
        nodes = substitute(self.graph, self._orientation, {"p": p.flat})["A"]
        return Matrix.of(self.graph, nodes, 3)

    def _composed(self, p: Matrix, q: Matrix) -> Matrix:
        """Product p ∘ q of Euler parameters."""
        graph = self.graph
        (a, *x), (b, *y) = p.flat, q.flat
        u, v = Matrix.of(graph, x), Matrix.of(graph, y)
        (dot,) = (u.T @ v).flat
        scaled = [graph.add(graph.mul(a, n), graph.mul(b, m)) for m, n in zip(x, y, strict=True)]
        vector = Matrix.of(graph, scaled) + u.cross(v)
        return Matrix.of(graph, (graph.sub(graph.mul(a, b), dot), *vector.flat))

    def _input(self, name: str, shape: tuple[int, ...], unit: str, meaning: str = "") -> Matrix:
        quantity = Quantity(name, shape, unit, meaning)
        self.inputs[name] = quantity
        return Matrix.of(self.graph, [self.graph.input(name, k) for k in range(quantity.size)])

    def _kernel(self, results: Mapping[str, Sequence[int]]) -> Kernel:
        kernel = replace(
            self.kernel,
            inputs=tuple(self.inputs.values()),
            outputs=tuple(x for x in self.kernel.outputs if x.name in results),
            nodes=tuple(self.graph.nodes),
            results=tuple(tuple(results[x.name]) for x in self.kernel.outputs if x.name in results),
            names=(),
        )
        return drop_dead(kernel)
