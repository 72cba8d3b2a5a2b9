"""Degrees of freedom, and which rows of the constraints depend on others.

``freedom``, ``loops``, ``branch``, ``rank``, ``driven``, ``unmoved``, ``left_out``,
``out_of_plane``.
"""
