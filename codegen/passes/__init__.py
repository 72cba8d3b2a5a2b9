"""Passes: each takes a kernel and gives one that means the same."""
