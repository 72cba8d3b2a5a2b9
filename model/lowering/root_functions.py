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
    breaks_of_law,
    edges_of,
    has_fractional_power,
    is_jump,
    jumping_functions,
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


#: A distance up to this part of its initial value counts as zero: rounding of positions hides most
#: digits of its direction there.
NO_DISTANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Measure:
    """Quantity of a state in formulas: a coordinate, or the elongation of a spring.

    A spring whose ends may meet has the distance of these as a further one.

    Parameters
    ----------
    name : str
        Its name in formulas: that of the coordinate, or of the force with ``.x``.
    rate : str
        The name of its rate.
    coordinate : int
        Index of the coordinate, or of the one that a spring acts against; -1 of a spring between
        points.
    force : int
        Index of the spring, -1 of a coordinate.
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
        Quantities that the functions below depend on beside time and parameters.
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
        The driver of each of these laws, which have three expressions each.
    poles : tuple of Expression
        Functions of time and the state that are zero where a force may be infinite.
    pole_forces : tuple of str
        The key of the force of each pole.
    infinite : tuple of Expression
        The parts of formulas that may be infinite there.
    lengths : tuple of Expression
        Squares of lengths along which forces act: these turn round where they come down to zero.
    distances : tuple of Expression
        Squares of distances in formulas, of points or of speeds from rest, likewise.
    gaps : tuple of Expression
        Distances that drivers prescribe, less the length that counts as zero: where one is zero its
        two points meet, and nothing tells in which direction they part.
    gap_drivers : tuple of str
        The driver of each gap.
    breaks : tuple of Expression
        Functions of the state that are zero where a formula jumps, and with it a force.
    has_fractional_powers : bool
        Whether a force depends on a fractional power of a quantity that may be zero.
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
    names.update(chain.from_iterable((measure.name, measure.rate) for measure in measures))
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
    events = [parse_expression(event.when, names) for event in system.events]
    of_state = {name for measure in measures for name in (measure.name, measure.rate)}

    def collect(
        extract: Callable[[Expression], Iterator[Expression]], *, is_state: bool
    ) -> tuple[Expression, ...]:
        functions = dict.fromkeys(chain.from_iterable(map(extract, formulas)))
        used = ((function, set(names_of(function))) for function in functions)
        if is_state:
            return tuple(function for function, names in used if names & of_state)
        return tuple(function for function, names in used if TIME in names and not names & of_state)

    edges = dict.fromkeys(filter(names_of, chain.from_iterable(map(edges_of, events))))
    breaks = collect(jumping_functions, is_state=True)
    kinks = (kink for kink in collect(switching_functions, is_state=True) if kink not in breaks)
    crossings = (*events, *kinks, *edges)
    changing = {TIME, *of_state}
    scales = _varying_parts(system, parsed, changing)
    narrow = {part: scale for part, scale in scales.items() if of_state & {*names_of(part)}}
    features = {
        part: scale for part, scale in scales.items() if part not in narrow and varies(part)
    }
    driver_laws = {
        index: parse_expression(constraint.law, names, longest=len(constraint.law))
        for index, constraint in enumerate(system.constraints)
        if constraint.law
    }
    laws: dict[Expression, str] = {}
    for index, law in driver_laws.items():
        laws.setdefault(law, system.constraints[index].joint)
    law_breaks = {law: tuple(filter(varies, breaks_of_law(law))) for law in laws}
    watched_laws = [
        law for law, roots in law_breaks.items() if roots or any(varying_parts(law, {TIME}))
    ]
    gaps = {
        add(length.law, neg(_negligible_distance(length.law, system))): length.driver
        for length in driven_lengths(system, driver_laws)
        if varies(length.law)
    }
    switches = (*gaps, *collect(switching_functions, is_state=False), *chain(*law_breaks.values()))
    poles: dict[Expression, str] = {}
    infinite: dict[Expression, None] = {}
    for text, key, _ in _texts(system):
        if text and key:
            for part in summands(parsed[text]):
                part_poles = dict.fromkeys(poles_of(part, {TIME, *of_state}), key)
                poles = part_poles | poles
                infinite |= dict.fromkeys([part] * bool(part_poles))
    lengths = tuple(_lengths(system))
    squares = collect(squares_of, is_state=True)
    distances = tuple(distance for distance in squares if distance not in lengths)
    of_motion = (*crossings, *breaks, *narrow, *poles, *infinite, *lengths, *distances)
    used = set(chain.from_iterable(map(names_of, of_motion)))
    return RootFunctions(
        switches=tuple(dict.fromkeys(switches)),
        features=tuple(features),
        measures=tuple(measure for measure in measures if {measure.name, measure.rate} & used),
        crossings=crossings,
        narrow=tuple(narrow),
        jumps=tuple(any(map(is_jump, ordered(event))) for event in events),
        laws=tuple(chain.from_iterable(map(with_rates, watched_laws))),
        law_drivers=tuple(laws[law] for law in watched_laws),
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
    """Parts of formulas that vary beyond polynomials, times their constants, with units."""
    units: dict[Expression, dict[str, None]] = {}
    sizes: dict[Expression, float] = {}
    for text, _, unit in _texts(system):
        for part, factor in varying_parts(parsed[text], varying) if text else ():
            scaled = without_overflow(mul(factor, part))
            units.setdefault(scaled, {})[unit] = None
            sizes[scaled] = abs(value_of(factor, dict(system.parameters)))
    return {scaled: PartScale(tuple(own), sizes[scaled]) for scaled, own in units.items()}


def _negligible_distance(law: Expression, system: System) -> Expression:
    """Length that counts as zero beside the initial value of a law, whatever the parameters."""
    if not isfinite(value_of(law, {TIME: 0.0, **dict(system.parameters)})):
        return ZERO
    start = apply(Op.ABS, replaced(law, symbol(TIME), ZERO))
    if names_of(start):
        return mul(number(Fraction(NO_DISTANCE)), start)
    return number(Fraction(NO_DISTANCE * value_of(start, {})))


def _measures(system: System) -> Iterator[Measure]:
    for index, coordinate in enumerate(system.coordinates):
        yield Measure(coordinate.name, f"{coordinate.name}{RATE}", index, -1)
    for index, force in enumerate(system.forces):
        if force.law:
            x, v = (f"{force.name}_{index}.{name}" for name in LAW_NAMES[:2])
            yield Measure(x, v, force.coordinate, index)
        if force.needs_direction:
            yield Measure(*_distance_names(index, force), -1, index, is_length=True)


def _distance_names(index: int, force: ForceElement) -> tuple[str, str]:
    """Names of the distance of a spring's ends and of its rate."""
    name = f"{force.name}_{index}.l"
    return name, f"{name}{RATE}"


def _lengths(system: System) -> Iterator[Expression]:
    """Squares of the lengths along which forces act, or that they depend on."""
    texts = [text for text, *_ in _texts(system) if text]
    acted = {force.coordinate for force in system.forces}
    for index, coordinate in enumerate(system.coordinates):
        names = (coordinate.name, f"{coordinate.name}{RATE}")
        if coordinate.is_distance and (
            index in acted or any(used_names(text, names) for text in texts)
        ):
            yield square(symbol(coordinate.name))
    for index, force in enumerate(system.forces):
        if force.needs_direction:
            yield square(symbol(_distance_names(index, force)[0]))


def _texts(system: System) -> Iterator[tuple[str, str, str]]:
    """Formulas with the key of a force or gravity, and unit; springs name their own length."""
    for index, force in enumerate(system.forces):
        key, unit = join("forces", force.name), "N m" if _is_moment(force, system) else "N"
        yield from ((text, key, unit) for _, text in force.formulas)
        text = force.law
        for name in LAW_NAMES[:2]:
            text = re.sub(rf"\b{name}\b", f"{force.name}_{index}.{name}", text)
        yield text, key, unit
    yield from ((text, "gravity", "m/s^2") for text in system.gravity_law)
    yield from ((driver.law, "", driver.row_unit) for driver in system.constraints)


def _is_moment(force: ForceElement, system: System) -> bool:
    """Whether a force turns a body, or acts along an angle."""
    if force.coordinate >= 0:
        return not is_length(system.coordinates[force.coordinate].kind)
    return force.is_torque
