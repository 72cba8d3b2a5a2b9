"""Numbers of 50 digits: dual, traced and varying ones, vectors and quaternions of them."""
