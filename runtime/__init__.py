"""Load, verify and run generated code; needs NumPy only."""
