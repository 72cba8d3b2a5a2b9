"""What one task computes: of a body, a joint, a force, a block of a factorisation.

``mechanics``, ``coordinates``, ``forces``, ``forces_along``, ``formulas``, ``elimination``,
``sums``, ``reduced_operations``.
"""
