"""Check the inputs of a scene one by one: what each drives, and from where to where."""

from __future__ import annotations

from math import isfinite, tau
from typing import TYPE_CHECKING

from kousoku.model.decode import join, unknown
from kousoku.model.errors import SceneError
from kousoku.model.motion import turns_of

if TYPE_CHECKING:
    from kousoku.model.planar import Input
    from kousoku.model.problems import Problems
    from kousoku.model.scene import Scene

MOST_TURNS = 10
"""Turns of a link in one division: a step is halved until the solver can follow."""

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


def _check_input(scene: Scene, name: str, drives: dict[tuple[str, str], str]) -> None:
    given, key = scene.inputs[name], join("inputs", name)
    target, driven = _target(scene, given, key)
    other = drives.setdefault((target, driven), name)
    if other != name:
        raise SceneError(f"prescribes the {target} {driven}, as inputs.{other} does", key=key)
    _check_way(given, target, key)
    if target == "link":
        _check_link(scene, given, driven, key)


def _target(scene: Scene, given: Input, key: str) -> tuple[str, str]:
    """Return what an input drives: ``link``, ``slider`` or ``joint``, and its name."""
    targets = [target for target in TARGETS if getattr(given, target) is not None]
    if len(targets) != 1:
        got = " and ".join(targets) or "none of them"
        raise SceneError(f"wanted one of link, slider and joint, got {got}", key=key)
    (target,) = targets
    driven: str = getattr(given, target)
    known = tuple(getattr(scene, f"{target}s"))
    if driven not in known:
        problem = unknown(f"{target} {driven[:40]!r}", driven, known)
        raise SceneError(problem, key=f"{key}.{target}")
    return target, driven


def _check_way(given: Input, target: str, key: str) -> None:
    if given.to is not None and given.turns is not None:
        raise SceneError("has both 'to' and 'turns'; wanted one of them", key=key)
    if target == "slider" and given.turns is not None:
        raise SceneError("a slider makes no turns; wanted 'to'", key=f"{key}.turns")
    if target == "slider" and given.to is None:
        raise SceneError("is missing; wanted the last displacement", key=f"{key}.to")
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
