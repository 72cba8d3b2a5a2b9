"""Functions of a system whose roots a run looks for: events, kinks, jumps, poles."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.expressions.exponentials import without_overflow
from kousoku.model.expressions.folds import without_folds
from kousoku.model.expressions.formulas import LAW_NAMES, RATE, TIME, used_names
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.switching import (
    edges_of,
    has_fractional_power,
    is_jump,
    jumping_functions,
    places_of,
    poles_of,
    square,
    squares_of,
    summands,
    switching_functions,
    varies,
    varying_parts,
    with_rates,
)
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.driven_lengths import driven_lengths
from kousoku.model.mechanics.constraints import is_length
from kousoku.model.operations.expression import (
    ZERO,
    add,
    apply,
    mul,
    names_of,
    neg,
    number,
    ordered,
    replaced,
    symbol,
)
from kousoku.model.operations.graph import Op
from kousoku.model.records.dotted_keys import join

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping

    from kousoku.model.mechanics.multibody import ForceElement, System
    from kousoku.model.operations.expression import Expression


#: A distance counts as none that is no more than this part of what it is at the start: rounding of
#: places hides most digits of its direction there.
NO_DISTANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Measure:
    """Quantity of a state in formulas: a coordinate, or the elongation of a spring.

    Of a spring whose ends may meet it is the distance of these, too.

    Parameters
    ----------
    name : str
        Its name in formulas: that of the coordinate, or of the force with ``.x``.
    rate : str
        The name of its rate.
    coordinate : int
        Place of the coordinate, or of the one that a spring acts against; -1 of a spring between
        points.
    force : int
        Place of the spring, -1 of a coordinate.
    is_length : bool
        Whether it is the distance of a spring's ends.
    """

    name: str
    rate: str
    coordinate: int
    force: int
    is_length: bool = False


class PartScale(NamedTuple):
    """Units of a part of formulas, and the size of its constant factor.

    Parameters
    ----------
    units : tuple of str
        Units of its formulas: ``N``, ``N m``, ``m/s^2``, ``m``, ``rad``, with the unit of the
        scene for a metre.
    size : float
        With the parameters of the scene.
    """

    units: tuple[str, ...]
    size: float


@dataclass(frozen=True, slots=True)
class RootFunctions:
    """Functions that a run watches, so that no step leaps over their roots and narrow parts.

    Parameters
    ----------
    switches, features : tuple of Expression
        Functions of time: those that are zero where a formula has a kink or a jump, and smooth
        parts that vary with it beyond polynomials.
    measures : tuple of Measure
        What those below depend on beside time and parameters.
    crossings : tuple of Expression
        The formulas of events, then functions of the state that are zero where a formula has a
        kink, or one of an event gets or loses its value.
    narrow : tuple of Expression
        Smooth parts that vary with the state beyond polynomials.
    jumps : tuple of bool
        Of each event whether its formula may jump, also through infinity.
    laws : tuple of Expression
        Those of drivers that are no polynomials, with two derivatives, which must not jump.
    law_drivers : tuple of str
        Which driver each of these laws, of three expressions, is of.
    poles : tuple of Expression
        Functions of time and the state that are zero where a force may be infinite.
    pole_forces : tuple of str
        The key of the force that each of them is of.
    infinite : tuple of Expression
        The parts of formulas that may be infinite there.
    lengths : tuple of Expression
        Squares of lengths along which forces act: these turn round where they come down to zero.
    distances : tuple of Expression
        Squares of distances in formulas, of points or of speeds from rest, likewise.
    gaps : tuple of Expression
        What drivers prescribe of distances, less what counts as none: where one is zero its two
        points meet, and nothing tells in which direction they part.
    gap_drivers : tuple of str
        Which driver each of these is of.
    breaks : tuple of Expression
        Functions of the state that are zero where a formula jumps, and with it a force.
    has_fractional_powers : bool
        Whether a force goes with a fractional power of what may be zero.
    narrow_scales, feature_scales : tuple of PartScale
        Of narrow parts, and of features.
    """

    switches: tuple[Expression, ...]
    features: tuple[Expression, ...]
    measures: tuple[Measure, ...]
    crossings: tuple[Expression, ...]
    narrow: tuple[Expression, ...]
    jumps: tuple[bool, ...] = ()
    laws: tuple[Expression, ...] = ()
    law_drivers: tuple[str, ...] = ()
    poles: tuple[Expression, ...] = ()
    pole_forces: tuple[str, ...] = ()
    infinite: tuple[Expression, ...] = ()
    lengths: tuple[Expression, ...] = ()
    distances: tuple[Expression, ...] = ()
    gaps: tuple[Expression, ...] = ()
    gap_drivers: tuple[str, ...] = ()
    breaks: tuple[Expression, ...] = ()
    has_fractional_powers: bool = False
    narrow_scales: tuple[PartScale, ...] = ()
    feature_scales: tuple[PartScale, ...] = ()


def root_functions_of(system: System) -> RootFunctions:
    """Functions that runs of a system watch: of forces, gravity, drivers, and events."""
    measures = tuple(_measures(system))
    parameters = {name for name, _ in system.parameters}
    names = {TIME, *parameters}
    names.update(chain.from_iterable((one.name, one.rate) for one in measures))
    texts = dict.fromkeys(text for text, *_ in _texts(system) if text)
    pushing = {text for text, key, _ in _texts(system) if key}  # arcs in laws of drivers stay
    parsed = {
        text: without_folds(
            parse_expression(text, names, longest=len(text)),
            parameters if text in pushing else None,
        )[0]
        for text in texts
    }
    formulas = list(parsed.values())
    events = [parse_expression(one.when, names) for one in system.events]
    of_state = {name for one in measures for name in (one.name, one.rate)}

    def found(
        parts: Callable[[Expression], Iterator[Expression]], *, is_state: bool
    ) -> tuple[Expression, ...]:
        every = dict.fromkeys(chain.from_iterable(map(parts, formulas)))
        used = ((one, set(names_of(one))) for one in every)
        if is_state:
            return tuple(one for one, own in used if own & of_state)
        return tuple(one for one, own in used if TIME in own and not own & of_state)

    edges = dict.fromkeys(filter(names_of, chain.from_iterable(map(edges_of, events))))
    breaks = found(jumping_functions, is_state=True)
    kinks = (one for one in found(switching_functions, is_state=True) if one not in breaks)
    crossings = (*events, *kinks, *edges)
    changing = {TIME, *of_state}
    varying = _varying_parts(system, parsed, changing)
    narrow = {one: of for one, of in varying.items() if of_state.intersection(names_of(one))}
    features = {one: of for one, of in varying.items() if one not in narrow and varies(one)}
    led = {
        place: parse_expression(one.law, names, longest=len(one.law))
        for place, one in enumerate(system.constraints)
        if one.law
    }
    laws: dict[Expression, str] = {}
    for place, law in led.items():
        laws.setdefault(law, system.constraints[place].joint)
    bends = {one: tuple(filter(varies, places_of(one))) for one in laws}
    followed = [one for one, places in bends.items() if places or any(varying_parts(one, {TIME}))]
    drawn = [*driven_lengths(system, led)]
    gaps = {
        add(one.law, neg(_nearly_none(one.law, system))): one.driver
        for one in drawn
        if varies(one.law)
    }
    switches = (*gaps, *found(switching_functions, is_state=False), *chain(*bends.values()))
    poles: dict[Expression, str] = {}
    infinite: dict[Expression, None] = {}
    for text, key, _ in _texts(system):
        if text and key:
            for part in summands(parsed[text]):
                own = dict.fromkeys(poles_of(part, {TIME, *of_state}), key)
                poles = own | poles
                infinite |= dict.fromkeys([part] * bool(own))
    lengths = tuple(_lengths(system))
    distances = tuple(one for one in found(squares_of, is_state=True) if one not in lengths)
    told = (*crossings, *breaks, *narrow, *poles, *infinite, *lengths, *distances)
    read = set(chain.from_iterable(map(names_of, told)))
    return RootFunctions(
        switches=tuple(dict.fromkeys(switches)),
        features=tuple(features),
        measures=tuple(one for one in measures if {one.name, one.rate} & read),
        crossings=crossings,
        narrow=tuple(narrow),
        jumps=tuple(any(map(is_jump, ordered(one))) for one in events),
        laws=tuple(chain.from_iterable(map(with_rates, followed))),
        law_drivers=tuple(laws[one] for one in followed),
        poles=tuple(poles),
        pole_forces=tuple(poles.values()),
        infinite=tuple(infinite),
        lengths=lengths,
        distances=distances,
        gaps=tuple(gaps),
        gap_drivers=tuple(gaps.values()),
        breaks=breaks,
        has_fractional_powers=any(
            has_fractional_power(parsed[text], changing) for text in texts if text in pushing
        ),
        narrow_scales=tuple(narrow.values()),
        feature_scales=tuple(features.values()),
    )


def _varying_parts(
    system: System, parsed: Mapping[str, Expression], varying: Collection[str]
) -> dict[Expression, PartScale]:
    """Parts of formulas that vary beyond polynomials, with their constants, and in what units."""
    units: dict[Expression, dict[str, None]] = {}
    sizes: dict[Expression, float] = {}
    for text, _, unit in _texts(system):
        for part, factor in varying_parts(parsed[text], varying) if text else ():
            one = without_overflow(mul(factor, part))
            units.setdefault(one, {})[unit] = None
            sizes[one] = abs(value_of(factor, dict(system.parameters)))
    return {one: PartScale(tuple(of), sizes[one]) for one, of in units.items()}


def _nearly_none(law: Expression, system: System) -> Expression:
    """Part of what a law of a distance is at the start that counts as none, with any parameters."""
    if not isfinite(value_of(law, {TIME: 0.0, **dict(system.parameters)})):
        return ZERO
    start = apply(Op.ABS, replaced(law, symbol(TIME), ZERO))
    if names_of(start):
        return mul(number(Fraction(NO_DISTANCE)), start)
    return number(Fraction(NO_DISTANCE * value_of(start, {})))


def _measures(system: System) -> Iterator[Measure]:
    for place, one in enumerate(system.coordinates):
        yield Measure(one.name, f"{one.name}{RATE}", place, -1)
    for place, force in enumerate(system.forces):
        if force.law:
            x, v = (f"{force.name}_{place}.{name}" for name in LAW_NAMES[:2])
            yield Measure(x, v, force.coordinate, place)
        if force.needs_direction:
            yield Measure(*_length_of(place, force), -1, place, is_length=True)


def _length_of(place: int, force: ForceElement) -> tuple[str, str]:
    """Names of the distance of a spring's ends and of its rate."""
    name = f"{force.name}_{place}.l"
    return name, f"{name}{RATE}"


def _lengths(system: System) -> Iterator[Expression]:
    """Squares of the lengths along which forces act, or that they depend on."""
    texts = [text for text, *_ in _texts(system) if text]
    acted = {force.coordinate for force in system.forces}
    for place, one in enumerate(system.coordinates):
        names = (one.name, f"{one.name}{RATE}")
        if one.is_distance and (place in acted or any(used_names(text, names) for text in texts)):
            yield square(symbol(one.name))
    for place, force in enumerate(system.forces):
        if force.needs_direction:
            yield square(symbol(_length_of(place, force)[0]))


def _texts(system: System) -> Iterator[tuple[str, str, str]]:
    """Formulas with the key of what pushes, and their unit; springs name their own length."""
    for place, force in enumerate(system.forces):
        key, unit = join("forces", force.name), "N m" if _is_moment(force, system) else "N"
        yield from ((text, key, unit) for _, text in force.formulas)
        text = force.law
        for name in LAW_NAMES[:2]:
            text = re.sub(rf"\b{name}\b", f"{force.name}_{place}.{name}", text)
        yield text, key, unit
    yield from ((text, "gravity", "m/s^2") for text in system.gravity_law)
    yield from ((one.law, "", one.row_unit) for one in system.constraints)


def _is_moment(force: ForceElement, system: System) -> bool:
    """Whether a force turns a body, or acts along an angle."""
    if force.coordinate >= 0:
        return not is_length(system.coordinates[force.coordinate].kind)
    return force.is_torque
