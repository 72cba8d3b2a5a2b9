"""Values that verifying compares with, and their errors; equations from another derivation.

``reference``, ``rounding``, ``start``, ``independent``, ``newton_euler``, ``root_functions``.
"""
