"""Derivation with SymPy: the lectures' formulas, step by step and component by component."""
