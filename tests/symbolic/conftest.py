"""Derivations are made once for all tests of this folder."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import pytest

from kousoku.symbolic import derive

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation


@pytest.fixture(scope="session")
def derived() -> Callable[[str], Derivation]:
    """Return ``derive`` with a memory."""
    return cache(derive)
