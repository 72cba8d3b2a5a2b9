"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace."""
