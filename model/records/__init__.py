"""Records of a scene: what its tables hold, and the problems that are found in them."""
