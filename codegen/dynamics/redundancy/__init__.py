"""Degrees of freedom, and which rows of the constraints depend on others.

``freedom``, ``loops``, ``branch``, ``rank``, ``driven``, ``unmoved``, ``left_out``,
``closure``, ``nearly``, ``undetermined``, ``unevenness``, ``out_of_plane``.
"""
