"""Changes by assembly, reported so that no start is moved silently."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.numbers import precise
from kousoku.runtime.integrate.assembled_start import Change, Moved, known

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import MovingBody, System
    from kousoku.model.numbers.precise import Quadruple, Triple

#: A speed below this part of the scene's is rounding.
ROUNDING_OF_SPEEDS = 1e-12


def changes_of_assembly(written: System, placed: System) -> list[Change]:
    """Changes by assembly, the body that changed most first.

    Parameters
    ----------
    written, placed : System
        System before and after assembly.
    """
    written, placed = fixed_system(written), fixed_system(placed)
    size = Metric(written).size
    pairs = zip(written.bodies, placed.bodies, strict=True)
    return known(_change(before, after, size) for before, after in pairs)


def _change(before: MovingBody, after: MovingBody, size: float) -> Change:
    """Change of one body."""
    shift = _length(precise.subtract(_origin(after), _origin(before)))
    turn = precise.compose(normalised(after.p), precise.conjugate(normalised(before.p)))
    angle = 2 * float(precise.atan2(precise.length(turn[1:]), abs(turn[0])))
    v, omega = _velocity(before), precise.triple(before.omega_b)
    spin, speed = _length(omega), _length(v)
    fastest = speed + spin * size
    # the speed of an origin at rest, about which the body turns off its centre, is rounding
    moves = speed > ROUNDING_OF_SPEEDS * fastest
    change = _length(precise.subtract(_velocity(after), v)) if moves else 0.0
    omega_after = precise.triple(after.omega_b)
    if before.spins_in_o:
        omega, omega_after = (
            precise.rotate(_p(body), x) for body, x in ((before, omega), (after, omega_after))
        )
    spun = _length(precise.subtract(omega_after, omega)) if spin else 0.0
    rates = (change / fastest, spun * size / fastest) if fastest else (0.0, 0.0)
    sizes = Moved(shift, angle, change, spun)
    return Change(before.name, sizes, (shift / size, angle, *rates))


def _p(body: MovingBody) -> Quadruple:
    return normalised(body.p)


def _origin(body: MovingBody) -> Triple:
    """Origin of the user's frame of a body, frame O."""
    arm = precise.rotate(_p(body), precise.triple(body.origin_b))
    return precise.add(precise.triple(body.r), arm)


def _velocity(body: MovingBody) -> Triple:
    """Velocity of the origin of the user's frame of a body, frame O [m/s]."""
    turning = precise.cross(precise.triple(body.omega_b), precise.triple(body.origin_b))
    return precise.add(precise.triple(body.v), precise.rotate(_p(body), turning))


def _length(a: Triple) -> float:
    return float(precise.length(a))
