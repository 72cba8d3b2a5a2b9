"""The order of Runge-Kutta methods: the conditions that their tables must meet.

A method has order p where Σ b_k Φ_k(t) = 1/γ(t) for each rooted tree t of at most p nodes, with
Φ_k of a tree the product of Σ_m a_km Φ_m over its branches, and γ(t) the count of its nodes times
the product of those of its branches; a polynomial that tells the state inside of a step has order
p where Σ b_k(x) Φ_k(t) = x^n/γ(t), n the count of nodes. Hairer, Nørsett and Wanner, *Solving
Ordinary Differential Equations I* (1993), theorems II.2.13 and II.6.1. The sums over the tables are
exact: what they leave is that the coefficients are rounded to doubles.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import MotionError, SolveError
from kousoku.runtime.importing import import_source, not_listed

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path
    from types import ModuleType

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.methods import RungeKuttaMethod

    Tree = tuple["Tree", ...]

#: The tables of the methods in C.
METHODS_HEADER = "integrate/methods.h"
#: Orders of the polynomials inside of a step, and orders up to which estimates of errors vanish.
INSIDE = {"dopri5": 4, "dop853": 7}
ESTIMATES = {"dopri5": (4,), "dop853": (5, 3)}
#: Parts of a step at which its polynomial is checked.
PLACES = (0.15, 0.3, 0.45, 0.6, 0.75, 0.9)
#: Largest defect of a condition by rounding, as a part of the sizes of its terms: of the table, and
#: of a polynomial, which is evaluated in doubles.
TABLE_ROUNDING, POLYNOMIAL_ROUNDING = 2.0**-53, 2.0**-52
#: Doubles are whole numbers of this unit: none of a table is below 2⁻⁶⁰, unless it is zero.
GRAIN = 112

#: Tolerance that gives the first step, and number of times that are tried, each twice the last.
TOLERANCE, DOUBLED = 1e-5, 4
#: Differences of halved steps that show an order, as parts of the largest number: not yet rounding.
LEAST, MOST = 1e-12, 1e-3
#: Least motion, relative to the same: in an unstable equilibrium rounding grows to differences that
#: show no order.
MOVES = 1e-6
#: A method of order p whose steps show less than p less this, twice at least, is none.
ORDER_SHORTFALL = 2.0
#: Parts of the time at which rows are written: inside of steps.
ROWS = (0.0, 0.31, 0.57, 0.83, 1.0)


@cache
def trees(nodes: int) -> tuple[Tree, ...]:
    """Rooted trees of so many nodes, each as the tuple of its branches."""
    return tuple(dict.fromkeys(_forests(nodes - 1)))


def _forests(nodes: int) -> Iterator[Tree]:
    """Branches with so many nodes in all, sorted."""
    if nodes == 0:
        yield ()
    for size in range(1, nodes + 1):
        for tree in trees(size):
            for others in _forests(nodes - size):
                yield tuple(sorted((tree, *others)))


def _size(tree: Tree) -> int:
    return 1 + sum(map(_size, tree))


def _density(tree: Tree) -> int:
    density = _size(tree)
    for branch in tree:
        density *= _density(branch)
    return density


class _Weights:
    """Φ of the trees for each stage of a method: exact as whole numbers, and of |a| in doubles."""

    def __init__(self, a: Sequence[Sequence[float]]) -> None:
        self._exact = [[_whole(x) for x in row] for row in a]
        self._size = [[abs(x) for x in row] for row in a]
        self._known: dict[Tree, tuple[list[int], list[float]]] = {}

    def __call__(self, tree: Tree) -> tuple[list[int], list[float]]:
        """Weight Φ in units of 2^(−GRAIN · branches' nodes), and the same of |a| in doubles."""
        if tree not in self._known:
            exact, sizes = [1] * len(self._exact), [1.0] * len(self._exact)
            for branch in tree:
                inner, inner_sizes = self(branch)
                for k, (row, row_sizes) in enumerate(zip(self._exact, self._size, strict=True)):
                    exact[k] *= sum(x * y for x, y in zip(row, inner, strict=False))
                    sizes[k] *= sum(x * y for x, y in zip(row_sizes, inner_sizes, strict=False))
            self._known[tree] = exact, sizes
        return self._known[tree]

    def defect(self, b: Sequence[float], tree: Tree, expected: Fraction) -> tuple[float, float]:
        """Defect of an order condition, and the size that its rounding scales with."""
        exact, sizes = self(tree)
        total = sum(_whole(x) * y for x, y in zip(b, exact, strict=False))
        defect = Fraction(total, 2 ** (GRAIN * _size(tree))) - expected
        size = sum(abs(x) * y for x, y in zip(b, sizes, strict=False))
        return abs(float(defect)), _size(tree) * max(size, float(expected))


def _whole(x: float) -> int:
    return int(Fraction(x) * 2**GRAIN)


def table_problems(folder: Path, files: Mapping[str, bytes]) -> Iterator[str]:
    """Problems with the tables of the methods of a folder.

    Parameters
    ----------
    folder : Path
        A scene's folder.
    files : mapping of str to bytes
        Its files.

    Raises
    ------
    LoadError
        The folder lacks a table, or its manifest does not list it.
    """
    methods = import_source(folder, files, "integrate/methods.py").METHODS
    dense = import_source(folder, files, "integrate/dense_output.py")
    if METHODS_HEADER not in files:
        raise not_listed(folder, METHODS_HEADER)
    text = files[METHODS_HEADER].decode()
    for method in methods:
        yield from wrong_conditions(method)
        yield from wrong_inside(method, dense)
        if _in_c(method.name, text) != _in_python(method):
            yield f"{method.name}: {METHODS_HEADER} has other numbers than integrate/methods.py"


def _in_c(name: str, text: str) -> dict[str, list[float]]:
    """Tables of a method in its header, by name."""
    tables = {}
    for table, numbers in re.findall(rf"double {name}_(\w+)\[\] = \{{([^}}]*)\}}", text):
        tables[table] = [float(x) for x in numbers.replace(",", " ").split()]
    return tables


def _in_python(method: RungeKuttaMethod) -> dict[str, list[float]]:
    """Tables of a method in Python, by name."""
    rows_by_name = {"c": [*method.c], "error": [*method.errors[0]]}
    rows_by_name |= {f"error_{k + 1}": [*row] for k, row in enumerate(method.errors) if k}
    tables = {"a": method.a, "dense": method.dense}
    if method.works:
        tables["works"] = method.works
    return rows_by_name | {name: [x for row in rows for x in row] for name, rows in tables.items()}


def wrong_conditions(method: RungeKuttaMethod) -> Iterator[str]:
    """Order conditions that the end of a step, its nodes and its estimates do not meet."""
    weights = _Weights(method.a)
    for k, row in enumerate(method.a):
        if abs(math.fsum((*row, -method.c[k]))) > TABLE_ROUNDING * math.fsum(map(abs, (*row, 1.0))):
            yield f"{method.name}: the coefficients of stage {k} do not add up to its node c[{k}]"
    end = method.a[method.stages]
    conditions = [("the end of a step", end, method.order, True)]
    for k, order in enumerate(ESTIMATES[method.name]):
        conditions.append((f"estimate {k + 1} of its error", method.errors[k], order, False))
    for name, row, order, is_step in conditions:
        for nodes in range(1, order + 1):
            for tree in trees(nodes):
                expected = Fraction(int(is_step), _density(tree))
                defect, size = weights.defect(row, tree, expected)
                if defect > TABLE_ROUNDING * size:
                    yield (
                        f"{method.name}: {name} has not the order {order}: of a condition of order"
                        f" {nodes} it leaves {defect:.3g}"
                    )
                    break
            else:
                continue
            break


def wrong_inside(method: RungeKuttaMethod, dense: ModuleType) -> Iterator[str]:
    """Places where the polynomial inside of a step has not the order that it should have."""
    weights, order = _Weights(method.a), INSIDE[method.name]
    for x in PLACES:
        row = _at(method, dense, x)
        for nodes in range(1, order + 1):
            for tree in trees(nodes):
                exact, sizes = weights(tree)
                grain = 2 ** (GRAIN * (nodes - 1))
                value = math.fsum(b * (phi / grain) for b, phi in zip(row, exact, strict=True))
                size = sum(s * t for s, t in zip(_sizes(method), sizes, strict=True))
                defect = abs(value - x**nodes / _density(tree))
                if defect > POLYNOMIAL_ROUNDING * size:
                    yield (
                        f"{method.name}: dense output has not the order {order}: at {x} of a step"
                        f" it leaves {defect:.3g} of a condition of order {nodes}"
                    )
                    return


def _sizes(method: RungeKuttaMethod) -> list[float]:
    """Sizes of the parts of the polynomial's weights, stage by stage."""
    sizes = [1.0] * method.all
    for row in (method.a[method.stages], *method.dense):
        for k, x in enumerate(row):
            sizes[k] += abs(x)
    return sizes


def _at(method: RungeKuttaMethod, dense: ModuleType, x: float) -> list[float]:
    """Weights b(x) of the derivatives at the part x of a step of length one."""
    weights = []
    for k in range(method.all):
        rows = np.zeros((method.all, 1))
        rows[k] = 1.0
        end = method.a[method.stages]
        state = SimpleNamespace(
            y=np.array([end[k] if k < len(end) else 0.0]),
            y_before=np.zeros(1),
            time=1.0,
            time_before=0.0,
            dense=np.zeros((3 + len(method.dense), 1)),
        )
        state.f = rows[method.stages]
        work: Any = SimpleNamespace(k=rows)
        dense.prepare_dense(method, work, state)
        y = np.zeros(1)
        dense.interpolate(method, x, state, y)
        weights.append(float(y[0]))
    return weights


def shown_order_problems(
    solver: DynamicsSolver, methods: Sequence[RungeKuttaMethod]
) -> Iterator[str]:
    """Methods whose steps, halved and halved again, show a lower order than they have.

    Rows inside of steps are among what is compared, so that dense output counts. Where motions are
    too short, at rest, or led by drivers, nothing shows, and nothing is said.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene whose equations are smooth.
    methods : sequence of RungeKuttaMethod
        Of its folder.
    """
    for method in methods if not solver.is_driven else ():
        orders: list[float] = []
        time = _first_time(solver, method.name)
        for _ in range(DOUBLED if time else 0):
            order = _observed_order(solver, method.name, time)
            if order is not None:
                orders.append(order)
                if order > method.order - ORDER_SHORTFALL:
                    break
            time *= 2
        if len(orders) > 1 and max(orders) < method.order - ORDER_SHORTFALL:
            yield (
                f"solver, {method.name}: halving its steps shows the order {max(orders):.1f}, not"
                f" {method.order}"
            )


def _first_time(solver: DynamicsSolver, method: str) -> float:
    """Time that two steps reach, zero where a run is not possible."""
    try:
        run = solver.begin([0.0, 1.0], tolerance=TOLERANCE, method=method)
        run.advance(max_steps=2)
    except (SolveError, MotionError):
        return 0.0
    return run.time


def _observed_order(solver: DynamicsSolver, method: str, time: float) -> float | None:
    """Order that 2, 4 and 8 steps show, None where rounding or more hides it."""
    solutions = []
    for count in (2, 4, 8):
        times = time * np.array(ROWS)
        try:
            run = solver.begin(times, step=time / count, method=method, checks=False)
            run.finish()
        except (SolveError, MotionError):
            return None
        nq_nv = 1 + len(solver.q) + len(solver.v)
        solutions.append(run.save().rows[:, 1:nq_nv])
    size = max(float(np.abs(solutions[-1]).max(initial=0.0)), 1e-300)
    first, second = (float(np.abs(a - b).max()) / size for a, b in pairwise(solutions))
    moved = float(np.abs(solutions[-1] - solutions[-1][0]).max()) / size
    if not (second > LEAST and first < MOST and moved > MOVES):
        return None
    return math.log2(first / second)
