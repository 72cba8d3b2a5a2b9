"""From a program to the source text of its solver.

``emit``, ``view``, ``view_numbers``, ``numpy_view``, ``runge_kutta``, ``motion_data``.
"""
