"""Fewer bodies, coordinates and columns than a scene has.

``merge``, ``rigid_groups``, ``composite``, ``resting_energy``, ``planar``, ``turned``,
``forces_plane``, ``weights``, ``reduction``, ``reduced_mass``, ``reduced_program``.
"""
