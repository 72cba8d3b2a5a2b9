"""Compose the motion of a system from frozen kinds: a program of small kernels on one workspace.

Where what is, in the order of :mod:`~kousoku.codegen.dynamics.generate`, which calls all of it:

positions and velocities that fit
    ``assembly``, ``nearest``, ``rough``, ``pose``, ``residuals``, ``jacobian``, ``driver_laws``,
    ``turns``, ``least``, ``block_factors``, ``fixed_points``, ``violations``
fewer bodies and columns
    ``merge``, ``rigid_groups``, ``composite``, ``resting_energy``; ``planar``, ``turned``,
    ``forces_plane``; ``weights``; ``reduction``, ``reduced_mass``, ``reduced_program``
which rows depend on others
    ``freedom``, ``loops``, ``branch``, ``rank``, ``driven``, ``unmoved``, ``left_out``,
    ``out_of_plane``
operations, which one task each computes
    ``operations``, ``coordinates``, ``forces``, ``forces_along``, ``formulas``, ``elimination``,
    ``sums``, ``reduced_operations``
the program, segment by segment
    ``compose``, ``bodies``, ``joints``, ``joint_tasks``, ``coordinate_tasks``, ``combinations``,
    ``auxiliary``, ``force_tasks``, ``schur``, ``ordering``, ``reactions``, ``least_norm``,
    ``momentum``, ``contacts``, ``energies``, ``length``; ``reduced``, ``reduced_tasks``;
    ``design``, ``setup``
what operations are recorded on
    ``program``, ``recorder``, ``traces``, ``matrix``, ``inline``, ``disjoint``
running a program without its source
    ``run``, ``reference``, ``rounding``
source
    ``emit``, ``view``, ``view_numbers``, ``numpy_view``, ``runge_kutta``, ``motion_data``
what is told of it
    ``explain``, ``counts``, ``structure``
"""
