"""What a scene does not need, counted.

``explain``, ``counts``, ``structure``.
"""
