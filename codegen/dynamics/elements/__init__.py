"""What forces do in a program and in the analyses before it, one file each.

Each is the second half of a class in :mod:`kousoku.model.elements`, which cannot know of programs:
``model`` imports nothing of ``codegen``.
"""
