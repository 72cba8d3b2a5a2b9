"""Checks of a scene before anything is derived of it."""
