"""The build of setuptools, with editable installs that type checkers and editors follow.

The sub-packages lie in the root of a checkout, and setuptools serves them to an editable install
by a finder that runs: Python follows it, and mypy, pyright and editors do not. Where git made the
links of ``kousoku/``, the checkout on the path does (``editable_mode=compat``), elsewhere a tree of
files (``strict``), which new files enter when it is installed again.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]


def build_editable(
    wheel_directory: str,
    config_settings: dict[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    """Build the wheel of an editable install, in the mode that is followed unless one is given."""
    has_links = (Path(__file__).parent / "kousoku" / "model").is_dir()
    settings = {"editable_mode": "compat" if has_links else "strict", **(config_settings or {})}
    return build_meta.build_editable(wheel_directory, settings, metadata_directory)
