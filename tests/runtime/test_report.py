"""What a report says."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from kousoku.model.errors import VerifyError
from kousoku.runtime.report import Report, Row

ROW = Row(
    kernel="sphere",
    output="C_q",
    way="NumPy",
    worst=0.25,
    element=(0, 2),
    point=3,
    label="ordinary",
    inputs=(("r", "[1.0, 2.0, 3.0]"), ("length", "0.5")),
    got=1.5,
    wanted=1.0,
)
WRONG = replace(ROW, way="C", worst=math.inf, got=math.inf, wanted=math.nan)
REPORT = Report("tiny", "somewhere/tiny", (ROW, WRONG), (str(WRONG),), ("not all checked",))


@pytest.mark.parametrize(
    ("worst", "ok"), [(0.0, True), (4.0, True), (4.001, False), (math.inf, False)]
)
def test_the_limit_is_four_units(worst: float, ok: bool) -> None:
    assert replace(ROW, worst=worst).ok is ok


def test_a_wrong_row_says_what_where_got_and_wanted() -> None:
    assert str(replace(ROW, worst=5.5)) == (
        "sphere: C_q[0, 2] by NumPy is 5.500 units off (limit 4): got 1.5, wanted 1.0, "
        "at point 3 (ordinary): r=[1.0, 2.0, 3.0], length=0.5"
    )
    assert "sphere: C by C is inf units off" in str(replace(WRONG, output="C", element=()))
    assert "got inf, wanted no finite number" in str(WRONG)
    assert "1.2e+09 units off" in str(replace(ROW, worst=1.2e9))


def test_a_report_is_a_table_with_what_is_wrong_below() -> None:
    lines = str(REPORT).splitlines()
    assert lines[:4] == [
        "tiny  somewhere/tiny",
        "kernel  output  way    worst [units]  at point",
        "sphere  C_q     NumPy  0.250          3 (ordinary)",
        "sphere  C_q     C      inf            3 (ordinary)",
    ]
    assert lines[4] == "not all checked"
    assert lines[5].startswith("WRONG: sphere: C_q[0, 2] by C is inf units off")


def test_a_good_report_ends_in_its_worst_error() -> None:
    good = Report("tiny", "somewhere", (replace(ROW, worst=0.1), ROW), ())
    assert good.ok
    assert str(good).splitlines()[-1] == (
        "ok: worst 0.250 units of at most 4, sphere C_q by NumPy at point 3 (ordinary)"
    )
    good.check()


def test_check_raises_all_problems() -> None:
    with pytest.raises(VerifyError, match="tiny: one\ntwo"):
        Report("tiny", "", (), ("one", "two")).check()


def test_a_report_without_rows_is_readable() -> None:
    empty = Report("tiny", "somewhere", (), ("nothing there",))
    assert empty.worst is None
    assert str(empty).splitlines()[-1] == "WRONG: nothing there"


def test_a_report_is_strict_json() -> None:
    data = json.loads(json.dumps(REPORT.to_dict(), allow_nan=False))
    assert (data["package"], data["ok"], data["limit"]) == ("tiny", False, 4.0)
    assert data["rows"][0]["inputs"] == {"r": "[1.0, 2.0, 3.0]", "length": "0.5"}
    assert data["rows"][0]["element"] == [0, 2]
    assert (data["rows"][1]["worst"], data["rows"][1]["wanted"]) == ("inf", "nan")
    assert [row["ok"] for row in data["rows"]] == [True, False]
