"""Linkages of nodes and their inputs, as drivers too; mobility, circuits, Grashof's conditions."""
