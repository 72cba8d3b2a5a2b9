"""From derivations to source text: freeze, optimise, emit.

The pipeline of a kind is ``generate``, stage after stage; ``derived`` keeps what was derived.
Kernels come from the matrix level by ``freeze``, which asks ``matrix_chain`` in which order
matrices are multiplied out, and from the components by ``freeze_components``; ``kernel_json`` is
their text, ``expressions`` makes nodes of the formulas of scenes.

``emit`` writes the folder. Operations become text in ``printers``; the context of the templates is
``context``, from a kernel to the records of ``context_records``: ``context_body`` has the straight
lines of a choice of outputs, ``context_choices`` of several, ``context_calls`` arguments,
``context_names`` names, ``context_lines`` lines that fit. The text of scenes is made by the same
functions.

What a kernel must give is computed by ``reference``, with the units of ``error_unit``, at
``points`` and ``states``, with numbers of ``sha256_random``, which ``manifold`` puts onto a
constraint; ``known_errors`` has what is known to be off. Folders: ``passes`` over kernels,
templates, and the solvers of scenes, ``dynamics`` of bodies and ``linkage`` of nodes.
"""
