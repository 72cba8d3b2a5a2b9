"""Errors beyond the limit that are known: each with a point, and the figure that must not grow.

A form that keeps all digits at one of these points loses them at others that machines pass through,
or takes longer than what it is worth. They stand in the manifest, and ``verify`` holds a kernel to
its figure there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.operations.interpret import ARRAY, evaluate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.kernel import Kernel


@dataclass(frozen=True, slots=True)
class KnownError:
    """An output that is beyond the limit at a point.

    Parameters
    ----------
    output : str
        Of which kernel is said by the table.
    units : float
        How far it is off at most.
    inputs : mapping of str to tuple of float
        Where.
    """

    output: str
    units: float
    inputs: Mapping[str, tuple[float, ...]]


def known_errors(package: str, kernel: str) -> tuple[KnownError, ...]:
    """Errors of a kernel that are known."""
    return KNOWN.get((package, kernel), ())


def units_off(
    kernel: Kernel,
    output: str,
    inputs: Mapping[str, Sequence[float]],
    columns: Mapping[str, Sequence[float]],
) -> float:
    """Error in units of the worst element of an output, as doubles give it."""
    place = [quantity.name for quantity in kernel.outputs].index(output)
    doubles = {name: [np.float64(x) for x in xs] for name, xs in inputs.items()}
    got = evaluate(kernel, doubles, ARRAY)[output]
    values = np.array([float(got[element]) for element in kernel.nonzero(place)])
    high, low, unit = (np.array(columns[name]) for name in ("high", "low", "unit"))
    return float(np.max(np.abs((values - high) - low) / unit))


#: By package and kernel.
KNOWN: dict[tuple[str, str], tuple[KnownError, ...]] = {
    # Seen from j nothing is lost along the axes of j; this is the same along the axes of i.
    ("n1", "rates"): (
        KnownError(
            "gamma",
            117.63,
            {
                "p_i": (0.0, 0.2811117195655056, 0.0, -0.9596750497553455),
                "a_i_b": (0.0, 0.0, 0.1293059649415764),
                "p_j": (-1.0, 0.0, 0.0, 0.0),
                "a_j_b": (0.0, -12.65896709965742, 0.0),
                "omega_i_b": (35.16633056051795, 63.999999951084064, 0.0),
                "omega_j_b": (-0.0248470454345675, 0.06465298247078453, -0.053904751779270045),
            },
        ),
    ),
    # The same of a body that turns about the line to its point.
    ("spring_damper", "length"): (
        KnownError(
            "l_dot",
            80.45,
            {
                "r_i": (-0.9999808035035033, 0.0, 0.0),
                "p_i": (0.0, 0.0, 0.874376923688665, 0.48524735477975184),
                "s_i_b": (0.0, 0.0, 0.3986225003835145),
                "r_j": (0.0, 0.2433391728517497, 0.0),
                "p_j": (0.0, 0.0, 0.9983435476016059, -0.05753399831612796),
                "s_j_b": (63.99999999999978, 0.0, -2.000000000040762),
                "v_i": (0.0, -1.284072762315024, 0.0),
                "omega_i_b": (-1.0000043482883743, -0.11814025491433094, -63.99920114953119),
                "v_j": (0.0, 2.206073077497849, 0.0),
                "omega_j_b": (0.0, 0.0, -0.018283115322018574),
            },
        ),
    ),
    # Found by climbing from ordinary numbers.
    ("n2", "rates"): (
        KnownError(
            "gamma",
            5.15,
            {
                "r_i": (0.15319185916557274, -3.5965201969658347, -0.4945539661075617),
                "p_i": (
                    -0.1585481276343442,
                    -0.5487035312635475,
                    -0.2101527488079616,
                    0.7934877114177727,
                ),
                "a_i_b": (0.20467557421764815, 0.14025163684872513, -0.9845905341138635),
                "r_j": (-0.27334225655403777, 0.2340887321493547, 1.4613705098432859),
                "p_j": (
                    0.5383932315394252,
                    0.619085557594661,
                    -0.38995721433047853,
                    -0.4180899085147306,
                ),
                "s_j_b": (-0.6709012435065717, -0.28512209710515674, -1.760886568502486),
                "v_i": (2.137507602889394, 0.8538177540766716, -0.6074238590524805),
                "omega_i_b": (-1.9976639007323973, 1.3481958716408091, 0.5538287348861034),
                "v_j": (-2.085649402501467, -0.8964958528711514, 1.425668609900624),
                "omega_j_b": (1.147274347785133, 2.0675776226057643, -0.610004574065282),
            },
        ),
    ),
    # One of 300 random states of bodies that turn together.
    ("length", "rates"): (
        KnownError(
            "gamma",
            8.38,
            {
                "r_i": (0.6988806377641317, -0.7217580100495928, -0.40606725761854323),
                "p_i": (
                    -0.6751434193207373,
                    0.41208386188867097,
                    -0.6076804090563895,
                    0.07136367821154384,
                ),
                "s_i_b": (-0.7567570540208526, 0.5252401173996987, 1.9564708422319326),
                "r_j": (-1.4385448289130935, 0.5744280981862021, -1.5203962401309536),
                "p_j": (
                    0.88504339730903,
                    -0.09572282938729022,
                    0.4289447624538343,
                    0.15343309804995114,
                ),
                "s_j_b": (1.2576759767493102, -1.3437823758317955, 2.9106535294837133),
                "v_i": (-0.8407780193921662, -2.0374149491037197, 0.4380704291287829),
                "omega_i_b": (1.2224752940282755, -0.022281666863032165, 0.6453127001413879),
                "v_j": (0.4827134628538286, -1.1156979880307993, -0.4442452124348711),
                "omega_j_b": (1.1960892366602478, -0.6885407828434333, -0.08156547344520267),
            },
        ),
    ),
}
