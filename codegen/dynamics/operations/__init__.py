"""What one task computes: of a body, a joint, a force, a block of a factorisation.

``mechanics``, ``own_frames``, ``coordinates``, ``forces``, ``forces_along``, ``formulas``,
``elimination``, ``sums``, ``joint_coordinates``. Of a system, before there are tasks:
``characteristic_length``, ``joint_ends``, ``elimination_order``.
"""
