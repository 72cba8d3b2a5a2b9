"""The layout of the state: one record for C, for Python and for those who read a run."""

from __future__ import annotations

import math
import re
import subprocess
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.model.reading.read import read_scene
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.state import (
    State,
    fields,
    fields_as_data,
    fields_of,
    size_of_state,
)

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.toolchain import Toolchain

SIZES = {
    "NY": 5,
    "DENSE": 7,
    "N_PARAMETERS": 0,
    "MOMENTA": 3,
    "NCHECK": 2,
    "N_CROSSINGS": 2,
    "EVENTS": 1,
    "RANGED": 4,
}


def test_fields_follow_each_other_without_gaps_numbers_first() -> None:
    found = fields(SIZES)
    place = 0
    for field in found:
        assert field.place == place
        place += math.prod(field.room)
    assert place == size_of_state(SIZES)
    is_array = [bool(field.shape) for field in found]
    assert is_array == sorted(is_array)


def test_every_field_can_be_read_and_written_by_its_name() -> None:
    numbers = np.zeros(size_of_state(SIZES))
    state = State(numbers, SIZES)
    for k, field in enumerate(fields(SIZES), 1):
        if field.shape:
            getattr(state, field.name)[...] = k
        else:
            setattr(state, field.name, k)
        view = field.view(numbers)
        assert view.shape == field.shape
        assert (view == k).all()
        assert np.count_nonzero(numbers == k) == math.prod(field.shape)


def test_what_motion_json_tells_are_the_fields() -> None:
    assert fields_of(fields_as_data(fields(SIZES))) == fields(SIZES)


@pytest.mark.parametrize("name", ["pendulum", "engine"])
def test_the_struct_in_c_has_its_fields_where_the_record_says(
    compiler: Toolchain, bodies_folder: Callable[..., Path], tmp_path: Path, name: str
) -> None:
    folder = bodies_folder(read_scene(f"scenes/{name}.toml"), ("reactions", "energies"))
    layout = load_dynamics(folder).state
    struct = f"kousoku_{name}_state"
    prints = "".join(
        f'    printf("%zu %zu\\n", offsetof({struct}, {field}), sizeof s.{field});\n'
        for field in layout
    )
    (tmp_path / "main.c").write_text(
        f'#include <stdio.h>\n#include "solver.h"\nint main(void)\n{{\n'
        f"    {struct} s;\n{prints}    return 0;\n}}\n",
        encoding="utf-8",
    )
    command = (*compiler.command, "-I", str(folder), "main.c", "-o", "main")
    subprocess.run(command, cwd=tmp_path, check=True)
    text = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    wanted = [(8 * one.place, 8 * math.prod(one.room)) for one in layout.values()]
    assert [tuple(map(int, line.split())) for line in text.splitlines()] == wanted
    header = (folder / "solver.h").read_text(encoding="utf-8")
    assert all(
        re.search(rf"\b{field.name}\b.*{re.escape(field.meaning)}", header)
        for field in layout.values()
    )
