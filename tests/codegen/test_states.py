"""Emitted kernels where machines are: no digits are lost that the inputs still have.

The values are those of the component level in 50 digits, the units those of ``verify``.
"""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pytest

from kousoku.codegen.error_unit import columns
from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.generate import package_of
from kousoku.codegen.points import ordinary
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.codegen.states import coincident_points, motion_points
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.dual import evaluate_dual
from kousoku.runtime import load
from kousoku.runtime.report import LIMIT
from kousoku.symbolic.components import cross
from kousoku.symbolic.matrices import quadratic_form

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.symbolic.derivation import Derivation, Function

    Numbers = dict[str, Any]
    Derived = Callable[[str], Derivation]
    State = Callable[[Numbers, np.random.Generator], None]

FAR_OFF = json.loads(Path(__file__).with_name("far_off.json").read_text())
TARGETS: tuple[Literal["c", "numpy"], ...] = ("c", "numpy")
#: How many states are tried with all other tests; a matrix takes longer.
FEW, FEWEST = 8, 4


def function_of(derivation: Derivation, output: str) -> Function:
    """Function that has an output, with this output alone."""
    for function in derivation.functions:
        for one in function.outputs:
            if one.quantity.name == output:
                return replace(function, outputs=(one,))
    raise AssertionError(output)


def emitted(kind: str, kernel: str, target: Literal["c", "numpy"]) -> Any:
    package = package_of(kind)
    folder = resources.files("kousoku.generated").joinpath("kinds", package)
    choice = kind.removeprefix(package)
    return load(Path(str(folder)), target=target)[kernel + choice]


def errors(
    function: Function,
    kind: str,
    states: Sequence[Mapping[str, Any]],
    targets: Sequence[Literal["c", "numpy"]],
) -> Any:
    """Errors of all elements at all states with all targets, in units."""
    components, name = freeze_components(function), function.outputs[0].quantity.name
    kernels = [emitted(kind, function.name, target) for target in targets]
    found = []
    for state in states:
        inputs = {q.name: np.ravel(state[q.name]).tolist() for q in function.inputs}
        whole = [np.reshape(inputs[q.name], q.shape) for q in kernels[0].manifest.inputs]
        numbers = {(n, k): CONTEXT.mpf(x) for n, xs in inputs.items() for k, x in enumerate(xs)}
        wanted = columns(evaluate_dual(components, inputs)[name], numbers, ())
        high, low, unit = (np.array(wanted[x], dtype=float) for x in ("high", "low", "unit"))
        for kernel in kernels:
            got = np.ravel(kernel(*whole, outputs=(name,)))
            found.append(np.abs((got - high) - low) / unit)
    return np.array(found)


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("point", FAR_OFF, ids=lambda point: f"{point['kind']}-{point['output']}")
def test_points_where_kernels_were_far_off(
    point: Any, target: Literal["c", "numpy"], derived: Derived
) -> None:
    function = function_of(derived(point["kind"]), point["output"])
    (error,) = errors(function, point["kind"], [point["inputs"]], [target])
    assert error[point["element"]] <= LIMIT


def orientation(p: Any) -> Any:
    return np.array(quadratic_form(list(p)))


def random_numbers(rng: np.random.Generator) -> Numbers:
    sizes = {"r": 3, "p": 4, "v": 3} | dict.fromkeys(("a", "s", "omega"), 3)
    numbers: Numbers = {"lam": rng.normal(size=1)}
    for body in "ij":
        for name, size in sizes.items():
            end = "_b" if name in {"a", "s", "omega"} else ""
            numbers[f"{name}_{body}{end}"] = rng.normal(size=size)
        numbers[f"p_{body}"] /= np.linalg.norm(numbers[f"p_{body}"])
    return numbers


def turn_together(
    x: Numbers, rng: np.random.Generator, times: float = 1.0, apart: float = 0
) -> None:
    x["omega_i_b"] = times * x["omega_i_b"]
    common = orientation(x["p_i"]) @ x["omega_i_b"] + apart * rng.normal(size=3)
    x["omega_j_b"] = orientation(x["p_j"]).T @ common


def turn_alike(x: Numbers, _: np.random.Generator) -> None:
    x["p_j"], x["omega_j_b"] = x["p_i"], x["omega_i_b"]


def turn_fast(x: Numbers, rng: np.random.Generator) -> None:
    turn_together(x, rng, 1000.0, 1.0)


def arms(x: Numbers) -> tuple[Any, Any]:
    """Arm A s′ of j less that of i, and its rate."""
    a_i, a_j = orientation(x["p_i"]), orientation(x["p_j"])
    rate_i, rate_j = (np.cross(x[f"omega_{body}_b"], x[f"s_{body}_b"]) for body in "ij")
    return a_j @ x["s_j_b"] - a_i @ x["s_i_b"], a_j @ rate_j - a_i @ rate_i


def move_along(x: Numbers, rng: np.random.Generator) -> None:
    arm, rate = arms(x)
    line = x["r_j"] - x["r_i"] + arm
    line /= np.linalg.norm(line)
    across = rng.normal(size=3)
    across -= line * (line @ across)
    x["v_j"] = x["v_i"] - rate + 100 * rng.uniform(0.5, 2) * line + across


def lie_near_x(x: Numbers, rng: np.random.Generator, angle: float) -> None:
    line = np.array([1.0, *(angle * rng.normal(size=2))]) * rng.uniform(0.5, 2)
    x["r_j"] = x["r_i"] + line - arms(x)[0]


def lie_within_a_milliradian(x: Numbers, rng: np.random.Generator) -> None:
    lie_near_x(x, rng, 1e-3)


def lie_within_a_microradian(x: Numbers, rng: np.random.Generator) -> None:
    lie_near_x(x, rng, 1e-6)


STATES: list[tuple[str, str, State]] = [
    *(
        (kind, "gamma", state)
        for kind in ("p1_x", "p1_y", "p1_z", "n1", "angle")
        for state in (turn_together, turn_alike, turn_fast)
        if (kind, state) != ("n1", turn_alike)
    ),
    ("length", "gamma", move_along),
    ("distance", "gamma", move_along),
    ("spring_damper", "l_dot", move_along),
    ("length", "reaction_q", lie_within_a_milliradian),
    ("length", "reaction_q", lie_within_a_microradian),
]


def worst(kind: str, output: str, state: State, count: int, derived: Derived) -> float:
    rng = np.random.default_rng(13)
    states = []
    for _ in range(count):
        numbers = random_numbers(rng) | {"b_i_b": rng.normal(size=3), "length": np.array(1.25)}
        state(numbers, rng)
        states.append(numbers)
    function = function_of(derived(kind), output)
    return float(errors(function, kind, states, TARGETS).max())


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(("kind", "output", "state"), STATES)
def test_few_states_of_machines(kind: str, output: str, state: State, derived: Derived) -> None:
    count = FEWEST if output == "reaction_q" else FEW
    assert worst(kind, output, state, count, derived) <= LIMIT


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize(
    ("kind", "output"),
    [("spring_damper", "force"), ("length", "C_q"), ("length", "gamma"), ("length", "reaction")],
)
def test_where_points_coincide_comes_out_what_is_documented(
    kind: str, output: str, target: Literal["c", "numpy"], derived: Derived
) -> None:
    function = function_of(derived(kind), output)
    kernel = emitted(kind, function.name, target)
    for k in range(30):
        for point in coincident_points(function.inputs, Sha256Random(f"{output} {k}")):
            inputs = [np.reshape(point.inputs[q.name], q.shape) for q in kernel.manifest.inputs]
            got = kernel(*inputs, outputs=(output,))
            assert not np.any(got), point.label


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("target", TARGETS)
def test_points_that_pass_through_each_other_have_no_finite_rate_of_their_rate(
    target: Literal["c", "numpy"],
) -> None:
    kernel = emitted("length", "rates", target)
    inputs = {q.name: np.zeros(q.shape) for q in kernel.manifest.inputs}
    inputs |= {"p_i": np.array([1.0, 0, 0, 0]), "p_j": np.array([1.0, 0, 0, 0])}
    inputs["v_j"] = np.array([0.0, 2.0, 0.0])
    with np.errstate(all="ignore"):
        gamma = kernel(*(inputs[q.name] for q in kernel.manifest.inputs), outputs=("gamma",))
    assert np.ravel(gamma).tolist() == [-np.inf]


def test_states_are_what_their_labels_say(derived: Derived) -> None:
    function = function_of(derived("length"), "gamma")
    for turn in range(3):
        points = {
            p.label: p.inputs for p in motion_points(function.inputs, Sha256Random("s"), turn)
        }
        assert list(points) == [
            *("bodies turn together", "fast common turning"),
            *("points move along their line", "line near an axis"),
        ]
        moved = {label: {k: np.array(v) for k, v in x.items()} for label, x in points.items()}
        for label, times in (("bodies turn together", 1e-15), ("fast common turning", 4e-3)):
            x = moved[label]
            own, other = (orientation(x[f"p_{b}"]) @ x[f"omega_{b}_b"] for b in "ij")
            assert np.linalg.norm(own - other) <= times * np.linalg.norm(own)
        x = moved["points move along their line"]
        arm, rate = arms(x)
        line, along = x["r_j"] - x["r_i"] + arm, x["v_j"] - x["v_i"] + rate
        across = np.array(cross(line, along), dtype=float)
        assert np.linalg.norm(across) < 0.05 * np.linalg.norm(line) * np.linalg.norm(along)
        x = moved["line near an axis"]
        line = np.abs(x["r_j"] - x["r_i"] + arms(x)[0])
        assert 0 < np.sort(line)[1] < 1e-5 * np.max(line)


def test_functions_of_one_body_have_no_such_states(derived: Derived) -> None:
    function = derived("norm").functions[0]
    assert motion_points(function.inputs, Sha256Random("s"), 0) == []
    assert coincident_points(function.inputs, Sha256Random("s")) == []
    assert ordinary(function.inputs, Sha256Random("s"))
