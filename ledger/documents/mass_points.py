"""Three mass points: points carried by a frame, under Newton's law, and proofs.

Everything is found on the component level: positions are differentiated along ṗ = ½ p∘(0, ω′).
An internal force is central, and opposite to the one on the other point. An external force is what
Newton's law leaves of m a without the internal ones, so that each equation of motion becomes an
identity. Nothing that an entry states is used.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, reduce
from itertools import combinations
from typing import TYPE_CHECKING, Any

from sympy import S
from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol, Transpose, ZeroMatrix

from kousoku.ledger import find
from kousoku.ledger.proof import GENERAL, derived, difference, different, equality, value_of
from kousoku.ledger.registry import Names
from kousoku.ledger.turning import along, flat, orientation, turned
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.components import Flow, cross, dot, plus, subtract
from kousoku.symbolic.mass import FORCE, I_A_B, MASS, R_AG_B, TORQUE_B
from kousoku.symbolic.mass_steps import OMEGA_B, P
from kousoku.symbolic.matrices import OrientationMatrix, Skew, elements, mul, neg, symbol
from kousoku.symbolic.sympy_types import Scalar

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.ledger.proof import Side
    from kousoku.ledger.registry import Words
    from kousoku.symbolic.sympy_types import SymbolicMatrix

NAMES = Names(GENERAL)

ScalarVector = list[Scalar]

R = Quantity("r", (3,), "m", "position of frame A's origin, frame O")
V = Quantity("v", (3,), "m/s", "its velocity, frame O")
V_DOT = Quantity("v_dot", (3,), "m/s^2", "its acceleration, frame O")
OMEGA_DOT = Quantity("omega_b_dot", (3,), "rad/s^2", "change of the angular velocity, frame A")
M = Quantity("m", (3,), "kg", "masses")
S_B = Quantity("s_b", (3, 3), "m", "places of the points, frame A, one a row")
K = Quantity("k", (3,), "N/m", "internal force of each pair of points, over their distance")
MOTION = (R, V, V_DOT, P, OMEGA_B, OMEGA_DOT)
#: Two points on which nothing else is known.
ARMS = tuple(Quantity(f"r_{k}", (3,), "m", f"point {k}") for k in (1, 2))
SPEEDS = tuple(Quantity(f"v_{k}", (3,), "m/s", f"velocity of point {k}") for k in (1, 2))
INNER = Quantity("f_12", (3,), "N", "force on point 1 from point 2, in any direction")


@NAMES.words
@cache
def words() -> Vocabulary:
    """Vocabulary of points 1, 2 and 3, anywhere in frame A."""
    return carried("123", _rows(), (*MOTION, M, S_B, K))


@NAMES.words
@cache
def one_point() -> Vocabulary:
    """Vocabulary of any point i; j and k are the two others."""
    return carried("ijk", _rows(), (*MOTION, M, S_B, K))


@NAMES.words
@cache
def centred() -> Vocabulary:
    """Vocabulary where the origin of frame A is the centre of mass."""
    first, second = (Quantity(f"s_{k}_b", (3,), "m", f"point {k}, frame A") for k in (1, 2))
    m_1, m_2, m_3 = elements(M)
    places = [list(elements(first)), list(elements(second))]
    places.append([-(m_1 * x + m_2 * y) / m_3 for x, y in zip(*places, strict=True)])
    return carried("123", places, (*MOTION, M, first, second, K))


@NAMES.words
@cache
def body() -> Vocabulary:
    """Vocabulary of any rigid body, given by mass, centre and inertia."""
    meanings = {
        "C_OA": OrientationMatrix(symbol(P)),
        "E": Identity(3),
        "ω_A^A": symbol(OMEGA_B),
        "M_A": symbol(MASS),
        "r_AG^A": symbol(R_AG_B),
        "I_A^A": symbol(I_A_B),
        "F_A^O": symbol(FORCE),
        "N_A^A": symbol(TORQUE_B),
    }
    return Vocabulary((P, OMEGA_B, MASS, R_AG_B, I_A_B, FORCE, TORQUE_B), meanings)


@NAMES.words
@cache
def any_vectors() -> Vocabulary:
    """Vocabulary of any two vectors a and b."""
    return free({name: Quantity(name, (3,), "-", "any vector") for name in "ab"})


@NAMES.words
@cache
def opposite() -> Vocabulary:
    """Vocabulary of two points and internal forces that are opposite, and no more than that."""
    words = free({"vec r_A1": ARMS[0], "vec r_A2": ARMS[1], "vec f_12": INNER})
    return words.knowing({"vec f_21": neg(symbol(INNER))})


@NAMES.words
@cache
def newton() -> Vocabulary:
    """Vocabulary of a point with its mass m, its acceleration a, and f, the change of m v."""
    known, change = one_point(), rate()
    momentum = scaled(elements(M)[0], known.given["v_Oi^O"])
    given = {**known.given, "f": change(momentum)}
    meanings = {"m": elements(M)[0], "a": known.meanings["a_Oi^O"], "f": MatrixSymbol("f", 3, 1)}
    return Vocabulary(known.quantities, {**known.meanings, **meanings}, given)


@NAMES.words
@cache
def on_one_line() -> Vocabulary:
    """Vocabulary of points on a line: through point 0, in direction t."""
    start, line = Quantity("s_0", (3,), "m", "point 0"), Quantity("t", (3,), "-", "direction")
    along_line = Quantity("x", (3,), "-", "where on the line each point is")
    places = [plus(elements(start), scaled(x, elements(line))) for x in elements(along_line)]
    known = carried("123", places, (*MOTION, M, start, line, along_line, K))
    return known.knowing({"r_A0^A": symbol(start), "t": symbol(line)})


@NAMES.words
@cache
def in_a_plane() -> Vocabulary:
    """Vocabulary of points in the plane of the motion: z = 0, ω along z."""
    x, y = (Quantity(f"{axis}_b", (3,), "m", f"{axis} of each point, frame A") for axis in "xy")
    places = [[*place, S.Zero] for place in zip(elements(x), elements(y), strict=True)]
    return _about_z(carried("123", places, (*MOTION, M, x, y, K)))


@NAMES.words
@cache
def off_the_plane() -> Vocabulary:
    """Vocabulary of points anywhere, and ω along z."""
    return _about_z(words())


def _about_z(known: Vocabulary) -> Vocabulary:
    spin = [S.Zero, S.Zero, elements(OMEGA_B)[2]]
    turning = replace(known, given={**known.given, "spin": spin})
    return turning.knowing({"ω_A^A": MatrixSymbol("spin", 3, 1)})


def _rows() -> list[ScalarVector]:
    cells = elements(S_B)
    return [list(cells[k : k + 3]) for k in (0, 3, 6)]


def rate() -> Callable[[Sequence[Any]], ScalarVector]:
    """Time derivative of the components of a vector, along the motion of frame A."""
    flow = along((R, V), (V, V_DOT), (P, OMEGA_B), (OMEGA_B, OMEGA_DOT))
    return lambda vector: [flow(x) for x in vector]


def carried(
    labels: str, places: Sequence[ScalarVector], quantities: tuple[Quantity, ...]
) -> Vocabulary:
    """Vocabulary of three points that frame A carries.

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
    vectors: dict[str, ScalarVector] = {}
    external: list[ScalarVector] = []
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


def _internal(arms: Sequence[ScalarVector]) -> dict[tuple[int, int], ScalarVector]:
    """Force on each point from each other: along the line between them, opposite."""
    forces: dict[tuple[int, int], ScalarVector] = {}
    for strength, (i, j) in zip(elements(K), combinations(range(3), 2), strict=True):
        forces[i, j] = scaled(strength, subtract(arms[i], arms[j]))
        forces[j, i] = scaled(strength, subtract(arms[j], arms[i]))
    return forces


def _sums(
    places: Sequence[ScalarVector], arms: Sequence[ScalarVector], external: Sequence[ScalarVector]
) -> dict[str, ScalarVector]:
    """Centre, its motion, and the resultants of the external forces."""
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


def _matrices(places: Sequence[ScalarVector]) -> dict[str, ScalarVector]:
    """Matrices dC/dt, and the inertia Σ m (s·s E − s sᵀ), row-major."""
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


def _common() -> dict[str, Scalar | SymbolicMatrix]:
    """Meanings that are not of single points."""
    return {
        "C_OA": OrientationMatrix(symbol(P)),
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


def added(vectors: Sequence[ScalarVector]) -> ScalarVector:
    """Sum of vectors."""
    return reduce(plus, vectors)


def scaled(number: Any, vector: Sequence[Any]) -> ScalarVector:
    """Number times a vector."""
    return [number * x for x in vector]


def free(vectors: Mapping[str, Quantity]) -> Vocabulary:
    """Vocabulary of vectors that nothing binds."""
    quantities = tuple(vectors.values())
    return Vocabulary(quantities, {name: symbol(q) for name, q in vectors.items()})


# -- ties to the code ----------------------------------------------------------------------------


@NAMES.proof("the code's {package}.{function} gives this as {output}")
def in_code(package: str, function: str, output: str, formula: str | Side, words: Words) -> str:
    """Prove that an output of a function of the code is that of a formula."""
    known = words()
    return equality(known, derived(package, function, output), value_of(formula, known))


@NAMES.proof("the code's steps of {package} end with this as {name}")
def in_step(package: str, name: str, formula: str | Side, words: Words) -> str:
    """Prove that the last step about a symbol in the code is a formula."""
    found = [s.right for s in derive(package).steps if getattr(s.left, "name", "") == name]
    if not found:
        raise LedgerError(f"the code's {package} has no step about {name}")
    known = words()
    return equality(known, found[-1], value_of(formula, known))


# -- points and forces ---------------------------------------------------------------------------


@NAMES.proof()
def distances_are_fixed() -> str:
    """Differentiate the distances of all pairs of points: they do not change."""
    change, given = rate(), words().given
    for one, other in (("1", "2"), ("1", "3"), ("2", "3")):
        apart = subtract(given[f"r_O{one}^O"], given[f"r_O{other}^O"])
        seen = equality(words(), change([dot(apart, apart)])[0], S.Zero)
    return f"for all three pairs: {seen}"


@NAMES.proof()
def internal_forces_turn() -> str:
    """Let two points move by their internal forces alone: Σ r × m v changes by the moment."""
    masses, force = Quantity("m", (2,), "kg", "masses"), elements(INNER)
    direction: dict[Any, Any] = {}
    for k, sign in enumerate((1, -1)):
        direction |= dict(zip(elements(ARMS[k]), elements(SPEEDS[k]), strict=True))
        pulled = [sign * x / elements(masses)[k] for x in force]
        direction |= dict(zip(elements(SPEEDS[k]), pulled, strict=True))
    flow = Flow(direction, ())
    turning = added(
        [
            scaled(m, cross(elements(r), elements(v)))
            for m, r, v in zip(elements(masses), ARMS, SPEEDS, strict=True)
        ]
    )
    moment = added([cross(elements(ARMS[0]), force), cross(elements(ARMS[1]), scaled(-1, force))])
    given = {"change": [flow(x) for x in turning], "moment": moment}
    known = Vocabulary((*ARMS, *SPEEDS, INNER, masses), {}, given)
    change = MatrixSymbol("change", 3, 1)
    seen = equality(known, change, MatrixSymbol("moment", 3, 1))
    witness = difference(known, change, ZeroMatrix(3, 1))
    if not witness:
        raise LedgerError("opposite forces never turn the points")
    return f"{seen}; not zero: {witness}"


@NAMES.proof()
def are_coefficients(formula: str) -> str:
    """Change the accelerations alone: F and N change by the matrix times that, and linearly."""
    changes = [Quantity(f"d{q.name}", (3,), q.unit, "its change") for q in (V_DOT, OMEGA_DOT)]
    flow = along(*zip((V_DOT, OMEGA_DOT), changes, strict=True))
    known = words()
    first = [flow(x) for name in ("F_A^O", "N_A^A") for x in known.given[name]]
    given = {**known.given, "first": first, "second": [flow(x) for x in first]}
    changing = replace(known, quantities=(*known.quantities, *changes), given=given)
    matrix = value_of(formula, changing)
    column = BlockMatrix([[symbol(q)] for q in changes])
    equality(changing, MatrixSymbol("second", 6, 1), ZeroMatrix(6, 1))
    return equality(changing, MatrixSymbol("first", 6, 1), mul(matrix, column))


@NAMES.proof("with N_A as printed, C_OA in place of its transpose, it does not hold")
def fails_with_printed_torque(formula: str | Side) -> str:
    """Prove that a balance of moments has another value than N_A as it is printed."""
    return different(words, formula, find("torque-definition").printed)


@NAMES.proof()
def transpose_is_negative() -> str:
    """Transpose the elements of a skew matrix one by one: it is minus itself."""
    known = any_vectors()
    transposed = Transpose(Skew(known.meaning("a")))
    return equality(known, transposed, value_of("-cross(a)", known))
