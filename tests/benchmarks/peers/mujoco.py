"""MuJoCo: joint coordinates, loops kept by soft constraints, steps of one length, made in C."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.problems.tree import GROUND

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.problems.tree import Point, Tree, TreeLink

#: How stiff its loops are: two steps are the shortest time constant that it takes.
LOOPS = {"solref": (2.0, 1.0), "solimp": (0.9999, 0.9999, 0.001, 0.5, 2)}
MEMORY = "256M"


def text(tree: Tree) -> str:
    """Model in MuJoCo's XML: a site for each point that is judged or pulled."""
    sites: dict[int, list[str]] = {k: [] for k in range(-1, len(tree.links))}

    def site(name: str, point: Point) -> None:
        sites[point[0]].append(f'<site name="{name}" pos="{_words(point[1])}"/>')

    for k, point in enumerate(tree.observed):
        site(f"observed_{k}", point)
    for k, spring in enumerate(tree.springs):
        site(f"spring_{k}_a", spring.a)
        site(f"spring_{k}_b", spring.b)

    def body(k: int) -> str:
        link, joints = tree.links[k], _joint(tree.links[k])
        while not link.mass:  # a cross of a universal joint: one body has both hinges
            (k,) = tree.children(k)
            link = replace(tree.links[k], at=link.at)
            joints += _joint(link)
        inner = "".join(body(child) for child in tree.children(k))
        return (
            f'<body name="link_{k}" pos="{_words(link.at)}">{joints}'
            f'<inertial pos="{_words(link.center)}" mass="{link.mass}"'
            f' diaginertia="{_words(link.inertia)}"/>{"".join(sites[k])}{inner}</body>'
        )

    bodies = "".join(body(k) for k in tree.children(GROUND))
    pairs = [(loop.a, loop.b) for loop in tree.loops]
    named = [
        f'<connect body1="{_name(a[0])}" body2="{_name(b[0])}" anchor="{_words(a[1])}"/>'
        for a, b in pairs
    ]
    tendons = "".join(
        f'<spatial stiffness="{spring.stiffness!r}" damping="{spring.damping!r}"'
        f' springlength="{spring.free_length!r}"><site site="spring_{k}_a"/>'
        f'<site site="spring_{k}_b"/></spatial>'
        for k, spring in enumerate(tree.springs)
    )
    return (
        '<mujoco><compiler angle="radian" balanceinertia="false" boundmass="0"/>'
        f'<option gravity="{_words(tree.gravity)}" solver="Newton" iterations="100"'
        ' tolerance="1e-14"><flag contact="disable"/></option>'
        f'<size memory="{MEMORY}"/><worldbody>{"".join(sites[GROUND])}{bodies}</worldbody>'
        f"<equality>{''.join(named)}</equality><tendon>{tendons}</tendon></mujoco>"
    )


def _name(link: int) -> str:
    return "world" if link == GROUND else f"link_{link}"


def _words(numbers: Any) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _joint(link: TreeLink) -> str:
    kind = "slide" if link.is_slide else "hinge"
    return f'<joint type="{kind}" axis="{_words(np.eye(3)[link.axis])}"/>'


def order_of(tree: Tree) -> list[int]:
    """Links as MuJoCo numbers their joints, depth first."""

    def below(k: int) -> list[int]:
        return [k, *(deep for child in tree.children(k) for deep in below(child))]

    return [deep for child in tree.children(GROUND) for deep in below(child)]


def runs(
    tree: Tree, method: str, steps: int, times: Array
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that step to the end, and that give the observed positions at all times."""
    mujoco = required("mujoco")
    mujoco.set_mju_user_warning(lambda _text: None)  # or it writes a file: errors tell the same
    model = mujoco.MjModel.from_xml_string(text(tree))
    model.opt.timestep = float(times[-1]) / steps
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{method.upper()}")
    if model.neq:
        time_constant, ratio = LOOPS["solref"]
        model.eq_solref[:] = [time_constant * model.opt.timestep, ratio]
        model.eq_solimp[:] = LOOPS["solimp"]
        for k, loop in enumerate(tree.loops):
            model.eq_data[k, :3], model.eq_data[k, 3:6] = loop.a[1], loop.b[1]
    data = mujoco.MjData(model)
    order = order_of(tree)
    torques = [tree.torques.get(k, 0.0) for k in order]

    def begin() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:] = np.array(tree.q)[order]
        data.qvel[:] = np.array(tree.v)[order]
        data.qfrc_applied[:] = torques

    def run() -> None:
        begin()
        mujoco.mj_step(model, data, steps)

    def positions() -> Array:
        begin()
        sites = [model.site(f"observed_{k}").id for k in range(len(tree.observed))]
        axes = ["xyz".index(axis) for axis in tree.axes]
        rows = []
        for _ in times:
            mujoco.mj_step(model, data, steps // len(times))
            mujoco.mj_kinematics(model, data)
            rows.append(data.site_xpos[sites][:, axes].ravel().copy())
        return np.array(rows)

    return run, positions
