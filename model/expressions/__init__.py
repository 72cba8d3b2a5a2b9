"""Formulas of a scene: their grammar, values, derivatives, bounds, polynomials and kinks."""
