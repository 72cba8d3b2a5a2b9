"""A program run without its source in any precision, and the values that verifying compares with.

``run``, ``reference``, ``rounding``.
"""
