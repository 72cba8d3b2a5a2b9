"""What the symbols of "three mass points" mean: points carried by a frame, under Newton's law.

Everything is found on the component level: positions are differentiated along ṗ = ½ p∘(0, ω′).
An internal force is central, and opposite to the one on the other point. An external force is what
Newton's law leaves of m a without the internal ones, so that each equation of motion becomes an
identity. Nothing that an entry states is used.
"""

from __future__ import annotations

from functools import cache, reduce
from itertools import combinations
from typing import TYPE_CHECKING, Any

from sympy import S
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.ledger.checks import equal
from kousoku.ledger.entry import Check
from kousoku.ledger.proof import refuted
from kousoku.ledger.turning import along, flat, orientation, turned
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.components import cross, dot, plus, subtract
from kousoku.symbolic.mass import FORCE, I_A_B, MASS, OMEGA_B, R_AG_B, TORQUE_B, P
from kousoku.symbolic.matrices import Orientation, elements, symbol

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.ledger.vocabulary import Value

Vector = list[Any]

R = Quantity("r", (3,), "m", "position of frame A's origin, frame O")
V = Quantity("v", (3,), "m/s", "its velocity, frame O")
V_DOT = Quantity("v_dot", (3,), "m/s^2", "its acceleration, frame O")
OMEGA_DOT = Quantity("omega_b_dot", (3,), "rad/s^2", "change of the angular velocity, frame A")
M = Quantity("m", (3,), "kg", "masses")
S_B = Quantity("s_b", (3, 3), "m", "places of the points, frame A, one a row")
K = Quantity("k", (3,), "N/m", "internal force of each pair of points, over their distance")
#: How the document writes the acceleration of point i.
ACCELERATION = (
    r"a_{OA}^O - \{C_{OA} cross(\omega_{A}^A)  \} cross(r_{Ai}^A) \omega_{A}^A"
    r" - C_{OA} cross(r_{Ai}^A)  \{\frac{d}{dt}\omega_{A}^A \}"
)
MOTION = (R, V, V_DOT, P, OMEGA_B, OMEGA_DOT)


@cache
def words() -> Vocabulary:
    """Return what the symbols mean for points 1, 2 and 3, anywhere in frame A."""
    return carried("123", _rows(), (*MOTION, M, S_B, K))


@cache
def one_point() -> Vocabulary:
    """Return what they mean for any point i; j and k are the two others."""
    return carried("ijk", _rows(), (*MOTION, M, S_B, K))


@cache
def centred() -> Vocabulary:
    """Return what they mean where the origin of frame A is the centre of mass."""
    first, second = (Quantity(f"s_{k}_b", (3,), "m", f"point {k}, frame A") for k in (1, 2))
    m_1, m_2, m_3 = elements(M)
    places = [list(elements(first)), list(elements(second))]
    places.append([-(m_1 * x + m_2 * y) / m_3 for x, y in zip(*places, strict=True)])
    return carried("123", places, (*MOTION, M, first, second, K))


@cache
def body() -> Vocabulary:
    """Return what they mean for any rigid body, given by mass, centre and inertia."""
    meanings = {
        "C_OA": Orientation(symbol(P)),
        "E": Identity(3),
        "ω_A^A": symbol(OMEGA_B),
        "M_A": symbol(MASS),
        "r_AG^A": symbol(R_AG_B),
        "I_A^A": symbol(I_A_B),
        "F_A^O": symbol(FORCE),
        "N_A^A": symbol(TORQUE_B),
    }
    return Vocabulary((P, OMEGA_B, MASS, R_AG_B, I_A_B, FORCE, TORQUE_B), meanings)


@cache
def any_vectors() -> Vocabulary:
    """Return a and b, any two vectors."""
    return free({name: Quantity(name, (3,), "-", "any vector") for name in "ab"})


def _rows() -> list[Vector]:
    cells = elements(S_B)
    return [list(cells[k : k + 3]) for k in (0, 3, 6)]


def rate() -> Callable[[Sequence[Any]], Vector]:
    """Return d/dt of the components of a vector, along the motion of frame A."""
    flow = along((R, V), (V, V_DOT), (P, OMEGA_B), (OMEGA_B, OMEGA_DOT))
    return lambda vector: [flow(x) for x in vector]


def carried(labels: str, places: Sequence[Vector], quantities: tuple[Quantity, ...]) -> Vocabulary:
    """Return what the symbols mean for three points that frame A carries.

    Parameters
    ----------
    labels : str
        The letters by which the document tells the points apart.
    places : sequence of list
        Their components in frame A, which do not change.
    quantities : tuple of Quantity
        All that the points are made of.
    """
    change = rate()
    arms = [turned(P, place) for place in places]
    internal = _internal(arms)
    vectors: dict[str, Vector] = {}
    external: list[Vector] = []
    for i, (label, place, arm) in enumerate(zip(labels, places, arms, strict=True)):
        position = plus(elements(R), arm)
        velocity = change(position)
        acceleration = change(velocity)
        inner = added([force for (one, _), force in internal.items() if one == i])
        external.append(subtract(scaled(elements(M)[i], acceleration), inner))
        vectors |= {f"r_A{label}^A": place, f"vec r_A{label}": arm, f"r_O{label}^O": position}
        vectors |= {f"v_O{label}^O": velocity, f"a_O{label}^O": acceleration}
        vectors |= {f"f_{label}^O": external[i]}
    for (i, j), force in internal.items():
        pair = labels[i] + labels[j]
        vectors |= {f"f_{pair}^O": force, f"vec f_{pair}": force}
    vectors |= _sums(places, arms, external)
    meanings = {name: MatrixSymbol(name, 3, 1) for name in vectors}
    meanings |= {f"m_{label}": m for label, m in zip(labels, elements(M), strict=True)}
    given = {**vectors, **_matrices(places), "s_b": flat(places), "f": flat(external)}
    return Vocabulary(quantities, {**meanings, **_common()}, given)


def _internal(arms: Sequence[Vector]) -> dict[tuple[int, int], Vector]:
    """Return the force on each point from each other: along the line between them, opposite."""
    forces: dict[tuple[int, int], Vector] = {}
    for strength, (i, j) in zip(elements(K), combinations(range(3), 2), strict=True):
        forces[i, j] = scaled(strength, subtract(arms[i], arms[j]))
        forces[j, i] = scaled(strength, subtract(arms[j], arms[i]))
    return forces


def _sums(
    places: Sequence[Vector], arms: Sequence[Vector], external: Sequence[Vector]
) -> dict[str, Vector]:
    """Return the centre, its motion, and the resultants of the external forces."""
    masses, change = elements(M), rate()
    total = sum(masses, S.Zero)
    weighed = [
        [x / total for x in added([scaled(m, v) for m, v in zip(masses, vectors, strict=True)])]
        for vectors in (places, arms)
    ]
    centre = plus(elements(R), weighed[1])
    torque = added([cross(arm, force) for arm, force in zip(arms, external, strict=True)])
    return {
        "r_AG^A": weighed[0],
        "r_OG^O": centre,
        "a_OG^O": change(change(centre)),
        "F_A^O": added(external),
        "N_A^A": [dot(column, torque) for column in zip(*orientation(P), strict=True)],
    }


def _matrices(places: Sequence[Vector]) -> dict[str, Vector]:
    """Return dC/dt, and the inertia Σ m (s·s E − s sᵀ), row-major."""
    inertia = [
        sum(
            (
                m * ((dot(s, s) if a == b else S.Zero) - s[a] * s[b])
                for m, s in zip(elements(M), places, strict=True)
            ),
            S.Zero,
        )
        for a in range(3)
        for b in range(3)
    ]
    return {"I_A^A": inertia, "d/dt C_OA": rate()(flat(orientation(P)))}


def _common() -> dict[str, Value]:
    """Return what is not of single points."""
    return {
        "C_OA": Orientation(symbol(P)),
        "d/dt C_OA": MatrixSymbol("d/dt C_OA", 3, 3),
        "E": Identity(3),
        "r_OA^O": symbol(R),
        "v_OA^O": symbol(V),
        "a_OA^O": symbol(V_DOT),
        "ω_A^A": symbol(OMEGA_B),
        "d/dt ω_A^A": symbol(OMEGA_DOT),
        "M_A": sum(elements(M), S.Zero),
        "I_A^A": MatrixSymbol("I_A^A", 3, 3),
    }


def added(vectors: Sequence[Vector]) -> Vector:
    """Return the sum of vectors."""
    return reduce(plus, vectors)


def scaled(number: Any, vector: Sequence[Any]) -> Vector:
    """Return a number times a vector."""
    return [number * x for x in vector]


def over_points(term: str) -> str:
    """Return the terms of points 1, 2 and 3, each ``#`` being the number, side by side."""
    return " ".join(term.replace("#", number) for number in "123")


def free(vectors: Mapping[str, Quantity]) -> Vocabulary:
    """Return a vocabulary of vectors that nothing binds."""
    quantities = tuple(vectors.values())
    return Vocabulary(quantities, {name: symbol(q) for name, q in vectors.items()})


def unreadable(statement: str, formula: str, vocabulary: Callable[[], Vocabulary] = words) -> Check:
    """Return the check that a formula cannot be formed: its shapes do not fit."""

    def run() -> str:
        seen = refuted(formula, vocabulary())
        if not seen.startswith("cannot be formed"):
            raise LedgerError(f"it can be formed: {seen}")
        return seen

    return Check(statement, run)


# -- ties to the code ----------------------------------------------------------------------------


def derived(package: str, function: str, output: str) -> Value:
    """Return what the code's derivation says an output is."""
    functions = {f.name: f for f in derive(package).functions}
    found = {o.quantity.name: o.expression for o in functions[function].outputs}
    return found[output]


def in_code(
    package: str,
    output: str,
    formula: str,
    vocabulary: Callable[[], Vocabulary] = words,
) -> Check:
    """Return the check that an output of the code, ``function.output``, is what a formula says."""
    function, name = output.split(".")
    statement = f"the code's {package}.{function} gives this as {name}"
    return equal(statement, vocabulary, lambda: derived(package, function, name), formula)


def in_step(
    package: str,
    name: str,
    formula: str,
    vocabulary: Callable[[], Vocabulary] = words,
) -> Check:
    """Return the check that the last step about ``name`` in the code is what a formula says."""

    def right() -> Value:
        found = [s.right for s in derive(package).steps if getattr(s.left, "name", "") == name]
        if not found:
            raise LedgerError(f"the code's {package} has no step about {name}")
        return found[-1]

    return equal(
        f"the code's steps of {package} end with this as {name}", vocabulary, right, formula
    )
