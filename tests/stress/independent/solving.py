"""M v̇ + C_qᵀ λ = f with C_q v̇ = γ, whatever the rank of C_q, by singular values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

Array = Any


@dataclass(frozen=True)
class Solution:
    """Accelerations, and the shortest multipliers.

    Parameters
    ----------
    v_dot : (n,) array
        Accelerations.
    lam : (m,) array
        Multipliers, the shortest with rows that are scaled to norm one in the metric of the masses.
    free : (m, k) array
        All that may be added to the multipliers without a change of the accelerations.
    condition : float
        Largest by smallest singular value that counts, of scaled rows.
    gap : float
        Smallest singular value that counts, by the largest that does not.
    """

    v_dot: Array
    lam: Array
    free: Array
    condition: float
    gap: float


def svd(A: Array) -> tuple[Array, Array, Array]:
    """Factors U, σ and Vᵀ with all columns of U."""
    if A.dtype != object:
        return np.linalg.svd(A, full_matrices=True)
    U, sigma, V = mpmath.svd_r(mpmath.matrix(A.tolist()), full_matrices=True)
    left, right = (np.array(x.tolist(), dtype=object) for x in (U, V))
    return left, np.array([*sigma], dtype=object), right


def inverse_of(L: Array) -> Array:
    """Inverse of a matrix."""
    if L.dtype != object:
        return np.linalg.inv(L)
    return np.array((mpmath.matrix(L.tolist()) ** -1).tolist(), dtype=object)


def sizes_of(M: Array) -> Array:
    """Roots of the diagonal of M; of a thousandth of the most where there is zero."""
    diagonal = [M[k, k] for k in range(len(M))]
    least = max(diagonal, default=0) / 1000
    return np.array([x**0.5 if x > 0 else least**0.5 for x in diagonal])


def solve(M: Array, C_q: Array, gamma: Array, f: Array, zero: float) -> Solution:
    """Accelerations and multipliers.

    Accelerations are v̇ = v̇₀ + N y with C_q N = 0, by Nᵀ M N y = Nᵀ (f − M v̇₀); M may be singular,
    and Nᵀ M N may not.

    Parameters
    ----------
    M, C_q, gamma, f : array
        The equations.
    zero : float
        Singular values that are smaller, relative to the largest, are zero: rows that depend on
        others.
    """
    root = sizes_of(M)
    load, mass = f / root, M / np.outer(root, root)
    B = C_q / root
    sizes = np.array([sum(x * x for x in row) ** 0.5 or 1 for row in B])
    U, sigma, Vt = svd(B / sizes[:, np.newaxis])
    count = int(sum(x > zero * sigma[0] for x in sigma))
    U_r, V_r, s = U[:, :count], Vt[:count], sigma[:count]
    along = V_r.T @ ((U_r.T @ (gamma / sizes)) / s)
    N = Vt[count:].T
    own = inverse_of(N.T @ mass @ N)
    acceleration = along + N @ (own @ (N.T @ (load - mass @ along)))
    lam = U_r @ ((V_r @ (load - mass @ acceleration)) / s) / sizes
    free = U[:, count:] / sizes[:, np.newaxis]
    rest = float(sigma[count]) if count < len(sigma) else 0.0
    last, first = (float(s[k]) if count else 1.0 for k in (-1, 0))
    gap = last / rest if rest else np.inf
    return Solution(acceleration / root, lam, free, first / last, gap)
