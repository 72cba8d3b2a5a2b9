"""The numbers of a program that depend on parameters: where they are, and how they are computed.

They stand in the region ``design``. The segment ``setup`` computes them from the parameters, once
where a run begins. A scene whose formulas of parameters stand in forces and drivers only has
neither.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from kousoku.model.numbers import precise
from kousoku.model.numbers.traced import Traced, at_scene
from kousoku.model.numbers.varying import Varying, is_varying

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import BodyCoordinates
    from kousoku.model.mechanics.multibody import Carried, MovingBody, System
    from kousoku.model.numbers.precise import High, Quadruple, Triple


@dataclass(frozen=True, slots=True)
class DesignNumbers:
    """The numbers of a program that depend on parameters.

    Parameters
    ----------
    places : tuple of (str, int)
        The key of each formula, and its place in the region ``design``.
    start : tuple of (int, str)
        Slots of q and v whose value at the start depends on parameters, and the key of the value.
    positive : tuple of (str, str)
        Keys of the scene whose numbers must be positive, and the keys of their formulas.
    names : tuple of str
        The parameters that the numbers depend on.
    """

    places: tuple[tuple[str, int], ...] = ()
    start: tuple[tuple[int, str], ...] = ()
    positive: tuple[tuple[str, str], ...] = ()
    names: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        places: Mapping[str, int],
        start: Sequence[tuple[int, float]],
        positive: Sequence[tuple[str, float]],
        names: Iterable[str],
    ) -> DesignNumbers:
        """Design numbers, from numbers in place of their keys."""
        return cls(
            tuple(places.items()),
            tuple((slot, formula_key(value)) for slot, value in start),
            tuple((name, formula_key(value)) for name, value in positive),
            tuple(dict.fromkeys(names)),
        )

    def moved(self, slots: Mapping[int, int]) -> DesignNumbers:
        """The same in a workspace where slots have moved."""
        return replace(self, start=tuple((slots[slot], key) for slot, key in self.start))

    def __bool__(self) -> bool:
        return bool(self.places)

    def place(self, value: float) -> int:
        """Place of a number that depends on parameters."""
        return dict(self.places)[formula_key(value)]


def formula_key(value: float) -> str:
    """Key of a number that depends on parameters."""
    assert isinstance(value, Varying)
    return value.traced.expression.key


def number(value: float) -> High:
    """Number of a system to compute with, exactly: a fraction, or a formula."""
    return value.traced if isinstance(value, Varying) else Fraction(value)


def shown_numbers(system: System) -> Iterator[float]:
    """Numbers that readers of results need, and that depend on parameters."""
    shown: list[MovingBody | Carried] = [*system.bodies, *system.carried]
    for body in shown:
        yield from (x for x in (*body.origin_b, *body.axes_b) if is_varying(x))
    for written in system.written_starts:
        yield from (x for x in written.mass_properties if is_varying(x))
    yield from (value for _, value in system.positive)


def start_of(body: MovingBody) -> tuple[Triple, Quadruple, Triple, Triple]:
    """Position r, p and velocity v, ω′ at the start: the user's frame stays where the scene has it.

    Where nothing of the body depends on parameters they are the numbers of the system.
    """
    r, v, omega = (precise.triple(values) for values in (body.r, body.v, body.omega_b))
    p = precise.quadruple(body.p)
    if not is_varying((*body.origin_b, *body.axes_b)):
        return r, p, v, omega
    origin, axes = precise.triple(body.origin_b), precise.quadruple(body.axes_b)
    old_origin, (w, x, y, z) = _in_scene(origin), _in_scene(axes)
    old = w, x, y, z
    turned, spin = p, omega
    if is_varying(body.axes_b):
        turned = precise.compose(precise.compose(p, old), precise.conjugate(axes))
        spin = precise.rotate(axes, precise.rotate_back(old, omega))
    place = precise.add(r, precise.rotate(p, old_origin))
    velocity = precise.add(v, precise.rotate(p, precise.cross(omega, old_origin)))
    arm, rate = (precise.rotate(turned, s) for s in (origin, precise.cross(spin, origin)))
    return precise.subtract(place, arm), turned, precise.subtract(velocity, rate), spin


def starts(system: System, bodies: Sequence[BodyCoordinates]) -> list[tuple[int, float]]:
    """Slots of q and v whose value at the start depends on parameters, and the value."""
    values_at_start = []
    for body, state in zip(system.bodies, bodies, strict=True):
        slots = (state.r, state.p, state.v, state.omega_b)
        for vector, values in zip(slots, start_of(body), strict=True):
            for place, value in zip(vector, values, strict=True):
                if place.slot >= 0 and isinstance(value, Traced):
                    values_at_start.append((place.slot, precise.double(value)))
    return values_at_start


def _in_scene(values: Sequence[High]) -> Any:
    return tuple(map(at_scene, values))
