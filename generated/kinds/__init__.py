"""The kernels of the kinds: one package for each, such as ``kousoku.generated.kinds.p2_z``."""
