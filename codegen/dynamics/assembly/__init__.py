"""Positions and velocities that fit, near those that a scene gives.

``assemble``, ``nearest``, ``rough``, ``pose``, ``residuals``, ``jacobian``, ``driver_laws``,
``turns``, ``least``, ``block_factors``, ``fixed_points``, ``violations``.
"""
