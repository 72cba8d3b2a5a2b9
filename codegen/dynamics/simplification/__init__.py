"""Fewer bodies, coordinates and columns than a scene has.

``lump``, ``rigid_groups``, ``composite``, ``static_potential``, ``body_blocks``,
``outline``, ``planarity``, ``axis_permutation``, ``forces_plane``, ``placeholder_masses``,
``written_start``, ``ground_joints``, ``reduced_mass``, ``conserved_momenta``,
``ground_reactions``.
"""
