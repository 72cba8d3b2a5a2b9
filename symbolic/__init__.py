"""Derivation with SymPy: the lectures' formulas, step by step and component by component.

Listing the kinds imports no SymPy; deriving one does.
"""

from kousoku.symbolic.kinds import KINDS, Kind, derive, packages_of

__all__ = ["KINDS", "Kind", "derive", "packages_of"]
