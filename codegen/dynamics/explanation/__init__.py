"""What a scene does not need, counted.

``explain``, ``structure``, ``text``.
"""
