"""Elements of a scene, one file each: forces, couplings, drivers, events, special joints.

Each is a class with its keys, its checks, and the element of a system that it becomes. What
forces and constraints are in a program, in analyses and in the independent check stands in
:mod:`kousoku.codegen.dynamics.elements`: ``model`` imports nothing of it, since scenes are read and
checked where no solver is generated. What computes in 50 digits is imported
only where an element of a system is made: a scene is read without.
"""
