"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace.

:mod:`~kousoku.codegen.dynamics.generate` is the way from a scene to the folder of its solver:
:mod:`~kousoku.codegen.dynamics.assembled` makes the system and its consistent start,
:mod:`~kousoku.codegen.dynamics.analyse` decides what is solved, ``composition`` records it, and
:mod:`~kousoku.codegen.dynamics.choose` takes of two programs one, where only composing them tells.

Where what is, the lowest first; each imports those before it only,
but ``elements``, which names in types who calls it:

``disjoint_sets``
    Which bodies, joints or rows belong together.
``recording``
    What operations are recorded on: kernels, tasks and one workspace; a program run and counted.
``operations``
    What one task computes: of a body, a joint, a force, a block of a factorisation.
``own_kinds``
    A constraint of one's own as the type of joints, before scenes are read.
``elements``
    Forces and kinds of constraints: what is recorded of each, and what analyses ask of it.
``assembly``
    Positions and velocities that fit, near those that a scene gives.
``simplification``
    Fewer bodies, coordinates and columns than a scene has.
``redundancy``
    Degrees of freedom, and which rows of the constraints depend on others.
``composition``
    The program of a system, segment by segment.
``emission``
    From a program to the source text of its solver.
``checking``
    The values that verifying compares with, and equations from a derivation of their own.
``explanation``
    What a scene does not need, counted.
"""
