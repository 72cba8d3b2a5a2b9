"""Elements of a scene, one file each: forces, couplings, drivers, events, special joints.

Each is a class with its keys, its checks, and the element of a system that it becomes. The emission
of forces stands in :mod:`kousoku.codegen.dynamics.elements`: ``model`` imports nothing of it, since
scenes are read and checked where no solver is generated. What computes in 50 digits is imported
only where an element of a system is made: a scene is read without.
"""
