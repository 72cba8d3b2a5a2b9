"""Check the inputs of a scene one by one: their targets, and their values from first to last."""

from __future__ import annotations

from math import isfinite, isnan, tau
from typing import TYPE_CHECKING

from kousoku.model.angles import Angle
from kousoku.model.elements.joints import free_coordinates_of
from kousoku.model.errors import SceneError
from kousoku.model.linkage.input_drivers import time_of, travel_of
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
"""Relative difference that times of the same division may have: rounding of written numbers."""

TARGETS = ("link", "slider", "joint")
"""Targets of an input; the table of each in the scene has the same name with an s."""


def check_inputs(scene: Scene, problems: Problems) -> None:
    """Check all inputs; their number is checked with the mobility.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    drives: dict[tuple[str, str], str] = {}
    for name, motion in scene.inputs.items():
        key = join("inputs", name)
        pairs = [(target, getattr(motion, target)) for target in TARGETS]
        uses = [join(f"{target}s", driven) for target, driven in pairs if driven is not None]
        problems.check(key, [key, *uses], _check_input, scene, name, drives)
        if not problems.is_broken("divisions"):
            problems.check(key, [key], _check_speed, scene, name)
    if not problems.touches("inputs") and any(motion.joint for motion in scene.inputs.values()):
        _check_times(scene, problems)


def _check_input(scene: Scene, name: str, drives: dict[tuple[str, str], str]) -> None:
    motion, key = scene.inputs[name], join("inputs", name)
    target, driven = _target(scene, motion, key)
    other = drives.setdefault((target, driven), name)
    if other != name:
        raise SceneError(f"prescribes the {target} {driven}, as inputs.{other} does", key=key)
    _check_values(motion, target, key)
    if target == "link":
        _check_link(scene, motion, driven, key)
    if target == "joint":
        _check_joint(scene, motion, driven, key)


def _target(scene: Scene, motion: Input, key: str) -> tuple[str, str]:
    """Target of an input: ``link``, ``slider`` or ``joint``, and its name."""
    targets = [target for target in TARGETS if getattr(motion, target) is not None]
    if len(targets) != 1:
        got = " and ".join(targets) or "none of them"
        raise SceneError(f"wanted one of link, slider and joint, got {got}", key=key)
    (target,) = targets
    driven: str = getattr(motion, target)
    require_known(target, driven, getattr(scene, f"{target}s"), f"{key}.{target}")
    return target, driven


def _check_values(motion: Input, target: str, key: str) -> None:
    if motion.to is not None and motion.turns is not None:
        raise SceneError("has both 'to' and 'turns'; wanted one of them", key=key)
    if target == "slider" and motion.turns is not None:
        raise SceneError("a slider makes no turns; wanted 'to'", key=f"{key}.turns")
    if target == "slider" and motion.to is None:
        raise SceneError("is missing; wanted the last displacement", key=f"{key}.to")
    if target == "slider":
        _refuse_angles(motion, key)
    if target != "link" and motion.about is not None:
        raise SceneError("belongs to an input of a link; leave it out", key=f"{key}.about")
    numbers = {"from": motion.start, "rate": motion.rate, "acceleration": motion.acceleration}
    for name, number in {**numbers, "to": motion.to, "turns": motion.turns}.items():
        if number is not None and not isfinite(number):
            raise SceneError(f"{number!r} is not a finite number", key=f"{key}.{name}")


def _check_speed(scene: Scene, name: str) -> None:
    motion, key = scene.inputs[name], join("inputs", name)
    if motion.link is None:
        return
    turns = turns_of(motion)
    if turns is None and motion.to is not None:
        turns = (motion.to - motion.start) / tau
    if abs(turns or 0.0) > MOST_TURNS * scene.divisions:
        raise SceneError(
            f"{turns:.6g} turns in {scene.divisions} divisions cannot be followed; wanted at most "
            f"{MOST_TURNS} turns a division",
            key=f"{key}.to" if motion.turns is None else f"{key}.turns",
        )


def _refuse_angles(motion: Input, key: str) -> None:
    """Refuse angles where displacements are prescribed."""
    numbers = {"from": motion.start, "rate": motion.rate, "acceleration": motion.acceleration}
    for name, number in {**numbers, "to": motion.to}.items():
        if isinstance(number, Angle):
            raise SceneError("is an angle; wanted a displacement", key=f"{key}.{name}")


def _check_joint(scene: Scene, motion: Input, joint: str, key: str) -> None:
    """Check that a joint has one coordinate, which reaches its last value without reversing."""
    kind = scene.joints[joint].type
    free = free_coordinates_of(kind)
    if len(free) != 1:
        problem = (
            "leaves free no angle or displacement that is one number; wanted another joint"
            if not free
            else f"leaves free {in_words(free)}; wanted a driver with 'of'"
        )
        raise SceneError(f"{joint} is {with_a(kind)} joint, which {problem}", key=f"{key}.joint")
    if free[0] == "displacement":
        _refuse_angles(motion, key)
        if motion.turns is not None:
            raise SceneError(
                f"{joint} is {with_a(kind)} joint, which makes no turns; wanted 'to'",
                key=f"{key}.turns",
            )
        if motion.to is None:
            raise SceneError("is missing; wanted the last displacement", key=f"{key}.to")
    if isnan(time_of(motion, 1.0)):
        raise SceneError(
            f"the way of {travel_of(motion):g} is not reached with a rate of {motion.rate:g} and "
            f"an acceleration of {motion.acceleration:g}; wanted a rate towards it",
            key=f"{key}.rate",
        )


def _check_times(scene: Scene, problems: Problems) -> None:
    """Check that inputs of joints take their divisions at the same times."""
    first, *others = (name for name, motion in scene.inputs.items() if motion.joint is not None)
    for name in others:
        for fraction in (0.25, 0.5, 1.0):
            expected, time = (time_of(scene.inputs[key], fraction) for key in (first, name))
            if abs(expected - time) > SAME_TIME * expected:
                problems.add(
                    f"takes {fraction:g} of its way in {time:.6g} s, and inputs.{first} in "
                    f"{expected:.6g} s; wanted the same times, or drivers instead of inputs",
                    join("inputs", name),
                )
                break


def _check_link(scene: Scene, motion: Input, link: str, key: str) -> None:
    first, second = scene.links[link].nodes
    if motion.about not in (first, second):
        got = "is missing" if motion.about is None else f"{motion.about[:40]!r} is no end of it"
        raise SceneError(
            f"{got}; wanted {first!r} or {second!r}, the end of the link {link} from which its "
            "angle is seen",
            key=f"{key}.about",
        )
    if scene.is_ground(link):
        raise SceneError(
            f"the link {link} lies between fixed nodes and cannot turn", key=f"{key}.link"
        )
