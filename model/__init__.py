"""Scenes as users describe them, and the records that every stage shares."""
