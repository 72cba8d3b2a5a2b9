"""The list of kinds: names, aliases, and no SymPy until something is derived."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from kousoku.model.errors import DerivationError
from kousoku.symbolic import KINDS, derive, packages_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation


@pytest.mark.parametrize(
    ("name", "packages"),
    [
        ("p2", ("p2_x", "p2_y", "p2_z")),
        ("p2_y", ("p2_y",)),
        ("INLINE", ("p2_x", "p2_y", "p2_z")),
        ("parallel-2", ("p2_x", "p2_y", "p2_z")),
        ("PARALLEL AXES", ("p1_x", "p1_y", "p1_z")),
        ("parallel1", ("p1_x", "p1_y", "p1_z")),
        ("dot-1", ("n1",)),
        ("dot1", ("n1",)),
        ("PERPENDICULAR", ("n1",)),
        ("dot-2", ("n2",)),
        ("InPlane", ("n2",)),
        ("mass points", ("mass_points",)),
        ("rigid_body", ("rigid_body",)),
    ],
)
def test_names_of_other_books_are_accepted(name: str, packages: tuple[str, ...]) -> None:
    assert packages_of(name) == packages


def test_no_two_kinds_share_a_name() -> None:
    names = [
        name.replace(" ", "").replace("-", "").replace("_", "").lower()
        for kind, entry in KINDS.items()
        for name in dict.fromkeys((kind, *entry.packages, *entry.aliases))
    ]
    doubled = {name for name in names if names.count(name) > 1}
    assert doubled <= {"masspoints", "rigidbody"}  # written with a blank as well


def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(DerivationError, match="unknown kind 'screw'; known are rotation, n1"):
        derive("screw")


def test_listing_kinds_imports_no_sympy() -> None:
    program = (
        "import sys, kousoku.symbolic as s; s.packages_of('p2'); print('sympy' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("package", [p for kind in KINDS.values() for p in kind.packages])
def test_every_package_is_derived_with_units_and_sources(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    derivation = derived(package)
    assert derivation.name == package
    assert len(derivation.steps) >= 10
    for function in derivation.functions:
        assert function.source
        for quantity in (*function.inputs, *(output.quantity for output in function.outputs)):
            assert quantity.name.isidentifier()
            assert quantity.unit
            assert quantity.meaning
