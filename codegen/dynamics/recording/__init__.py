"""What operations are recorded on: kernels, tasks and one workspace.

``program``, ``recorder``, ``traces``, ``matrix``, ``inline``, ``disjoint``, ``design``.
"""
