"""The program of a system, segment by segment.

``compose``, ``bodies``, ``joints``, ``joint_tasks``, ``coordinate_tasks``, ``combinations``,
``auxiliary``, ``force_tasks``, ``schur``, ``ordering``, ``reactions``, ``least_norm``,
``momentum``, ``contacts``, ``energies``, ``reduced``, ``reduced_tasks``, ``length``,
``setup``.
"""
