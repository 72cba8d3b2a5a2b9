"""kousoku: derive constraint equations, emit them as NumPy and C, verify what was emitted."""

__version__ = "0.1.0"
