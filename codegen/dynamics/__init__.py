"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace.

:mod:`~kousoku.codegen.dynamics.generate` goes from a scene to the folder of its solver:
:mod:`~kousoku.codegen.dynamics.assembled` makes the system and its consistent start,
:mod:`~kousoku.codegen.dynamics.analyse` decides on its equations, ``composition`` records them, and
:mod:`~kousoku.codegen.dynamics.choose` chooses between two programs, where composing alone tells.

Packages, the lowest first; each imports those before it only,
but ``elements``, whose types name its callers:

``disjoint_sets``
    Sets of bodies, joints or rows that belong together.
``recording``
    Records of operations: kernels, tasks and one workspace; a program run and counted.
``operations``
    Operations of one task: of a body, a joint, a force, a block of a factorisation.
``own_kinds``
    Constraint of a user as a type of joints, before scenes are read.
``elements``
    Forces and kinds of constraints: their records, and their properties for analyses.
``assembly``
    Positions and velocities that fit, near those that a scene gives.
``simplification``
    Fewer bodies, coordinates and columns than a scene has.
``redundancy``
    Degrees of freedom, and dependent rows of the constraints.
``composition``
    The program of a system, segment by segment.
``emission``
    Source text of the solver of a program.
``checking``
    Reference values for verifying, and equations from an independent derivation.
``explanation``
    Savings by each simplification of a scene, counted.
"""
