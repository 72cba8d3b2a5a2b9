"""Numbers that look random and are the same on every machine."""

from __future__ import annotations

import hashlib
import math


class Sha256Random:
    """Numbers that look random and are fixed by a seed.

    Parameters
    ----------
    seed : str
        Equal seeds give equal numbers.
    """

    def __init__(self, seed: str) -> None:
        self._seed = seed
        self._count = 0

    def integer(self, bits: int) -> int:
        """Integer of 0 … 2^bits − 1, at most 64 bits."""
        self._count += 1
        digest = hashlib.sha256(f"{self._seed} {self._count}".encode()).digest()
        return int.from_bytes(digest[:8], "big") >> (64 - bits)

    def sign(self) -> int:
        """Sign −1 or 1."""
        return 1 - 2 * self.integer(1)

    def magnitude(self) -> float:
        """Double of [1/2, 2) with all its digits in use."""
        return math.ldexp(2**52 + self.integer(52), -52 - self.integer(1))

    def between(self, low: int, high: int) -> int:
        """Integer of low … high."""
        return low + self.integer(53) * (high - low + 1) // 2**53
