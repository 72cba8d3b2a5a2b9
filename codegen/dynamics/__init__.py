"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace.

Where what is, in the order of :mod:`~kousoku.codegen.dynamics.generate`, which calls all of it:

``assembly``
    Positions and velocities that fit, near those that a scene gives.
``simplification``
    Fewer bodies, coordinates and columns than a scene has.
``redundancy``
    Degrees of freedom, and which rows of the constraints depend on others.
``operations``
    What one task computes: of a body, a joint, a force, a block of a factorisation.
``composition``
    The program of a system, segment by segment.
``recording``
    What operations are recorded on: kernels, tasks and one workspace.
``checking``
    A program run without its source in any precision, and the values that verifying compares with.
``emission``
    From a program to the source text of its solver.
``explanation``
    What a scene does not need, counted.
"""
