"""The frozen kernels that are shipped, interpreted against the references beside them."""

import json
import math
from importlib import resources
from typing import Any

import numpy as np
import pytest

from kousoku.codegen.generate import package_names
from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.known_errors import known_errors
from kousoku.model.files.compressed import content
from kousoku.model.files.manifest import REFERENCE_FILE
from kousoku.model.operations.interpret import ARRAY, evaluate
from kousoku.model.operations.kernel import Kernel

LIMIT = 4
KINDS = resources.files("kousoku.generated").joinpath("kinds")


def read(name: str) -> Any:
    """References of a package."""
    data = KINDS.joinpath(name, REFERENCE_FILE).read_bytes()
    return json.loads(content(REFERENCE_FILE, data))


def errors(kernel: Kernel, point: Any) -> list[float]:
    """Errors of all elements at a point, as shares of what they may be."""
    inputs = {name: [np.float64(x) for x in xs] for name, xs in point["inputs"].items()}
    with np.errstate(all="ignore"):
        got = evaluate(kernel, inputs, ARRAY)
    found = []
    for k, output in enumerate(kernel.outputs):
        columns = point["outputs"][output.name]
        limit = point.get("limits", {}).get(output.name, LIMIT)
        values = [float(got[output.name][element]) for element in kernel.nonzero(k)]
        for value, high, low, unit in zip(
            values, columns["high"], columns["low"], columns["unit"], strict=True
        ):
            if high is None:
                found.append(math.inf if math.isfinite(value) else 0.0)
            else:
                error = abs((value - high) - low) / unit / limit
                found.append(error if math.isfinite(error) else math.inf)
    return found


@pytest.mark.parametrize("name", package_names())
def test_every_kernel_is_within_the_limit_at_every_point(name: str) -> None:
    references = read(name)
    package = load_frozen(name)
    assert [kernel["name"] for kernel in references["kernels"]] == [k.name for k in package.kernels]
    for kernel, referred in zip(package.kernels, references["kernels"], strict=True):
        assert len(referred["points"]) >= 10
        for point in referred["points"]:
            assert max(errors(kernel, point), default=0.0) <= 1, (kernel.name, point["label"])


#: A kernel of theirs has nothing but arrays under a quotient, and Euler parameters.
ALL_CURVED = ("norm", "rotation", "angle", "length")


@pytest.mark.parametrize("name", package_names())
def test_every_kernel_meets_a_number_that_is_not_one(name: str) -> None:
    references = read(name)
    for kernel in references["kernels"]:
        labels = [point["label"] for point in kernel["points"]]
        assert any(label.endswith(" is nan") for label in labels)
        assert any("subnormal" in label for label in labels) or name in ALL_CURVED


@pytest.mark.parametrize("name", package_names())
def test_what_is_known_to_be_off_is_off_by_that_much(name: str) -> None:
    package = load_frozen(name)
    for kernel, referred in zip(package.kernels, read(name)["kernels"], strict=True):
        points = [point for point in referred["points"] if "limits" in point]
        assert len(points) == len(known_errors(package, kernel.name))
        for point in points:
            assert min(point["limits"].values()) > LIMIT
            assert 0.99 < max(errors(kernel, point)) <= 1, (kernel.name, point["limits"])
