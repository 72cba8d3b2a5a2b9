"""Scalar operations: graphs and formulas of them, kernels, their evaluation and differentials."""
