"""Linkages of nodes and their inputs, also as drivers; mobility, circuits, Grashof's conditions."""
