"""Runs with other parameters begin as the file with these values does."""

from __future__ import annotations

import random
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import kousoku as ks
from kousoku.model.errors import KousokuError
from kousoku.model.reading.read import scene_from_dict
from kousoku.model.reading.write import toml_of
from kousoku.runtime.integrate.assembled_start import WrittenBody
from tests.random_scenes import random_scene
from tests.start_with_parameters import missed
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.scenes import REASONS, stopping, told

if TYPE_CHECKING:
    from collections.abc import Iterator

BATCH = 5
"""Random scenes of a case."""

CHANGED, BY = 2, 0.1
"""So many parameters are changed, by this part at most."""

NOT_BEGUN = (
    *REASONS,
    "; wanted a positive number",
    "joints stay open, or come open by more than",
    "leave some out",
    "the start cannot be brought onto the constraints",
)
"""What runs with other parameters, and their files, are refused for, and rightly."""

SOON = 0.1
"""Time until which a run tells that its redundant rows miss [s]."""

PLACE, FAR_PLACE, VELOCITY = 1e-12, 1e-3, 1e-9
"""How far the file may be off, in lengths of the scene; where it is at another place; and how much
faster, as a part of the largest velocity: rows that others imply but for their closure tolerance
are met or left out."""


def cases(size: Size) -> Iterator[str]:
    """Name a case for each batch of random scenes."""
    for batch in range(-(-size.examples(5, 500) // BATCH)):
        yield f"begun {size.seed} {batch}"


def run(case: str) -> Outcome:
    """Begin the scenes of a case, or one of them by its place: ``begun 1 0 7``."""
    _, seed, batch, *one = case.split()
    outcome = Outcome()
    for k in map(int, one) if one else range(BATCH):
        draw = random.Random(f"{seed} {batch} {k}")
        ask(random_scene(draw), draw, outcome, f"scene {seed} {batch} {k}")
    return outcome


def ask(tree: dict[str, Any], draw: random.Random, outcome: Outcome, place: str) -> None:
    """Begin a scene with some of its parameters changed."""
    if not tree.get("parameters"):
        outcome.count("without parameters")
        return
    try:
        mechanism = ks.load(tree, target="numpy")
        solver: Any = mechanism.solver
        known = dict(solver.parameters)
        names = draw.sample([*known], min(CHANGED, len(known)))
        given = {name: known[name] * (1 + draw.uniform(-BY, BY)) for name in names}
        motion: Any = mechanism.simulate(times=[0.0], parameters=given)
        scene = scene_from_dict(tree)
        elsewhere, _ = missed(scene, given, motion)
        closed, faster = missed(scene, given, motion, is_there=True)
    except KousokuError as error:
        told(outcome, error, "refused", NOT_BEGUN, place)
        return
    outcome.count("begun" if solver.layout.given else "begun, nothing depends on them")
    if elsewhere > FAR_PLACE:
        outcome.count("begun elsewhere than the file, which is on another branch or far away")
    else:
        is_redundant = bool(solver.left_out)
        what = ", with redundant rows" if is_redundant else ""
        limit = FAR_PLACE if is_redundant else PLACE
        outcome.measure(f"place of the file{what} (lengths of the scene)", elsewhere, place, limit)
    if closed > PLACE:
        outcome.count("begun where joints are closed within their tolerance, not to rounding")
        return
    if faster > VELOCITY and mechanism.simulate(SOON, samples=2, parameters=given).ledger.missed:
        outcome.count("begun where redundant rows, which others imply nearly, are left out")
        return
    outcome.measure("velocity of the file there (relative)", faster, place)
    if not faster <= VELOCITY:
        options = " ".join(f"--set {name}={value!r}" for name, value in given.items())
        outcome.find(
            "a run with other parameters begins with another velocity than its file",
            f"{faster:.3g} of the largest; {place}",
            f"kousoku simulate scene.toml --end 0.1 {options}",
            scene__toml=toml_of(tree),
        )


@contextmanager
def in_the_body() -> Iterator[None]:
    """Let components of angular velocities in frame O count as those in the body."""
    right = WrittenBody.from_data

    def wrong(data: Any) -> WrittenBody:
        return replace(right(data), is_in_o=False)

    with patch.object(WrittenBody, "from_data", wrong):
        yield


@contextmanager
def as_assembled() -> Iterator[None]:
    """Let runs begin with what assembly made of velocities with the parameters of the scene."""
    with patch("kousoku.runtime.run.is_given_anew", lambda *_: False):
        yield


QUESTION = Question(
    asks="does a run with other parameters begin with the velocities that the file with these"
    " values has there?",
    cases=cases,
    run=run,
    faults=(
        Fault("velocities that assembly made for other places", as_assembled, "begun 1 3 1"),
        Fault("an angular velocity in the wrong frame", in_the_body, "begun 1 3 1"),
        Fault("motions that stop for no reason", stopping, "begun 1 3 1", "refused"),
    ),
)
