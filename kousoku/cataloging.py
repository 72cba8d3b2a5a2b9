"""Catalog of kousoku: kinds, and the elements of scenes, with names, keys and one line each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from kousoku.model.errors import NotInResultError
from kousoku.model.text import near_name, plain_name, table
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.elements.coupling import Coupling
    from kousoku.model.elements.joint import JointKind

T = TypeVar("T")


def catalog() -> Catalog:
    """Catalog of kinds, joints, forces, drivers, coordinates, events and bodies with their keys.

    The lists are those that scenes are read with, so that none is forgotten.

    Returns
    -------
    Catalog
        ``catalog()["joints"]`` is a table, ``catalog()["joints"]["revolute"]`` an entry of it,
        ``catalog()["joints"]["revolute"].keys`` its keys with what each means.

    Examples
    --------
    >>> from kousoku.cataloging import catalog
    >>> catalog()["joints"]["hinge"].title
    'a turn about an axis'
    """
    return _catalog()


@dataclass(frozen=True, slots=True, repr=False)
class CatalogItem:
    """Entry of a section: what kousoku knows by a name.

    Parameters
    ----------
    name : str
        Its name; what a scene writes as ``type``.
    title : str
        What it is, in one line.
    keys : mapping of str to str
        What a scene gives of it, or what the kernels of a kind take: each key with what it means.
    aliases : tuple of str
        Other names that are accepted.
    """

    name: str
    title: str
    keys: Mapping[str, str]
    aliases: tuple[str, ...] = ()

    def __repr__(self) -> str:
        also = f" (also {', '.join(self.aliases)})" if self.aliases else ""
        return table(
            ("key", "what"), [*self.keys.items()], title=f"{self.name}{also}: {self.title}"
        )

    def _repr_html_(self) -> str:
        return _html(f"{self.name}: {self.title}", ("key", "what"), [*self.keys.items()])


class _Named(Mapping[str, T]):
    """A mapping whose names are found by any alias, and refused with the nearest one."""

    def __init__(self, what: str, found: Mapping[str, T], aliases: Mapping[str, str]) -> None:
        self._noun, self._entries, self._aliases = what, MappingProxyType(dict(found)), aliases

    def __getitem__(self, name: str) -> T:
        key = self._aliases.get(plain_name(name), name)
        if key not in self._entries:
            names = ", ".join(self._entries)
            near = near_name(name, [*self._entries, *self._aliases])
            raise NotInResultError(f"no {self._noun} {name!r}: there are {names}{near}")
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._noun, dict(self._entries), dict(self._aliases))


class Section(_Named[CatalogItem]):
    """The entries of one sort, by name or alias."""

    COLUMNS = ("name", "what", "other names")

    def _rows(self) -> list[tuple[str, str, str]]:
        return [(x.name, x.title, ", ".join(x.aliases)) for x in self.values()]

    def __repr__(self) -> str:
        return table(self.COLUMNS, self._rows())

    def _repr_html_(self) -> str:
        return _html(self._noun, self.COLUMNS, self._rows())


class Catalog(_Named[Section]):
    """Sections by name, all that there are; its repr lists the entries of each."""

    COLUMNS = ("section", "entries")

    def _rows(self, most: int = 6) -> list[tuple[str, str]]:
        return [(name, listed([*section], most)) for name, section in self.items()]

    def __repr__(self) -> str:
        return table(self.COLUMNS, self._rows())

    def _repr_html_(self) -> str:
        return _html("catalog", self.COLUMNS, self._rows(most=99))


@cache
def _catalog() -> Catalog:
    import json

    from kousoku.model.elements import joints
    from kousoku.model.elements.drivers import DRIVERS
    from kousoku.model.elements.forces import FORCES
    from kousoku.model.validation import coordinates

    text = (files("kousoku.model") / "scene.schema.json").read_text(encoding="utf-8")
    records = json.loads(text)["$defs"]
    kinds: dict[str, JointKind | Coupling] = {**joints.JOINTS, **joints.COUPLINGS}
    sections = {
        "kinds": _kinds(),
        "joints": [
            CatalogItem(name, x.title, _meanings(records["Joint"], joints.keys_of(name)), x.aliases)
            for name, x in kinds.items()
        ],
        "forces": _sorts(
            records["Force"],
            {name: kind.all_keys for name, kind in FORCES.items()},
            {name: kind.title for name, kind in FORCES.items()},
            "type",
        ),
        "drivers": _sorts(
            records["Driver"],
            {name: kind.all_keys for name, kind in DRIVERS.items()},
            {name: kind.title for name, kind in DRIVERS.items()},
        ),
        "coordinates": _sorts(
            records["Coordinate"],
            coordinates.KEYS,
            coordinates.TITLES,
            also=("near", "hold"),
        ),
        "events": [_record("event", records["Event"])],
        "bodies": [_record(name, records[record]) for name, record in BODIES.items()],
    }
    by_name = {name: _section(name, entries) for name, entries in sections.items()}
    return Catalog("section", by_name, {})


#: Records of the schema that a body may be made of, by the key that holds them.
BODIES = {
    "body": "Body",
    "orientation": "Orientation",
    "inertia": "Inertia",
    "mass_points": "MassPoint",
    "boxes": "Box",
    "rods": "Rod",
    "cylinders": "Cylinder",
    "spheres": "Sphere",
}


def _section(name: str, entries: Sequence[CatalogItem]) -> Section:
    aliases = {plain_name(alias): x.name for x in entries for alias in (x.name, *x.aliases)}
    noun = name.removesuffix("s") if name != "bodies" else "body or part of one"
    return Section(noun, {x.name: x for x in entries}, aliases)


def _kinds() -> list[CatalogItem]:
    """Kinds, with the inputs of their kernels."""
    from kousoku.generated import kinds
    from kousoku.model.files.manifest import MANIFEST_FILE, Manifest
    from kousoku.symbolic import KINDS

    items = []
    for name, kind in KINDS.items():
        path = files(kinds.__name__) / name / MANIFEST_FILE
        manifest = Manifest.from_json(path.read_text(encoding="utf-8"))
        quantities = [q for kernel in manifest.kernels for q in kernel.inputs]
        keys = {q.name: f"{q.meaning}, {q.shape} [{q.unit}]" for q in quantities}
        choices = kind.packages if kind.packages != (name,) else ()
        items.append(CatalogItem(name, kind.title, keys, (*choices, *kind.aliases)))
    return items


def _sorts(
    record: Mapping[str, Any],
    keys: Mapping[str, Sequence[str]],
    titles: Mapping[str, str],
    *before: str,
    also: Sequence[str] = (),
) -> list[CatalogItem]:
    """Sorts of a record: the types of a force, or the keys that say which driver it is."""
    return [
        CatalogItem(name, titles[name], _meanings(record, (*before, *named, *also)))
        for name, named in keys.items()
    ]


def _record(name: str, record: Mapping[str, Any]) -> CatalogItem:
    title = str(record["description"]).partition(": ")[0].partition(". ")[0].removesuffix(".")
    return CatalogItem(name, title, _meanings(record, record["properties"]))


def _meanings(record: Mapping[str, Any], keys: Sequence[str]) -> dict[str, str]:
    return {key: record["properties"][key].get("description", "") for key in keys}


def _html(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        inside = "".join(f'<{tag} style="text-align:left">{escape(cell)}</{tag}>' for cell in cells)
        return f"<tr>{inside}</tr>"

    body = "".join(line(row, "td") for row in rows)
    return f"<table><caption>{escape(title)}</caption>{line(columns, 'th')}{body}</table>"
