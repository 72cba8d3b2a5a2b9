"""Named arrays: the currency between derivation, kernels, manifests and callers."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod


@dataclass(frozen=True, slots=True)
class Quantity:
    """An array that a formula or a kernel takes or gives.

    Parameters
    ----------
    name : str
        A lower-case identifier in the notation of ``docs/notation.md``, e.g. ``s_i_b``.
    shape : tuple of int
        Row-major shape of one evaluation; ``()`` is a scalar.
    unit : str
        SI unit, ``"-"`` for a pure number.
    meaning : str
        Of what, in which frame.
    """

    name: str
    shape: tuple[int, ...]
    unit: str
    meaning: str

    @property
    def size(self) -> int:
        """Count of numbers in one evaluation."""
        return prod(self.shape)
