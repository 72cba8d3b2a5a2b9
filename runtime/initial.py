"""Initial values that a caller gives, checked, and where the scene starts with them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.model.angles import number_of
from kousoku.model.errors import SolveError
from kousoku.runtime.given import numbers_of, shown, unknown

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


#: Where the scene starts.
SCENE = Initial()


def initial_of(
    solver: DynamicsSolver, initial: Mapping[str, float | str] | None, q0: object, v0: object
) -> Initial:
    """Return initial values, checked.

    Raises
    ------
    SolveError
        There is no such coordinate, or a number is none.
    """
    if initial is q0 is v0 is None:
        return SCENE
    if initial is None:
        bodies = (
            () if given is None else tuple(numbers_of(solver.name, name, given).ravel().tolist())
            for name, given in (("q0", q0), ("v0", v0))
        )
        return Initial((), *bodies)
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
            f"{solver.name}: no coordinates for initial {shown([*initial])}: the scene names none,"
            ' or was generated without "coordinates"; load(..., outputs=[..., "coordinates"])'
        )
    lengths = {
        x for own, is_length, _ in solver.layout.coordinates if is_length for x in _names(own)
    }
    known = [own for pair in map(_names, names) for own in pair]
    found, problems = {}, []
    for name, value in initial.items():
        if name not in known:
            problems.append(unknown("coordinate", name, known))
            continue
        try:
            found[name] = _number(value, is_length=name in lengths)
        except (TypeError, ValueError, OverflowError):
            wanted = "" if name in lengths else ", or an angle such as '30 deg'"
            problems.append(f"initial {name} is {shown(value)}; wanted a finite number{wanted}")
    if problems:
        raise SolveError(f"{solver.name}: {'; '.join(problems)}")
    return Initial(tuple(found.items()))


def _names(name: str) -> tuple[str, str]:
    return name, f"{name}_dot"


def _number(value: object, *, is_length: bool) -> float:
    """Return a value of a coordinate; only angles are told by texts."""
    if isinstance(value, str) and not is_length:
        value = number_of(value)
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ValueError
    return float(value)


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
    from kousoku.runtime.integrate.initial import InitialError, evaluated
    from kousoku.runtime.integrate.placing import started

    target = there.target
    evaluate = evaluated(target.evaluate, parameters, target.work_size, there.places)
    rows = (*there.rows, *there.left_out, *there.reduced)
    values, *written = initial
    q0, v0 = (np.array(one) if one else None for one in written)
    try:
        return started(there.layout, rows, evaluate, y, (dict(values), q0, v0))
    except InitialError as error:
        raise SolveError(f"{there.name}: {error}") from None
