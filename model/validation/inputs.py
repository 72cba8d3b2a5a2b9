"""Check the inputs of a scene one by one: what each drives, and from where to where."""

from __future__ import annotations

from math import isfinite, isnan, tau
from typing import TYPE_CHECKING

from kousoku.model.angles import Angle
from kousoku.model.elements.joints import leaves_of
from kousoku.model.errors import SceneError
from kousoku.model.linkage.input_drivers import time_of, way_of
from kousoku.model.linkage.input_motion import turns_of
from kousoku.model.records.dotted_keys import join, require_known
from kousoku.model.text import in_words, with_a

if TYPE_CHECKING:
    from kousoku.model.records.planar import Input
    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene

MOST_TURNS = 10
"""Turns of a link in one division: a step is halved until the solver can follow."""

SAME_TIME = 1e-9
"""Part by which times of the same division may differ: rounding of what is written."""

TARGETS = ("link", "slider", "joint")
"""What an input may drive; its table in the scene has the same name with an s."""


def check_inputs(scene: Scene, problems: Problems) -> None:
    """Check all inputs; whether they are as many as wanted is left to the mobility.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    drives: dict[tuple[str, str], str] = {}
    for name, given in scene.inputs.items():
        key = join("inputs", name)
        pairs = [(target, getattr(given, target)) for target in TARGETS]
        uses = [join(f"{target}s", driven) for target, driven in pairs if driven is not None]
        problems.check(key, [key, *uses], _check_input, scene, name, drives)
        if not problems.is_broken("divisions"):
            problems.check(key, [key], _check_speed, scene, name)
    if not problems.touches("inputs") and any(given.joint for given in scene.inputs.values()):
        _check_times(scene, problems)


def _check_input(scene: Scene, name: str, drives: dict[tuple[str, str], str]) -> None:
    given, key = scene.inputs[name], join("inputs", name)
    target, driven = _target(scene, given, key)
    other = drives.setdefault((target, driven), name)
    if other != name:
        raise SceneError(f"prescribes the {target} {driven}, as inputs.{other} does", key=key)
    _check_way(given, target, key)
    if target == "link":
        _check_link(scene, given, driven, key)
    if target == "joint":
        _check_joint(scene, given, driven, key)


def _target(scene: Scene, given: Input, key: str) -> tuple[str, str]:
    """Target of an input: ``link``, ``slider`` or ``joint``, and its name."""
    targets = [target for target in TARGETS if getattr(given, target) is not None]
    if len(targets) != 1:
        got = " and ".join(targets) or "none of them"
        raise SceneError(f"wanted one of link, slider and joint, got {got}", key=key)
    (target,) = targets
    driven: str = getattr(given, target)
    require_known(target, driven, getattr(scene, f"{target}s"), f"{key}.{target}")
    return target, driven


def _check_way(given: Input, target: str, key: str) -> None:
    if given.to is not None and given.turns is not None:
        raise SceneError("has both 'to' and 'turns'; wanted one of them", key=key)
    if target == "slider" and given.turns is not None:
        raise SceneError("a slider makes no turns; wanted 'to'", key=f"{key}.turns")
    if target == "slider" and given.to is None:
        raise SceneError("is missing; wanted the last displacement", key=f"{key}.to")
    if target == "slider":
        _refuse_angles(given, key)
    if target != "link" and given.about is not None:
        raise SceneError("belongs to an input of a link; leave it out", key=f"{key}.about")
    numbers = {"from": given.start, "rate": given.rate, "acceleration": given.acceleration}
    for what, number in {**numbers, "to": given.to, "turns": given.turns}.items():
        if number is not None and not isfinite(number):
            raise SceneError(f"{number!r} is not a finite number", key=f"{key}.{what}")


def _check_speed(scene: Scene, name: str) -> None:
    given, key = scene.inputs[name], join("inputs", name)
    if given.link is None:
        return
    turns = turns_of(given)
    if turns is None and given.to is not None:
        turns = (given.to - given.start) / tau
    if abs(turns or 0.0) > MOST_TURNS * scene.divisions:
        raise SceneError(
            f"{turns:.6g} turns in {scene.divisions} divisions cannot be followed; wanted at most "
            f"{MOST_TURNS} turns a division",
            key=f"{key}.to" if given.turns is None else f"{key}.turns",
        )


def _refuse_angles(given: Input, key: str) -> None:
    """Refuse angles of what slides."""
    numbers = {"from": given.start, "rate": given.rate, "acceleration": given.acceleration}
    for what, number in {**numbers, "to": given.to}.items():
        if isinstance(number, Angle):
            raise SceneError("is an angle; wanted a displacement", key=f"{key}.{what}")


def _check_joint(scene: Scene, given: Input, joint: str, key: str) -> None:
    """Check that the coordinate of a joint reaches the last value, on the straight way."""
    kind = scene.joints[joint].type
    leaves = leaves_of(kind)
    if len(leaves) != 1:
        problem = (
            "leaves free no angle or displacement that is one number; wanted another joint"
            if not leaves
            else f"leaves free {in_words(leaves)}; wanted a driver with 'of'"
        )
        raise SceneError(f"{joint} is {with_a(kind)} joint, which {problem}", key=f"{key}.joint")
    if leaves[0] == "displacement":
        _refuse_angles(given, key)
        if given.turns is not None:
            raise SceneError(
                f"{joint} is {with_a(kind)} joint, which makes no turns; wanted 'to'",
                key=f"{key}.turns",
            )
        if given.to is None:
            raise SceneError("is missing; wanted the last displacement", key=f"{key}.to")
    if isnan(time_of(given, 1.0)):
        raise SceneError(
            f"the way of {way_of(given):g} is not reached with a rate of {given.rate:g} and an "
            f"acceleration of {given.acceleration:g}; wanted a rate towards it",
            key=f"{key}.rate",
        )


def _check_times(scene: Scene, problems: Problems) -> None:
    """Check that inputs of joints take their divisions at the same times."""
    first, *others = (name for name, given in scene.inputs.items() if given.joint is not None)
    for name in others:
        for part in (0.25, 0.5, 1.0):
            one, other = (time_of(scene.inputs[which], part) for which in (first, name))
            if abs(one - other) > SAME_TIME * one:
                problems.add(
                    f"takes {part:g} of its way in {other:.6g} s, and inputs.{first} in "
                    f"{one:.6g} s; wanted the same times, or drivers instead of inputs",
                    join("inputs", name),
                )
                break


def _check_link(scene: Scene, given: Input, link: str, key: str) -> None:
    first, second = scene.links[link].nodes
    if given.about not in (first, second):
        got = "is missing" if given.about is None else f"{given.about[:40]!r} is no end of it"
        raise SceneError(
            f"{got}; wanted {first!r} or {second!r}, the end of the link {link} from which its "
            "angle is seen",
            key=f"{key}.about",
        )
    if scene.is_ground(link):
        raise SceneError(
            f"the link {link} lies between fixed nodes and cannot turn", key=f"{key}.link"
        )
