"""Initial values that a caller gives, checked, and where the scene starts with them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.model.angles import number_of
from kousoku.model.errors import SolveError
from kousoku.runtime.given import numbers_of, require_numbers, shown, unknown

if TYPE_CHECKING:
    import numpy.typing as npt

    from kousoku.runtime.dynamics import DynamicsSolver

    Array = npt.NDArray[np.float64]


class Initial(NamedTuple):
    """Where a run starts, if not where the scene does; empty of what is not given.

    Parameters
    ----------
    values : tuple of (str, float)
        Coordinates and their rates, in the unit of the scene.
    q0, v0 : tuple of float
        Bodies as written, see :func:`kousoku.runtime.integrate.initial.place`.
    """

    values: tuple[tuple[str, float], ...] = ()
    q0: tuple[float, ...] = ()
    v0: tuple[float, ...] = ()


def initial_of(
    solver: DynamicsSolver, initial: Mapping[str, float | str] | None, q0: object, v0: object
) -> Initial:
    """Return initial values, checked.

    Raises
    ------
    SolveError
        There is no such coordinate, a number is none, or there are too many or too few.
    """
    if initial is None:
        return Initial((), *(_of_bodies(solver, *one) for one in (("q0", q0, 4), ("v0", v0, 3))))
    if q0 is not None or v0 is not None:
        raise SolveError(f"{solver.name}: give either initial, or q0 and v0")
    if not isinstance(initial, Mapping):
        raise SolveError(
            f"{solver.name}: initial {shown(initial)}; wanted a mapping of coordinates, or of rates"
            ' as "theta_dot", to numbers'
        )
    coordinates = solver.layout.coordinates
    names = [name for name, *_ in coordinates]
    if initial and not names:
        raise SolveError(
            f"{solver.name}: initial {shown([*initial])}: no coordinate is known: the scene has"
            ' none, or was generated without "coordinates"; add it to outputs'
        )
    lengths = {name for name, is_length, _ in coordinates if is_length}
    known = [*names, *(f"{name}_dot" for name in names)]
    found, problems = {}, []
    for name, value in initial.items():
        if name not in known:
            problems.append(unknown("coordinate", name, known))
            continue
        try:
            is_text = isinstance(value, str)
            number = number_of(value) if isinstance(value, str) else value
            require_numbers("", value=number)
            own = name if name in names else name.removesuffix("_dot")
            if not np.isfinite(number) or (is_text and own in lengths):
                raise ValueError("wanted a finite number" + " of lengths" * is_text)
        except (ValueError, SolveError):
            text = "wanted a number, or degrees as '30 deg'"
            problems.append(f"initial {name} is {shown(value)}, {text}")
            continue
        found[name] = float(number)
    if problems:
        raise SolveError(f"{solver.name}: {'; '.join(problems)}")
    return Initial(tuple(found.items()))


def _of_bodies(solver: DynamicsSolver, name: str, given: object, turning: int) -> tuple[float, ...]:
    """Return numbers of all bodies as they are written."""
    if given is None:
        return ()
    array = numbers_of(solver.name, name, given)
    size = sum(3 + turning * bool(body.p) for body in solver.bodies)
    if array.shape != (size,) or not np.isfinite(array).all():
        of = "r (3), Euler parameters (4)" if turning == 4 else "velocity (3), omega_b (3)"
        raise SolveError(
            f"{solver.name}: {name} has the shape {array.shape}; wanted {size} finite numbers: of"
            f" each body {of}; a point has the first three alone"
        )
    return tuple(array.tolist())


def started_at(
    there: DynamicsSolver, initial: Initial, parameters: Array, y: Array
) -> tuple[Array, Array]:
    """Return q and v with initial values.

    Parameters
    ----------
    there : DynamicsSolver
        The scene with the parameters of the run.
    initial : Initial
        What is given.
    parameters : array
        Those of the run.
    y : array
        Where the scene starts with them: q, then v.

    Raises
    ------
    SolveError
        It cannot be.
    """
    from kousoku.runtime.integrate.initial import Start, lead, place

    target = there.target

    def evaluate(q: Array, v: Array) -> dict[str, Array]:
        work = np.zeros(target.work_size)
        target.evaluate(0.0, np.ascontiguousarray(q), np.ascontiguousarray(v), parameters, work)
        places = {"coordinates": (0, 0), **there.places}
        return {name: work[base : base + size] for name, (base, size) in places.items()}

    count = len(there.q)
    start = Start(
        evaluate,
        y[:count].copy(),
        y[count:].copy(),
        there.bodies,
        {
            name: (columns[0], columns[1], there.unit if is_length else 1.0)
            for name, is_length, columns in there.layout.coordinates
        },
        (*there.rows, *there.left_out, *there.reduced),
        [at for _, at in there.layout.works],
        there.length,
        there.unit,
    )
    try:
        if initial.values:
            return lead(start, dict(initial.values))
        return place(start, *(np.array(one) if one else None for one in initial[1:]))
    except ValueError as error:
        raise SolveError(f"{there.name}: {error}") from None
