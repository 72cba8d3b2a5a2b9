"""What kousoku knows, listed: kinds by attribute, and the catalog of what a scene may hold."""

from __future__ import annotations

import pickle
from typing import Any

import pytest

from kousoku.cataloging import catalog
from kousoku.committed import kinds
from kousoku.model.elements.drivers import DRIVERS
from kousoku.model.elements.forces import FORCES
from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES
from kousoku.model.records import loads, spatial
from kousoku.model.validation import coordinates
from kousoku.symbolic import KINDS
from tests.test_architecture import BLOCK, modules_after


def test_the_catalog_holds_all_that_scenes_are_read_with() -> None:
    found = catalog()
    sections = ["kinds", "joints", "forces", "drivers", "coordinates", "events", "bodies"]
    assert list(found) == sections
    assert list(found["kinds"]) == list(KINDS)
    assert list(found["joints"]) == [*JOINTS, *COUPLINGS]
    assert list(found["forces"]) == list(FORCES)
    assert list(found["drivers"]) == list(DRIVERS)
    assert list(found["coordinates"]) == list(coordinates.TITLES)
    for name, alias in NAMES.items():
        assert found["joints"][name] is found["joints"][alias]


def test_every_key_of_a_record_is_in_the_catalog_with_its_meaning() -> None:
    found = catalog()
    for section, record in (
        ("joints", spatial.Joint),
        ("forces", loads.Force),
        ("drivers", spatial.Driver),
        ("coordinates", spatial.Coordinate),
        ("events", spatial.Event),
    ):
        keys = {key for entry in found[section].values() for key in entry.keys}
        assert keys == {*record.__struct_fields__} - {getattr(record, "FLAT", "")}, section
    assert set(found["bodies"]["body"].keys) == set(spatial.Body.__struct_fields__)
    for table in found.values():
        for entry in table.values():
            assert entry.title
            assert "\n" not in entry.title
            assert all(entry.keys.values()), entry


def test_tables_are_short_and_hold_every_name() -> None:
    found = catalog()
    assert len(repr(found).splitlines()) == 8
    for section in found.values():
        assert len(repr(section).splitlines()) == len(section) + 1
        assert all(f"\n{name} " in repr(section) for name in section)
    assert repr(found["joints"]["hinge"]).startswith(
        "revolute (also hinge, pin): a turn about an axis\n"
    )
    assert "a turn about an axis" in found["joints"]._repr_html_()
    assert found._repr_html_().count("<tr>") == 8
    assert "<td" in found["joints"]["hinge"]._repr_html_()
    assert str(kinds) == repr(found["kinds"])
    assert all(name in repr(kinds) for name in found["kinds"])
    assert kinds._repr_html_() == found["kinds"]._repr_html_()


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("joint",), "no section 'joint': there are kinds, joints, .*; did you mean 'joints'"),
        (("joints", "hing"), "no joint 'hing': there are fixed, .*; did you mean 'hinge'"),
        (("kinds", "p3"), "no kind 'p3'"),
    ],
)
def test_what_is_not_there_is_refused_with_the_nearest_name(
    names: tuple[str, ...], message: str
) -> None:
    found: Any = catalog()
    with pytest.raises(KeyError, match=message):
        for name in names:
            found = found[name]


def test_the_catalog_travels() -> None:
    found = pickle.loads(pickle.dumps(catalog()))
    assert repr(found) == repr(catalog())
    assert found["kinds"]["INLINE"].name == "p2"


def test_kinds_are_attributes_that_complete() -> None:
    names = {name for kind, entry in KINDS.items() for name in (kind, *entry.packages)}
    assert names <= set(dir(kinds))
    for name in names:
        assert getattr(kinds, name).__name__ == f"kousoku.generated.kinds.{name}"
    with pytest.raises(AttributeError, match="no kernels of 'p3'; there are rotation, n1"):
        _ = kinds.p3


def test_kinds_and_the_catalog_of_kernels_need_numpy_only() -> None:
    code = BLOCK + "import kousoku as ks\nks.kinds.p2_z.constraint\nrepr(ks.kinds.p2_z)\n"
    assert "numpy" in modules_after(code)
