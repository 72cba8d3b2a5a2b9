"""From a program to the source text of its solver.

``emit``, ``context``, ``context_numbers``, ``numpy_context``, ``slots``, ``motion_data``.
"""
