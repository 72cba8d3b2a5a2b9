"""Solvers of linkages, from a scene of nodes: Yamada and Tatsumi (1981), in 50 digits too.

``generate``   the pipeline, stage after stage
``assemble``   coordinates, links between them, known and unknown parts
``rotations``  rotations of links that are tied together
``blocks``     equations in block-triangular order
``layout``     indices of all numbers in the workspace
``kernels``    the segments of a block, composed of the frozen link element
``outputs``    the segments of nodes and of angles of links
``emit``       source text, by the templates and contexts of scenes of bodies
``data``       names and tables: ``motion.json``
``exact``      reference results of segments, element by element
``solution``   the motion in 50 digits
``reference``  reference values, for ``kousoku verify``
``explain``    the equations that are solved
"""
