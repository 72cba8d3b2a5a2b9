"""Position, velocity and acceleration analysis of planar mechanisms, block after block.

The same algorithm as ordinary C (``*.h``) and as ordinary Python, file by file; a generated folder
holds a copy of it beside the segments and the tables of its scene. It needs the C library, and in
Python NumPy, and imports nothing of kousoku but the integrator and messages, which travel along.

``tables``           records of the tables that describe a linkage
``status``           what an analysis ends with, and its tolerances
``rows``             what is asked for, and the rows of results
``lu``               LU factorisation
``block_equations``  residuals, Jacobians and derivatives of the blocks
``newton``           full and modified Newton method
``assembly``         the position of the scene
``approach``         from there to where rows begin
``continuation``     predictor and corrector along the inputs
``certificate``      that a step leads to the branch it came from
``moving``           a call checked, and what went wrong told; in Python only
``solve``            the whole analysis, and what a folder has of it
``trajectory``       results by name, in Python only
"""
