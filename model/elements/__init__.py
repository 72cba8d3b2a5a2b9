"""Elements of a scene, one file each: forces, couplings, drivers, events, and unlike joints.

Each is a class with its keys and checks, and with what it becomes in a system. What forces do in a
program stands in :mod:`kousoku.codegen.dynamics.elements`: ``model`` imports nothing of it, since
scenes are read and checked where no solver is generated. Nothing here imports what computes in 50
digits before it is asked for an element of a system: a scene is read without.
"""
