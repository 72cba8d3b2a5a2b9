"""Scenes as users describe them, and the records that every stage shares.

Its rooms stand one above the other, the lowest first, and each imports what is below: ``files`` (of
generated folders and of the cache), ``operations`` (graphs, formulas, kernels, their evaluation),
``records`` (what a scene's tables hold), ``numbers`` (of 50 digits), ``expressions`` (formulas of a
scene), ``mechanics`` (a system of bodies), ``linkage`` (of nodes), ``elements`` (forces, joints,
drivers, events), ``validation``, ``reading``, and ``lowering`` (a scene turned into a system).
"""
