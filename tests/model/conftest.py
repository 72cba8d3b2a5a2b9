"""Scenes that several tests of the model change in one place."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture
def lever() -> dict[str, Any]:
    """Tables of a lever crank, new for each test."""
    return {
        "name": "lever",
        "unit": "cm",
        "nodes": {
            "O1": {"at": [0, 0], "fixed": True},
            "O2": {"at": [30, 0]},
            "O3": {"at": [45, 58]},
            "O4": {"at": [100, 0], "fixed": True},
        },
        "links": {
            "l1": {"nodes": ["O1", "O2"], "length": 30},
            "l2": {"nodes": ["O2", "O3"], "length": 60},
            "l3": {"nodes": ["O3", "O4"], "length": 80},
        },
        "inputs": {"alpha": {"link": "l1", "about": "O1"}},
    }


@pytest.fixture
def piston() -> dict[str, Any]:
    """Tables of a piston crank, new for each test."""
    return {
        "name": "piston",
        "unit": "cm",
        "nodes": {
            "O1": {"at": [0, 0], "fixed": True},
            "O2": {"at": [1, 0]},
            "O3": {"at": [3, 0]},
        },
        "links": {
            "l1": {"nodes": ["O1", "O2"], "length": 1},
            "l2": {"nodes": ["O2", "O3"], "length": 2},
        },
        "sliders": {"piston": {"node": "O3", "through": [0, 0], "direction": [1, 0]}},
        "inputs": {"alpha": {"link": "l1", "about": "O1"}},
    }
