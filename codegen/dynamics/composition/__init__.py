"""The program of a system, segment by segment.

``compose`` records all segments: ``joints``, ``schur``, ``combinations``, ``auxiliary``,
``reactions``, ``least_norm``, ``momentum``, ``energies``, ``joint_coordinates``, ``setup``,
``switching``; tasks by what they belong to: ``record_coordinates``, ``record_forces``,
``record_joints``, ``record_joint_coordinates``; ``formula_names``. ``equations`` records them
without solving them.
"""
