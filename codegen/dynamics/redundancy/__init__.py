"""Degrees of freedom, and which rows of the constraints depend on others.

``freedom``, ``loops``, ``branch``, ``rank``, ``driven``, ``constant_rows``, ``redundant_rows``,
``own_rows``, ``closure``, ``nearly``, ``undetermined``, ``mass_ratio``, ``out_of_plane``,
``varying_rank``.
"""
