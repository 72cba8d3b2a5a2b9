"""Source text of derivations: freeze, optimise, emit.

The pipeline of a kind is ``generate``, stage after stage; ``derived`` keeps derivations.
Kernels come from the matrix level by ``freeze``, which asks ``matrix_chain`` in which order
matrices are multiplied out, and from the components by ``freeze_components``; ``kernel_json`` is
their text, ``expressions`` has the nodes of the formulas of scenes.

``emit`` writes the folder. Operations become text in ``printers``; the context of the templates is
``context``, from a kernel to the records of ``context_records``: ``context_body`` has the straight
lines of a choice of outputs, ``context_choices`` of several, ``context_calls`` arguments,
``context_names`` names, ``context_lines`` lines that fit. The text of scenes is made by the same
functions.

Reference values of a kernel are computed by ``reference``, with the units of ``error_unit``, at
``points`` and ``states``, with numbers of ``sha256_random``, which ``manifold`` puts onto a
constraint; ``known_errors`` has errors beyond the limit that are known. Folders: ``passes`` over
kernels, templates, and the solvers of scenes, ``dynamics`` of bodies and ``linkage`` of nodes.
"""
