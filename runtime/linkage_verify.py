"""Check a scene's solver against motions that were computed in 50 digits."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import SolveError, VerifyError
from kousoku.runtime.library import read_files
from kousoku.runtime.linkage import SOLVER, solver_of

if TYPE_CHECKING:
    from kousoku.runtime.library import Library

SOLUTION_FILE = "solution.json"
#: Largest difference, relative to the largest length, velocity or acceleration: far above the
#: rounding of a mechanism that comes near its dead centres, far below any wrong formula.
LIMIT = 1e-9


def solver_problems(library: Library) -> list[str]:
    """Return what is wrong with the solver of a package; nothing where it has none.

    Both methods are run; each row that ``solution.json`` has is compared.

    Raises
    ------
    VerifyError
        ``solution.json`` cannot be read.
    """
    files = read_files(library.folder, library.manifest)
    if SOLUTION_FILE not in files or SOLVER not in files:
        return []
    try:
        data = json.loads(files[SOLUTION_FILE])
        rows = data["rows"]
        wanted = {name: np.array(data[name]) for name in ("position", "velocity", "acceleration")}
    except (ValueError, KeyError, TypeError) as error:
        raise VerifyError(f"{library.folder / SOLUTION_FILE} cannot be read: {error!r}") from None
    solver = solver_of(library)
    problems = []
    for method in solver.module.METHODS if rows else ():
        try:
            got = solver.rows(method=method, divisions=data["divisions"])
        except SolveError as error:
            problems.append(f"solver by {library.target}, {method}: {error}")
            continue
        good = [k for k, row in enumerate(rows) if row < got.done]
        if len(good) < len(rows):
            problems.append(f"solver by {library.target}, {method}: stops after {got.done} rows")
        for name, exact in wanted.items():
            values = getattr(got, name)[[rows[k] for k in good]].reshape(len(good), -1)
            scale = max(float(np.max(np.abs(exact), initial=0.0)), solver.module.LENGTH)
            worst = float(np.max(np.abs(values - exact[good]), initial=0.0)) / scale
            if not worst <= LIMIT:
                problems.append(
                    f"solver by {library.target}, {method}: {name} is {worst:.1e} of the largest"
                    f" off what 50 digits give (limit {LIMIT:.0e})"
                )
    return problems
