"""Positions and velocities that fit, near those that a scene gives.

``assemble``, ``newton_mp``, ``newton_double``, ``near_origin``, ``pose``, ``residuals``,
``jacobian``, ``changes``, ``driver_laws``, ``unwrap``, ``minimum_norm``, ``block_factors``,
``fixed_points``, ``violations``, ``excess``.
"""
