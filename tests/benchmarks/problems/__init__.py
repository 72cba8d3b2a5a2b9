"""The problems, one module each."""
