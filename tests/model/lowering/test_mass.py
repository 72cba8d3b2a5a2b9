"""Mass properties: sums, reference points, principal axes, and what no body can have."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.lowering.mass import MassProperties, mass_properties, traced_principal
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.traced import Traced, parameter
from kousoku.model.numbers.varying import Varying
from kousoku.model.reading.read import scene_from_dict

Tree = dict[str, Any]


def body_of(**keys: Any) -> Any:
    """Checked body at the origin."""
    tree = {"name": "one", "unit": "m", "bodies": {"b": {"position": [0, 0, 0], **keys}}}
    return scene_from_dict(tree).bodies["b"]


def properties(**keys: Any) -> MassProperties:
    """Mass properties of a body at the origin."""
    return mass_properties(body_of(**keys))


def moments(given: MassProperties) -> list[float]:
    """Principal moments as doubles."""
    return [float(moment) for moment in given.moments]


def refused(key: str, says: str, **keys: Any) -> None:
    """Check that a body is refused at a key, for a reason."""
    with pytest.raises(SceneError) as caught:
        body_of(**keys)
    assert caught.value.key == f"bodies.b.{key}"
    assert says in caught.value.problem


def test_a_uniform_box_has_the_moments_of_the_textbook() -> None:
    box = properties(boxes=[{"mass": 12, "size": [1, 2, 3], "at": [4, 5, 6]}])
    assert moments(box) == [13, 10, 5]
    assert [float(x) for x in box.center] == [4, 5, 6]


def test_a_uniform_cylinder_has_the_moments_of_the_textbook() -> None:
    """I = m R²/2 along, m (3 R² + L²)/12 across; here m = 12, R = 2, L = 3, along x."""
    cylinder = properties(cylinders=[{"mass": 12, "radius": 2, "ends": [[1, 0, 0], [4, 0, 0]]}])
    assert moments(cylinder) == [24, 21, 21]
    assert float(cylinder.center[0]) == 2.5


def test_a_sphere_and_a_rod_have_the_moments_of_the_textbook() -> None:
    assert moments(properties(spheres=[{"mass": 5, "radius": 3}])) == [18, 18, 18]
    rod = properties(rods=[{"mass": 12, "ends": [[0, -1, 0], [0, 1, 0]]}])
    assert moments(rod) == [4, 0, 4]


def test_a_cylinder_cut_in_two_is_the_cylinder() -> None:
    """The parts are summed about the common centre of mass (Steiner)."""
    whole = properties(cylinders=[{"mass": 2, "radius": 0.5, "ends": [[0, 0, 1], [2, 1, 5]]}])
    halves = [
        {"mass": 1, "radius": 0.5, "ends": [[0, 0, 1], [1, 0.5, 3]]},
        {"mass": 1, "radius": 0.5, "ends": [[1, 0.5, 3], [2, 1, 5]]},
    ]
    cut = properties(cylinders=halves)
    for one, other in zip(whole.moments, cut.moments, strict=True):
        assert abs(one - other) < 1e-45
    assert all(abs(a - b) < 1e-45 for a, b in zip(whole.center, cut.center, strict=True))


def test_a_body_is_the_sum_of_all_that_it_is_made_of() -> None:
    """A point of 1 kg at x = 3 and a body of 2 kg at 0: the centre is at 1, I = 2·1 + 1·4 + own."""
    both = properties(
        mass=2, inertia={"xx": 1, "yy": 1, "zz": 1}, mass_points=[{"mass": 1, "at": [3, 0, 0]}]
    )
    assert float(both.mass) == 3
    assert abs(both.center[0] - 1) < 1e-45
    assert moments(both) == [1, 7, 7]


@pytest.mark.parametrize("about", [[0, 0, 0], [1, 2, 3], [-4, 0.5, 0.25]])
def test_a_tensor_may_be_about_any_point(about: list[float]) -> None:
    """I_P = I_C + m (|d|² E − d dᵀ), with d from P to the centre of mass."""
    d = [c - p for c, p in zip((1, 0, -1), about, strict=True)]
    square = sum(x * x for x in d)
    inertia = {
        "xx": 1 + 2 * (square - d[0] ** 2),
        "yy": 2 + 2 * (square - d[1] ** 2),
        "zz": 3 + 2 * (square - d[2] ** 2),
        "xy": -2 * d[0] * d[1],
        "yz": -2 * d[1] * d[2],
        "zx": -2 * d[2] * d[0],
        "about": about,
    }
    given = properties(mass=2, center=[1, 0, -1], inertia=inertia)
    assert moments(given) == [1, 2, 3]
    assert given.axes[1:] == precise.ZERO


def test_principal_axes_make_the_tensor_diagonal() -> None:
    """A′ I A′ᵀ is diagonal for the rotation A′ to the principal frame, and tr I stays."""
    tensor = ((3, 0.25, -0.5), (0.25, 4, 0.125), (-0.5, 0.125, 5))
    given = properties(
        mass=1, inertia={"xx": 3, "yy": 4, "zz": 5, "xy": 0.25, "yz": 0.125, "zx": -0.5}
    )
    for k in range(3):
        axis = tuple(precise.number(int(k == index)) for index in range(3))
        along = precise.rotate_back(given.axes, (axis[0], axis[1], axis[2]))
        turned = tuple(precise.dot(precise.triple(row), along) for row in tensor)
        difference = precise.subtract(
            (turned[0], turned[1], turned[2]), precise.scale(given.moments[k], along)
        )
        assert precise.length(difference) < 1e-45
        assert along[k] == max(along), "the nearest axis of the body keeps its place"
    assert abs(sum(given.moments) - 12) < 1e-45


def test_a_principal_axis_of_the_body_frame_stays_where_it_is() -> None:
    """With xy alone off the diagonal the rotation is about z, digit for digit."""
    given = properties(mass=1, inertia={"xx": 1, "yy": 1.5, "zz": 2, "xy": 0.25})
    assert given.axes[1] == given.axes[2] == 0 != given.axes[3]
    assert given.moments[2] == 2


def test_what_rounding_leaves_off_the_diagonal_turns_no_axis() -> None:
    """Three equal arms have equal moments; the last digits of their sines are no axes."""
    arms = [[1, 0, 0], [-0.5, 0.8660254037844386, 0], [-0.5, -0.8660254037844386, 0]]
    star = properties(mass_points=[{"mass": 1, "at": arm} for arm in arms])
    assert star.axes[1:] == precise.ZERO


@pytest.mark.parametrize(
    ("key", "says", "keys"),
    [
        ("inertia", "no body has these moments", {"inertia": {"xx": 1, "yy": 1, "zz": 3}}),
        ("inertia", "is 1e-310; wanted", {"inertia": {"xx": 1e-310, "yy": 1e-310, "zz": 1e-310}}),
        ("inertia", "are -1, 1, 1", {"inertia": {"xx": -1, "yy": 1, "zz": 1}}),
        ("inertia", "are -1, 1, 3", {"inertia": {"xx": 1, "yy": 1, "zz": 1, "xy": 2}}),
        (
            "inertia",
            "taken to the centre",
            {"inertia": {"xx": 1, "yy": 1, "zz": 1, "about": [1, 1, 1]}},
        ),
    ],
)
def test_moments_that_no_body_has_are_refused(key: str, says: str, keys: Tree) -> None:
    refused(key, says, mass=1, **keys)


@pytest.mark.parametrize(
    ("key", "keys"),
    [
        ("mass_points[0].mass", {"mass_points": [{"mass": 0, "at": [0, 0, 0]}]}),
        ("boxes[0].size[2]", {"boxes": [{"mass": 1, "size": [1, 1, 0]}]}),
        ("rods[0].ends", {"rods": [{"mass": 1, "ends": [[1, 0, 0], [1, 0, 0]]}]}),
        ("cylinders[0].radius", {"cylinders": [{"mass": 1, "radius": -1, "ends": [[0] * 3] * 2}]}),
        ("spheres[0].mass", {"spheres": [{"mass": -1, "radius": 1}]}),
        ("boxes[0].orientation", {"boxes": [{"mass": 1, "size": [1] * 3, "orientation": {}}]}),
    ],
)
def test_a_solid_has_a_mass_and_a_size(key: str, keys: Tree) -> None:
    refused(key, "wanted", **keys)


@pytest.mark.parametrize("key", ["center", "inertia", "mass_points", "spheres"])
def test_a_point_has_a_mass_only(key: str) -> None:
    values = {
        "center": [0, 0, 0],
        "inertia": {"xx": 1, "yy": 1, "zz": 1},
        "mass_points": [{"mass": 1, "at": [0, 0, 0]}],
        "spheres": [{"mass": 1, "radius": 1}],
    }
    refused(key, "a point has a mass only", point=True, mass=1, **{key: values[key]})


def test_scenes_with_the_same_formulas_and_other_parameters_have_masses_of_their_own() -> None:
    """What is computed once for equal bodies is looked up by their numbers, not by their texts."""

    def mass(p: float) -> float:
        body = {"position": [0, 0, 0], "mass": "p", "inertia": {"xx": 1, "yy": 1, "zz": 1}}
        tree = {"name": "one", "unit": "m", "parameters": {"p": p}, "bodies": {"b": body}}
        return float(system_of(scene_from_dict(tree), ()).bodies[0].mass)

    assert [mass(2.0), mass(7.0), mass(2.0)] == [2.0, 7.0, 2.0]


@pytest.mark.parametrize("keys", [{"mass": 1e-9}, {"length": 1e-9}, {}])
def test_a_radius_turns_no_axes_in_any_units(keys: Tree) -> None:
    """Rounding off the diagonal is beside moments, which units make as small as they like."""
    mass, length = (keys.get(key, 1.0) for key in ("mass", "length"))
    cylinder = {
        "mass": mass * 1.90625,
        "radius": "p",
        "ends": [[length * x for x in end] for end in ([250, -250, -250], [875, 0, 125])],
    }
    body = {"position": [0, 0, 0], "cylinders": [cylinder]}
    parameters = {"p": length * 200.0}
    tree = {"name": "one", "unit": "m", "parameters": parameters, "bodies": {"b": body}}
    (own,) = system_of(scene_from_dict(tree), ()).bodies
    assert all(isinstance(x, Varying) for x in own.inertia)
    assert not any(isinstance(x, Varying) for x in own.axes_b)


def test_rounding_beside_an_element_off_the_diagonal_is_no_axis() -> None:
    """One element off the diagonal turns axes about z, whatever rounding leaves of the others."""
    p = parameter("p", 1.0, 0)
    noise = p * CONTEXT.mpf(10) ** -52
    tensor = [[2 * p, p * p / 4, noise], [p * p / 4, 3 * p, noise], [noise, noise, 4 * p]]
    _, axes = traced_principal(tensor)
    assert axes[1] == axes[2] == 0
    assert isinstance(axes[3], Traced)
