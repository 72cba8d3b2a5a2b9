"""The integrator of scenes of bodies: explicit Runge-Kutta on the manifold of the constraints.

The vector field is f(project(y)): equal to f on the manifold, so that the method keeps its order,
and every stage is evaluated where the constraints hold. y is q and v: r and p of all bodies, turns
and works, then v and omega of all bodies.

The same in C, ``*.h``, and in NumPy, ``*.py``, file by file with the same functions, but for some
small ones, and the same bits. A step: ``arithmetic``, ``pivot_monitor``, ``row_switch``,
``projection``, ``dense_output``, ``motion_scales``, ``trial``, ``step_error``, ``branches``,
``branch_watch``, ``step_end``, ``stepper``. What happens inside of a step: ``search``, ``roots``,
``poles``, ``crossing``, ``variation``, ``cuts``, ``distances``, ``breaks``; at times known before,
``switching``. Further: ``kinematics``, ``rows``, ``continuation``, ``rank``, ``trust``. It goes
along with each generated solver, and needs NumPy only.

In Python alone, what C has in other files or its callers do: the tables of a scene,
``scene_tables``, ``tasks``, ``methods``, ``settings``, ``state``, and its solver, ``scene_solver``;
starts, ``initial_coordinates``, ``initial_poses``, ``initial_values``, ``assembled_start``,
``start_evaluation``, ``run_arguments``; results, ``motion``, ``result``, ``body_tables``,
``euler_parameters``, ``events``, ``nearly_dependent``; and ``alone``, for folders without kousoku.

In C alone: integrate.h, which includes the others, memory.h, the workspace of a run, lacking.h,
what a scene lacks, calls.h, what is called from outside, and methods.h, written from the tables
here.
"""
