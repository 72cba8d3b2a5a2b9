"""Fewer bodies, coordinates and columns than a scene has.

``merge``, ``rigid_groups``, ``composite``, ``resting_energy``, ``shapes``, ``outline``,
``planar``, ``turned``, ``forces_plane``, ``weights``, ``given_start``, ``reduction``,
``reduced_mass``.
"""
