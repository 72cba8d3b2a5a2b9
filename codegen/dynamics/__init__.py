"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace.

:mod:`~kousoku.codegen.dynamics.generate` is the way from a scene to the folder of its solver:
:mod:`~kousoku.codegen.dynamics.analyse` decides what is solved, ``composition`` records it, and
:mod:`~kousoku.codegen.dynamics.choose` takes of two programs one, where only composing them tells.

Where what is, in that order:

``assembly``
    Positions and velocities that fit, near those that a scene gives.
``simplification``
    Fewer bodies, coordinates and columns than a scene has.
``redundancy``
    Degrees of freedom, and which rows of the constraints depend on others.
``operations``
    What one task computes: of a body, a joint, a force, a block of a factorisation.
``elements``
    Forces, one file each: what is recorded of them, and what analyses ask.
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
