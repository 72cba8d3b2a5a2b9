"""Check a scene's solver against motions that were computed in 50 digits."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import VerifyError
from kousoku.runtime.kinematics.rows import METHODS
from kousoku.runtime.kinematics.status import Status
from kousoku.runtime.library import read_files
from kousoku.runtime.linkage import SOLVER, solver_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.runtime.arguments import Floats
    from kousoku.runtime.kinematics.rows import Run
    from kousoku.runtime.library import Library
    from kousoku.runtime.linkage import LinkageSolver

SOLUTION_FILE = "solution.json"
#: Largest difference, relative to the largest length, velocity or acceleration: far above the
#: rounding of a mechanism that comes near its dead centres, far below any wrong formula.
LIMIT = 1e-9
MOTIONS = ("position", "velocity", "acceleration")
#: Other rates, so that no term of the velocities and accelerations is zero or counts once.
SPEED, SPEED_DOT = -1.5, 0.75


def solver_problems(library: Library) -> list[str]:
    """Return what is wrong with the solver of a package; nothing where it has none.

    Both methods are run as the scene says, and once more with other rates, from another turn on
    where the inputs turn; each row that ``solution.json`` has is compared.

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
        rows, divisions = data["rows"], data["divisions"]
        exact = {name: np.array(data[name], dtype=np.float64) for name in MOTIONS}
    except (ValueError, KeyError, TypeError) as error:
        raise VerifyError(f"{library.folder / SOLUTION_FILE} cannot be read: {error!r}") from None
    solver = solver_of(library)
    problems: list[str] = []
    for method in METHODS if rows else ():
        run = solver.request(method=method, divisions=divisions)
        other, wanted = _at_other_rates(run, exact)
        if run.is_periodic and rows[-1] == divisions:
            # the continuation begins at the turn before
            other = replace(other, start=divisions + 3, first=2 * divisions)
        where = f"solver by {library.target}, {method}"
        problems += _problems(where, solver, run, rows, exact)
        problems += _problems(f"{where}, at other rates", solver, other, rows, wanted)
    return problems


def _at_other_rates(run: Run, exact: dict[str, Floats]) -> tuple[Run, dict[str, Floats]]:
    """Return a run whose time goes by otherwise, and what it must give.

    With t(τ), dt/dτ = s and d²t/dτ² = c, a velocity v becomes s v, an acceleration a becomes
    s² a + c v; the same holds for the inputs.
    """
    position, velocity, acceleration = (exact[name] for name in MOTIONS)
    s, c = SPEED, SPEED_DOT
    other = replace(
        run,
        rate=[s * rate for rate in run.rate],
        rate_dot=[
            s * s * rate_dot + c * rate
            for rate, rate_dot in zip(run.rate, run.rate_dot, strict=True)
        ],
    )
    motions = (position, s * velocity, s * s * acceleration + c * velocity)
    return other, dict(zip(MOTIONS, motions, strict=True))


def _problems(
    where: str, solver: LinkageSolver, run: Run, rows: Sequence[int], exact: dict[str, Floats]
) -> Iterator[str]:
    """Yield how a run differs from the rows that are known."""
    mechanism, got = solver.mechanism, solver.rows(run)
    good = [k for k, row in enumerate(rows) if row < got.done]
    if len(good) < len(rows):
        yield f"{where}: stops after {got.done} rows: {Status(got.status).message}"
    if not good:
        return
    inputs = np.array([run.counted_inputs(run.first + rows[k]) for k in good])
    size = np.abs(inputs).max(axis=0)
    for k, wanted in zip(good, inputs, strict=True):
        if not np.all(np.abs(got.alpha[rows[k]] - wanted) <= LIMIT * size):
            yield (
                f"{where}: inputs at division {rows[k]} of {run.divisions}: got"
                f" {got.alpha[rows[k]].tolist()}, wanted {wanted.tolist()}"
            )
            break
    for name, wanted in exact.items():
        values = getattr(got, name)[[rows[k] for k in good]].reshape(len(good), -1)
        errors = np.nan_to_num(np.abs(values - wanted[good]), nan=np.inf)
        scale = max(float(np.max(np.abs(wanted))), mechanism.length)
        k, element = divmod(int(np.argmax(errors)), errors.shape[1])
        if not errors[k, element] <= LIMIT * scale:
            node = mechanism.nodes[element // 2]
            yield (
                f"{where}: {name} {'xy'[element % 2]} of {node} at division {rows[k]} of "
                f"{run.divisions}: got {float(values[k, element])!r}, wanted "
                f"{float(wanted[k, element])!r} within {LIMIT * scale:.0e}"
            )
