"""Operations of one task: on a body, a joint, a force, a block of a factorisation.

``mechanics``, ``own_frames``, ``coordinates``, ``applied_forces``, ``formulas``, ``elimination``,
``sums``, ``joint_projections``. Of a system, before there are tasks: ``body_coordinates``,
``placement``, ``heights``, ``characteristic_length``, ``joint_ends``, ``elimination_order``. In any
arithmetic: ``jets``.
"""
