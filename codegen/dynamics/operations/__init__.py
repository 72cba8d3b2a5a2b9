"""Operations of one task: on a body, a joint, a force, a block of a factorisation.

``mechanics``, ``own_frames``, ``coordinates``, ``forces``, ``formulas``, ``elimination``, ``sums``,
``joint_coordinates``. Of a system, before there are tasks: ``body_coordinates``, ``placement``,
``heights``, ``characteristic_length``, ``joint_ends``, ``elimination_order``. In any
arithmetic: ``jets``.
"""
