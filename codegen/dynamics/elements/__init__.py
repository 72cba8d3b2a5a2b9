"""Facets of forces and constraints in a program and in the analyses before it.

Each is the second half of a class in :mod:`kousoku.model.elements`, which cannot know of programs:
``model`` imports nothing of ``codegen``.
"""
