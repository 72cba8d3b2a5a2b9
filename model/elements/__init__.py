"""Forces of a scene, one file each: keys, checks, and what they become in a system.

What they do in a program stands in :mod:`kousoku.codegen.dynamics.elements`: ``model`` imports
nothing of it, since scenes are read and checked where no solver is generated.
"""
