"""Initial values as a caller gives them, of coordinates or of bodies; refused where impossible."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..messages import refusal, shown, unknown
from .result import Coordinates
from .run_arguments import number_in, numbers_of

if TYPE_CHECKING:
    from .motion import Layout


class InitialValues(NamedTuple):
    """Start of a run, if it is not that of the scene; empty of what is not given.

    Parameters
    ----------
    values : tuple of (str, float)
        Coordinates and their rates, in the unit of the scene.
    q0, v0 : tuple of float
        Bodies as written, see :func:`.initial_poses.place`.
    counted : tuple of float
        q of the solver where q0 is the row of a run: its angles count turns.
    """

    values: tuple[tuple[str, float], ...] = ()
    q0: tuple[float, ...] = ()
    v0: tuple[float, ...] = ()
    counted: tuple[float, ...] = ()


def parameters_of(parameters: Any, q0: object) -> Any:
    """Parameters of a run that begins at q0: of its row where none are given."""
    return q0.parameters if parameters is None and isinstance(q0, Coordinates) else parameters


def initial_of(
    layout: Layout, initial: Mapping[str, float | str] | None, q0: object, v0: object
) -> InitialValues:
    """Initial values of a scene, checked; there may be no such coordinate."""
    scene = layout.name
    if initial is None:
        counted = q0.counted if isinstance(q0, Coordinates) else None
        if counted is not None and len(counted) != layout.sizes["q"]:  # of another solver
            counted = None
        return InitialValues(
            (),
            *(
                () if numbers is None else tuple(numbers_of(scene, name, numbers).ravel().tolist())
                for name, numbers in (("q0", q0), ("v0", v0), ("q0", counted))
            ),
        )
    if q0 is not None or v0 is not None:
        raise refusal(f"{scene}: give either initial, or q0 and v0")
    if not isinstance(initial, Mapping):
        raise refusal(
            f"{scene}: initial {shown(initial)}; wanted a mapping of coordinates, or of rates"
            ' as "theta_dot", to numbers'
        )
    lengths = {
        key: is_length for name, is_length, _ in layout.coordinates for key in (name, f"{name}_dot")
    }
    if initial and not lengths:
        raise refusal(
            f"{scene}: no coordinates for initial {shown([*initial])}: the scene names none,"
            ' or was generated without "coordinates"; load(..., outputs=[..., "coordinates"])'
        )
    values, problems = {}, []
    for name, value in initial.items():
        if name not in lengths:
            problems.append(unknown("coordinate", name, [*lengths]))
            continue
        try:
            values[name] = number_in(value, is_length=lengths[name])
        except (TypeError, ValueError, OverflowError):
            wanted = "" if lengths[name] else ", or an angle such as '30 deg'"
            problems.append(f"initial {name} is {shown(value)}; wanted a finite number{wanted}")
    if problems:
        raise refusal(f"{scene}: {'; '.join(problems)}")
    return InitialValues(tuple(values.items()))
