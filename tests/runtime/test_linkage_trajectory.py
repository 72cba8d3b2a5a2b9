"""Trajectories as columns and files."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

import kousoku as ks
from kousoku.model.errors import SolveError

if TYPE_CHECKING:
    from kousoku.runtime.linkage import Trajectory

pytestmark = pytest.mark.usefixtures("compiler")

PISTON = Path(__file__).parents[2] / "scenes" / "piston_crank.toml"
PISTON_COLUMNS = ["alpha"] + [
    f"{node}.{column}"
    for node in ("O1", "O2", "O3")
    for column in ("x", "y", "vx", "vy", "ax", "ay")
]


@pytest.fixture(scope="module")
def motion() -> Trajectory:
    return cast("Trajectory", ks.load(PISTON).solve())


def test_columns_stand_in_the_order_of_the_scene(motion: Trajectory) -> None:
    assert list(motion.columns()) == PISTON_COLUMNS


def test_single_input_is_called_alpha_whatever_its_name(motion: Trajectory) -> None:
    renamed = replace(motion, inputs={"crank_angle": motion.alpha})
    assert list(renamed.columns())[:2] == ["alpha", "O1.x"]


def test_several_inputs_are_called_by_their_names(motion: Trajectory) -> None:
    both = replace(motion, inputs={"left": motion.alpha, "right": -motion.alpha})
    assert list(both.columns())[:3] == ["left", "right", "O1.x"]
    assert both.alpha.shape == (61, 2)


def test_what_was_not_wanted_has_no_column(motion: Trajectory) -> None:
    bare = replace(motion, velocities={}, accelerations={})
    assert list(bare.columns()) == ["alpha", "O1.x", "O1.y", "O2.x", "O2.y", "O3.x", "O3.y"]


def test_csv_holds_one_line_a_row_with_all_digits(motion: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / "motion.csv"
    motion.save(path)
    with path.open(newline="", encoding="ascii") as file:
        head, *rows = csv.reader(file)
    assert head == PISTON_COLUMNS
    assert len(rows) == 61
    for column, name in zip(zip(*rows, strict=True), head, strict=True):
        np.testing.assert_array_equal([float(x) for x in column], motion.columns()[name])


def test_npz_holds_the_same_columns(motion: Trajectory, tmp_path: Path) -> None:
    motion.save(tmp_path / "motion.npz")
    with np.load(tmp_path / "motion.npz") as data:
        assert sorted(name for name in data if "kousoku" not in name) == sorted(PISTON_COLUMNS)
        for name in PISTON_COLUMNS:
            np.testing.assert_array_equal(data[name], motion.columns()[name])


def test_unknown_suffix_writes_nothing(motion: Trajectory, tmp_path: Path) -> None:
    with pytest.raises(SolveError, match=r"motion\.xlsx: .*\.csv, \.npz or \.parquet"):
        motion.save(tmp_path / "motion.xlsx")
    assert not list(tmp_path.iterdir())


def test_failed_writing_keeps_what_is_there(motion: Trajectory, tmp_path: Path) -> None:
    path = tmp_path / "file" / "motion.csv"
    path.parent.write_text("not a folder")
    with pytest.raises(SolveError, match="there is no folder"):
        motion.save(path)
    assert path.parent.read_text() == "not a folder"
    folder = tmp_path / "folder.csv"
    (folder / "motion").mkdir(parents=True)
    with pytest.raises(SolveError, match="cannot be written"):
        motion.save(folder)
    assert sorted(tmp_path.rglob("*")) == [path.parent, folder, folder / "motion"]


def test_summary_is_ready_for_json(motion: Trajectory) -> None:
    summary = json.loads(json.dumps(motion.summary()))
    assert summary["method"] == "newton"
    assert summary["divisions"] == 60
    assert summary["rows"] == 61
    assert summary["iterations"]["total"] == int(motion.iterations.sum())
    assert summary["iterations"]["min"] <= summary["iterations"]["max"] <= 4
    assert 0 < summary["residual_max"] <= 1e-13


def test_summary_of_no_rows_is_all_zero(motion: Trajectory) -> None:
    nothing = replace(motion, iterations=motion.iterations[:0], residual=motion.residual[:0])
    assert nothing.summary()["iterations"] == {"min": 0, "max": 0, "total": 0}
    assert nothing.summary()["residual_max"] == 0.0
