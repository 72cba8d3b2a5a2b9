"""Scenes read from TOML or built by calls, and written; their schema and typed keys."""
