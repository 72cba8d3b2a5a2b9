"""Scenes that are the same motion in other words: units, places, directions, order, welds."""

from __future__ import annotations

import copy
import re
from typing import TYPE_CHECKING, Any

from tests.random_geometry import times
from tests.stress.independent.formulas import Reader
from tests.stress.independent.joints import LEAVES, TYPES
from tests.stress.independent.numbers import product
from tests.stress.independent.solids import orientation_of

if TYPE_CHECKING:
    from tests.random_geometry import Matrix, Vector

    Tree = dict[str, Any]


class DoesNotApply(Exception):
    """A change that a scene cannot have, with the reason."""


def multiplied(value: Any, factor: float) -> Any:
    """Number, formula or list of them, multiplied by a number."""
    if isinstance(value, list | tuple):
        return [multiplied(one, factor) for one in value]
    if isinstance(value, str):
        return value if factor == 1 else f"{factor!r}*({value})"
    return value * factor


def write_numbers(body: Tree) -> None:
    """Write the rates of angles that a body starts with as numbers; no formula may stand there."""
    for key in ("angular_velocity", "angular_velocity_b"):
        if key in body:
            body[key] = Reader().vector(body[key])


def is_angle(tree: Tree, one: Tree) -> bool:
    """Whether what a coordinate, driver, force or input refers to is an angle."""
    if "coordinate" in one:
        return is_angle(tree, tree["coordinates"][one["coordinate"]])
    if "joint" not in one:
        return False
    kind = tree["joints"][one["joint"]]["type"]
    return "angle" in one.get("of", LEAVES[TYPES.get(kind, kind)][0])


class Scaled:
    """A scene in which all lengths, masses and times are multiplied by numbers.

    Parameters
    ----------
    tree : dict
        The scene.
    length, mass, time : float
        What they are multiplied by.
    """

    def __init__(
        self, tree: Tree, length: float = 1.0, mass: float = 1.0, time: float = 1.0
    ) -> None:
        self.old, self.tree = tree, copy.deepcopy(tree)
        self.L, self.M, self.T = length, mass, time
        self.force = mass * length / time**2
        self.moment = self.force * length
        for body in self.tree["bodies"].values():
            self._body(body)
        for joint in self.tree.get("joints", {}).values():
            self._joint(joint)
        for one in self.tree.get("coordinates", {}).values():
            self._multiply(one, length, "points", "point")
        for one in self.tree.get("drivers", {}).values():
            own = 1.0 if is_angle(tree, one) else length
            for key in ("value", "path"):
                if key in one:
                    one[key] = multiplied(self._said(one[key]), own)
            self._multiply(one, length, "point")
        for one in self.tree.get("inputs", {}).values():
            own = 1.0 if is_angle(tree, one) else length
            one["rate"] = one.get("rate", 1.0)
            self._multiply(one, own, "to", "from")
            self._multiply(one, own / time, "rate")
            self._multiply(one, own / time**2, "acceleration")
        forces = self.tree.get("forces", {})
        self.tree["forces"] = {k: one for n, f in forces.items() for k, one in self._split(n, f)}
        for one in self.tree["forces"].values():
            self._force(one)
        for one in self.tree.get("events", {}).values():
            one["when"] = self._said(one["when"])
        if "gravity" in tree:
            self._multiply(self.tree, length / time**2, "gravity")

    @staticmethod
    def _multiply(one: Tree, factor: float, *keys: str) -> None:
        for key in keys:
            if key in one:
                one[key] = multiplied(one[key], factor)

    def _said(self, formula: Any, **more: float) -> Any:
        """Formulas in which time, coordinates and rates have the old numbers."""
        if isinstance(formula, list | tuple):
            return [self._said(one, **more) for one in formula]
        if not isinstance(formula, str):
            return formula
        factors = {"t": self.T, **more}
        for name, one in self.old.get("coordinates", {}).items():
            factors[name] = 1.0 if is_angle(self.old, one) else self.L
            factors[f"{name}_dot"] = factors[name] / self.T

        def old(found: re.Match[str]) -> str:
            factor = factors.get(found[0], 1.0)
            return found[0] if factor == 1 else f"({found[0]}*{1 / factor!r})"

        return re.sub(r"[A-Za-z_]\w*", old, formula)

    def _body(self, body: Tree) -> None:
        L, M = self.L, self.M
        write_numbers(body)
        self._multiply(body, L, "position", "center")
        self._multiply(body, L / self.T, "velocity")
        self._multiply(body, 1 / self.T, "angular_velocity", "angular_velocity_b")
        self._multiply(body, M, "mass")
        if "inertia" in body:
            self._multiply(body["inertia"], M * L**2, "xx", "yy", "zz", "xy", "yz", "zx")
            self._multiply(body["inertia"], L, "about")
        for key in ("mass_points", "boxes", "rods", "cylinders", "spheres"):
            for part in body.get(key, ()):
                self._multiply(part, M, "mass")
                self._multiply(part, L, "at", "size", "ends", "radius")

    def _joint(self, joint: Tree) -> None:
        self._multiply(joint, self.L, "points", "at", "length", "pitch", "radius")
        if "factors" in joint:
            turns = [is_angle(self.old, {"coordinate": u}) for u in joint["coordinates"]]
            if not all(turns):
                joint["factors"] = [
                    multiplied(f, self.L if turn else 1.0)
                    for f, turn in zip(joint["factors"], turns, strict=True)
                ]

    def _split(self, name: str, force: Tree) -> list[tuple[str, Tree]]:
        """Force, or friction once for all that it acts on: each is scaled by its own."""
        if force["type"] != "friction" or "of" in force:
            return [(name, force)]
        kind = self.old["joints"][force["joint"]]["type"]
        leaves = LEAVES[TYPES.get(kind, kind)]
        if len(leaves) == 1:
            return [(name, force)]
        return [(f"{name}_{sort}", copy.deepcopy(force) | {"of": sort}) for sort in leaves]

    def _force(self, one: Tree) -> None:
        turns = is_angle(self.old, one)
        match one["type"]:
            case "force" | "torque" as kind:
                factor = self.force if kind == "force" else self.moment
                for key in (kind, f"{kind}_b"):
                    if key in one:
                        one[key] = multiplied(self._said(one[key]), factor)
                self._multiply(one, self.L, "point")
            case "along":
                own = self.moment if turns else self.force
                one["force"] = multiplied(self._said(one["force"]), own)
            case "bushing":
                self._multiply(one, self.L, "points", "at")
                for key, by in (("stiffness", 1.0), ("damping", self.T)):
                    if key in one:
                        along, about = one[key][:3], one[key][3:]
                        along = multiplied(along, by * self.force / self.L)
                        one[key] = along + multiplied(about, by * self.moment)
            case _:
                length = 1.0 if turns else self.L
                own = (self.moment if turns else self.force) / length
                self._multiply(one, self.L, "points", "free_length")
                self._multiply(one, own, "stiffness")
                self._multiply(one, own * self.T, "damping")
                for key in ("tension", "moment"):
                    if key in one:
                        said = self._said(one[key], x=length, v=length / self.T)
                        one[key] = multiplied(said, own * length)


def turned(tree: Tree, A: Matrix) -> Tree:
    """Scene that is turned about the origin of frame O."""
    return Displaced(tree, A, None).tree


def moved(tree: Tree, offset: Vector) -> Tree:
    """Scene that is moved elsewhere."""
    return Displaced(tree, None, offset).tree


class Displaced:
    """A scene of which all but frame O is turned, and then moved.

    Parameters
    ----------
    tree : dict
        The scene.
    A : (3, 3), optional
        How it is turned.
    offset : (3,), optional
        How far it is moved, in the unit of the scene.
    """

    def __init__(self, tree: Tree, A: Matrix | None, offset: Vector | None) -> None:
        self.A, self.offset, self.tree = A, offset, copy.deepcopy(tree)
        for body in self.tree["bodies"].values():
            self._body(body)
        for table in ("joints", "coordinates", "forces"):
            for one in self.tree.get(table, {}).values():
                self._element(one)
        for one in self.tree.get("drivers", {}).values():
            if "path" in one:
                one["path"] = self._place([str(x) for x in one["path"]])
        if "gravity" in self.tree:
            self.tree["gravity"] = self._direction(self.tree["gravity"])

    def _direction(self, a: Any) -> Any:
        if self.A is None:
            return a
        if not any(isinstance(x, str) for x in a):
            return list(times(self.A, a))
        parts = [[f"{c!r}*({x})" for x, c in zip(a, row, strict=True)] for row in self.A]
        return [" + ".join(row) for row in parts]

    def _place(self, s: Any) -> Any:
        seen = self._direction(s)
        if self.offset is None:
            return seen
        return [
            x if not y else f"({x}) + {y!r}" if isinstance(x, str) else x + y
            for x, y in zip(seen, self.offset, strict=True)
        ]

    def _body(self, body: Tree) -> None:
        if {"x", "y", "z"} & set(body.get("hold", ())):
            raise DoesNotApply("a body holds a component in frame O")
        write_numbers(body)
        body["position"] = self._place(body["position"])
        if self.A is not None and not body.get("point"):
            B = product(self.A, orientation_of(Reader(), body.get("orientation")))
            body["orientation"] = {"matrix": [[float(x) for x in row] for row in B]}
        for key in ("velocity", "angular_velocity"):
            if key in body:
                body[key] = self._direction(body[key])

    def _element(self, one: Tree) -> None:
        """Change what a joint, coordinate or force gives in frame O, that of the ground."""
        if "along" in one and self.offset is not None:
            raise DoesNotApply("a coordinate counts from the origin of frame O")
        if "at" in one:
            one["at"] = self._place(one["at"])
        for key in ("axis", "second_axis", "along", "force", "torque"):
            if isinstance(one.get(key), list | tuple):
                one[key] = self._direction(one[key])
        if one.get("type") == "bushing":
            one["axes"] = [*map(self._direction, one.get("axes", [[1, 0, 0], [0, 1, 0]]))]
        for k, body in enumerate(one.get("bodies", ())):
            if body != "ground":
                continue
            if "points" in one:
                one["points"][k] = self._place(one["points"][k])
            for key in ("axes", "zero"):
                if key in one and one["type"] != "bushing":
                    one[key][k] = self._direction(one[key][k])


def reordered(tree: Tree) -> Tree:
    """Scene whose elements are in the opposite order."""
    return {
        key: dict(reversed(value.items())) if isinstance(value, dict) else value
        for key, value in tree.items()
    }


def split(tree: Tree) -> Tree:
    """Scene whose rigid bodies are two halves each, of the same place, welded together."""
    new = copy.deepcopy(tree)
    for name, body in tree["bodies"].items():
        if body.get("point") or "mass" not in body:
            continue
        half = copy.deepcopy(body)
        half.pop("hold", None)
        for one in (new["bodies"][name], half):
            for key in ("mass_points", "boxes", "rods", "cylinders", "spheres"):
                for part in one.get(key, ()):
                    part["mass"] = multiplied(part["mass"], 0.5)
            one["mass"] = multiplied(one["mass"], 0.5)
            for key in ("xx", "yy", "zz", "xy", "yz", "zx"):
                if key in one.get("inertia", {}):
                    one["inertia"][key] = multiplied(one["inertia"][key], 0.5)
        new["bodies"][f"{name}_half"] = half
        new.setdefault("joints", {})[f"{name}_weld"] = {
            "type": "fixed",
            "bodies": [name, f"{name}_half"],
            "points": [[0, 0, 0], [0, 0, 0]],
        }
    if len(new["bodies"]) == len(tree["bodies"]):
        raise DoesNotApply("no body has a mass that can be divided")
    return new


def can_be_reversed(tree: Tree) -> bool:
    """Whether a motion runs back when all velocities are reversed."""
    if tree.get("drivers") or tree.get("inputs"):
        return False
    for one in tree.get("forces", {}).values():
        if "damping" in one or one["type"] == "friction":
            return False
        if re.search(r"\b(t|v|\w+_dot)\b", " ".join(map(str, one.values()))):
            return False
    return True
