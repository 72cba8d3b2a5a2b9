"""Check the drivers of a spatial scene: driven coordinates and laws of time."""

from __future__ import annotations

from math import isfinite, pi
from typing import TYPE_CHECKING

from kousoku.model.elements.checks import only_one, refuse_foreign
from kousoku.model.elements.drivers import DRIVERS, own_inputs
from kousoku.model.elements.joints import sort_of
from kousoku.model.errors import ExpressionError, SceneError
from kousoku.model.expressions.exponentials import rate_of
from kousoku.model.expressions.formulas import RATE, TIME, values_at_start
from kousoku.model.expressions.kinks import kink_of
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.linkage.input_drivers import formula_text
from kousoku.model.operations.graph import Op
from kousoku.model.records.dotted_keys import join
from kousoku.model.records.problems import Problems

if TYPE_CHECKING:
    from kousoku.model.elements.driver import Driven
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Driver, Value


def check_drivers(scene: Scene, problems: Problems) -> None:
    """Check all drivers; whether they leave anything to move is left to the solver.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    drives: dict[Driven, str] = {}
    for name, driver in scene.drivers.items():
        key = join("drivers", name)
        uses = [
            join(table, used)
            for table, used in (
                ("coordinates", driver.coordinate),
                ("joints", driver.joint),
                ("bodies", driver.body),
            )
            if used is not None
        ]
        problems.check(key, [key, *uses], _check_driven, scene, name, drives)
        if not problems.touches("parameters"):  # a formula may use a broken parameter
            problems.check(key, (), _check_laws, scene, driver, key)
            problems.check(key, [key, *uses], _check_turn, scene, driver, f"{key}.value")
    for name, motion in scene.inputs.items():
        if motion.joint is None or problems.is_broken(join("inputs", name)):
            continue
        driven = (motion.joint, sort_of(scene.joints[motion.joint].type, None))
        if other := drives.get(driven):
            problem = f"prescribes the joint {motion.joint}, as {other} does"
            problems.add(problem, join("inputs", name))


def _check_driven(scene: Scene, name: str, drives: dict[Driven, str]) -> None:
    driver, key = scene.drivers[name], join("drivers", name)
    kind = DRIVERS[only_one(driver, tuple(DRIVERS), key)]
    known = tuple(dict.fromkeys(name for sort in DRIVERS.values() for name in sort.all_keys))
    refuse_foreign(driver, kind.all_keys, known, key)
    for driven in kind.driven(scene, driver, key):
        other = drives.setdefault(driven, key)
        if other != key:
            raise SceneError(f"drives the same as {other}; leave one of them out", key=key)


def _check_laws(scene: Scene, driver: Driver, key: str) -> None:
    """Check all formulas of a driver, whatever is wrong with what it drives."""
    laws = {f"{key}.path[{index}]": value for index, value in enumerate(driver.path or ())}
    if driver.value is not None:
        laws[f"{key}.value"] = driver.value
    for name, entry in own_inputs().items():
        if entry.depends_on == "time" and driver.input(name) is not None:
            laws[f"{key}.{name}"] = driver.input(name)
    problems = Problems()
    for law_key, value in laws.items():
        problems.check(law_key, (), _check_law, scene, value, law_key)
    problems.settle()


def _check_turn(scene: Scene, driver: Driver, key: str) -> None:
    """Check that the law of an angle starts within half a turn of its ``near``."""
    if driver.value is None:
        return
    turn = DRIVERS[only_one(driver, tuple(DRIVERS), key)].near(scene, driver)
    if turn is None:
        return
    name, near = turn
    start = _check_law(scene, driver.value, key)
    if abs(near - start) > pi:
        raise SceneError(
            f"is {start:g} at t = 0, and {name} is near {near:g}; wanted both within "
            "half a turn, or leave 'near' out",
            key=key,
        )


def _check_law(scene: Scene, value: Value, key: str) -> float:
    """Check a formula of time: it and its first two derivatives are finite at the start.

    Returns
    -------
    float
        Its value at the start.
    """
    start = values_at_start(scene)
    try:
        law = parse_expression(formula_text(value), start)
    except ExpressionError as error:
        raise SceneError(_with_state(scene, str(error)), key=key) from None
    kink = kink_of(law, TIME, scene.parameters)
    if kink is not None:
        operation = {Op.POW: "a power", Op.DIV: "a quotient"}.get(kink.op, kink.op.value)
        raise SceneError(
            f"{operation} has a kink, where velocities or accelerations would jump: a "
            "driver must have two derivatives; wanted a smooth formula",
            key=key,
        )
    derivatives = []
    for order, name in enumerate(("value", "rate", "acceleration")):
        derivatives.append(value_of(rate_of(law, order), start))
        if not isfinite(derivatives[-1]):
            raise SceneError(f"has no finite {name} at t = 0; wanted one", key=key)
    return derivatives[0]


def _with_state(scene: Scene, problem: str) -> str:
    """Message; for a name of a coordinate or its rate, what laws of drivers may depend on."""
    names = (f"{name}{suffix}" for name in scene.coordinates for suffix in ("", RATE))
    if any(f"name {name!r}" in problem for name in names):
        return f"{problem.partition('; ')[0]}; a driver depends on t and on parameters only"
    return problem
