"""Forces of time and place that act for a moment, at random places and of random widths.

Each has a closed form: the momentum that a pulse gives, the speed that a wall gives back.
"""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import kousoku as ks
from tests.stress.kit import Fault, Outcome, Question, Size

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

END = 10.0
BATCH = 50
"""Random pulses of a case: they share the compiled scene."""

WAYS: tuple[dict[str, Any], ...] = (
    {"method": "dopri5"},
    {"method": "dop853"},
    {"method": "dopri5", "step": 0.37},
)

#: A force of 10 N on 1 kg that rises and falls by a part of its width.
PULSE = """
name = "pulse"
unit = "m"
outputs = ["energies"]
parameters = { start = 5.0, width = 1.0, rise = 0.01 }
[bodies.block]
point = true
position = [0, 0, 0]
mass = 1
[forces.hit]
type = "force"
body = "block"
force = ["10*max(0, min(1, (t - start)/(rise*width), (start + width - t)/(rise*width)))", "0", "0"]
"""


def cases(size: Size) -> Iterator[str]:
    """Name a case for each batch of random pulses."""
    for batch in range(-(-size.examples(50, 1000) // BATCH)):
        yield f"pulse {size.seed} {batch}"


def run(case: str) -> Outcome:
    """Run the pulses of a case."""
    draw, outcome = random.Random(case), Outcome()
    scene = ks.load(PULSE)
    for number in range(BATCH):
        width = END * 10 ** draw.uniform(-6, -0.5)
        start, rise = draw.uniform(0, END - width), draw.choice([0.01, 0.3, 1e-4])
        way = WAYS[number % len(WAYS)]
        parameters = {"start": start, "width": width, "rise": rise}
        motion = scene.simulate(END, parameters=parameters, samples=draw.choice([2, 101]), **way)
        speed = float(motion.body("block").velocity[-1][0])
        wanted = 10 * width * (1 - rise)
        outcome.count("pulses")
        if abs(speed - wanted) > 0.01 * wanted:
            outcome.find(
                "a pulse is missed",
                f"{speed:g} m/s, wanted {wanted:g}; {parameters} {way}",
                f"kousoku simulate pulse.toml --end {END:g}",
                pulse__toml=PULSE,
            )
        outcome.measure("momentum that a pulse gives (relative)", abs(speed / wanted - 1), str(way))
    return outcome


def leap() -> AbstractContextManager[object]:
    """Make pulses shorter than their formula says."""
    return patch(f"{__name__}.PULSE", PULSE.replace("t - start", "t - start - width/2"))


QUESTION = Question(
    asks="pulses, walls, bumps, kinks and jumps at random places, of widths down to 1e-6 of the"
    " span: is one missed?",
    cases=cases,
    run=run,
    faults=(Fault("a pulse that is shorter than its formula says", leap, "pulse 1 0"),),
)
