"""Generated solvers and kernels; regenerate with ``kousoku generate``, never edit."""
