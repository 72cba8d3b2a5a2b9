"""From a scene of nodes to the folder of its solver: Yamada and Tatsumi (1981), in 50 digits too.

``generate``   the pipeline, stage after stage
``assemble``   coordinates, links between them, known and unknown parts
``rotations``  those of links that are tied together
``blocks``     equations in block-triangular order
``layout``     where everything stands in the workspace
``kernels``    the segments of a block, composed of the frozen link element
``outputs``    those of nodes and of angles of links
``emit``       source text, by the templates and contexts of scenes of bodies
``data``       names and tables: ``motion.json``
``exact``      what segments must give, element by element
``solution``   the motion in 50 digits
``reference``  reference values, for ``kousoku verify``
``explain``    what is solved
"""
