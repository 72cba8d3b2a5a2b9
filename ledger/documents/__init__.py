"""The documents: of each part its entries in TOML, and beside them its words and proofs."""
