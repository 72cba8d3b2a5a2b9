"""Recording of operations: kernels, tasks and one workspace.

``program``, ``recorder``, ``traces``, ``matrix``, ``inline``, ``design``; what is recorded is run
without its source by ``interpreter``, and counted by ``counts``.
"""
