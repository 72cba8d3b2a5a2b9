"""Parts of a solver that a scene does not need, counted.

``explain``, ``structure``, ``text``.
"""
