"""The version of kousoku, for the manifests of what it emits."""

from __future__ import annotations

__version__ = "0.1.0"
