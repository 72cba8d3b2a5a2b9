"""Mechanisms that are a tree: a small pendulum, chains, and a stiff governor."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

from kousoku.model.reading.families import chain
from tests.benchmarks.problems.forms import flat, observed_of, recursive, scene_of
from tests.benchmarks.problems.problem import BenchmarkProblem, reaction_norms
from tests.benchmarks.problems.tools import FEW_TAYLOR, TAYLOR, equation_lines, tree_lines
from tests.benchmarks.problems.tree import GROUND, Spring, Tree, TreeLink, equations

if TYPE_CHECKING:
    from tests.benchmarks.kit import Case, Size

#: A rod of 1.5 mm and 1 mg; its point at 1 mm moves as A01 does, but for the scale.
SMALL = Tree(
    links=(
        TreeLink(
            "z", GROUND, (0.0, 0.0, 0.0), 1e-6, (7.5e-4, 0.0, 0.0), (1e-15, 1.875e-13, 1.875e-13)
        ),
    ),
    q=(math.pi,),
    v=(0.0,),
    gravity=(0.0, -9.81, 0.0),
    observed=((0, (1e-3, 0.0, 0.0)),),
    axes="xy",
)

#: A shaft of 3 m about y with two arms of 1 m that carry balls of 5 kg, and a sleeve that springs
#: of 8e5 N/m with dampers of 4e4 N s/m hold to the middles of the arms. Only the arms start out of
#: balance: the shaft turns freely, and the stiff springs follow.
GOVERNOR = Tree(
    links=(
        TreeLink("y", GROUND, (0.0, 0.0, 0.0), 20.0, (0.0, 1.0, 0.0), (6.0, 0.4, 6.0)),
        TreeLink("z", 0, (0.05, 2.0, 0.0), 5.5, (0.9, 0.0, 0.0), (0.05, 0.1, 0.1)),
        TreeLink("z", 0, (-0.05, 2.0, 0.0), 5.5, (-0.9, 0.0, 0.0), (0.05, 0.1, 0.1)),
        TreeLink("slide y", 0, (0.0, 1.2, 0.0), 2.0, (0.0, 0.0, 0.0), (0.02, 0.02, 0.02)),
    ),
    q=(0.0, -math.pi / 3, math.pi / 3, 0.0),
    v=(6.0, 0.0, 0.0, 0.0),
    gravity=(0.0, -9.81, 0.0),
    observed=((1, (1.0, 0.0, 0.0)), (2, (-1.0, 0.0, 0.0)), (3, (0.0, 0.0, 0.0))),
    springs=(
        Spring((1, (0.5, 0.0, 0.0)), (3, (0.05, 0.0, 0.0)), 8e5, 0.45, 4e4),
        Spring((2, (-0.5, 0.0, 0.0)), (3, (-0.05, 0.0, 0.0)), 8e5, 0.45, 4e4),
    ),
)

MOMENTS = (0.02 / 12, 1.01 / 12, 1.01 / 12)
#: Bars of a chain, and the time up to which it is predictable.
CHAINS = {2: 10.0, 10: 2.0, 30: 1.0}
#: Bars up to which Lagrange's equations are written out, and heyoka's code is inlined.
LAGRANGE, INLINED = 10, 2


def chain_of(count: int) -> Tree:
    """Chain of bars on hinges about y, z, y, …, at rest along x."""
    links = [
        TreeLink(
            "z" if k % 2 else "y", k - 1, (float(k > 0), 0.0, 0.0), 1.0, (0.5, 0.0, 0.0), MOMENTS
        )
        for k in range(count)
    ]
    middle, last = count // 2, count - 1
    return Tree(
        tuple(links),
        (0.0,) * count,
        (0.0,) * count,
        (0.0, 0.0, -9.81),
        observed=tuple((k, (1.0, 0.0, 0.0)) for k in (middle, last)),
    )


def peers(
    tree: Tree,
    problem: BenchmarkProblem,
    size: Size,
    *,
    is_stiff: bool = False,
    is_long: bool = False,
) -> list[Case]:
    """Cases of all peers: joint coordinates are what a person reduced it to."""
    make = partial(recursive, tree)
    cases = equation_lines(
        problem,
        size,
        "reduced",
        "reduced",
        make,
        is_stiff=is_stiff,
        is_long=is_long,
        tolerances=FEW_TAYLOR[1:2] if is_long else TAYLOR,
    )
    if all(link.joint == "z" for link in tree.links):
        make = partial(flat, tree)
        cases += equation_lines(problem, size, "index 1", "equations", make, has_multipliers=True)
    return [*cases, *tree_lines(problem, size, tree, is_stiff=is_stiff)]


def problem_of_chain(count: int) -> BenchmarkProblem:
    """Problem of a chain."""
    tree = chain_of(count)
    names = [f"bar_{k}" for k in range(count)]
    return BenchmarkProblem(
        name=f"chain_{count}",
        title=f"Chain of {count} bars, {CHAINS[count]:g} s",
        scene=partial(chain, count),
        observe=observed_of(tree, names),
        length=1.0,
        end=CHAINS[count],
        forms=(
            partial(recursive, tree),
            *([partial(equations, tree)] if count <= LAGRANGE else []),
        ),
        peers=partial(peers, tree, is_long=count > INLINED),
    )


PROBLEMS = (
    BenchmarkProblem(
        name="small_pendulum",
        title="Pendulum of 1 mm, 0.3 s",
        scene=partial(scene_of, "small_pendulum", SMALL),
        observe=observed_of(SMALL),
        length=1e-3,
        end=0.3,
        forms=(partial(recursive, SMALL), partial(flat, SMALL)),
        reactions=partial(reaction_norms, ("joint_0",)),
        peers=partial(peers, SMALL),
    ),
    *(problem_of_chain(count) for count in CHAINS),
    BenchmarkProblem(
        name="governor",
        title="Stiff governor, 5 s",
        scene=partial(scene_of, "governor", GOVERNOR),
        observe=observed_of(GOVERNOR),
        length=1.0,
        end=5.0,
        forms=(partial(recursive, GOVERNOR), partial(equations, GOVERNOR)),
        peers=partial(peers, GOVERNOR, is_stiff=True),
    ),
)
