"""JSON with short things on a line."""

import json

import pytest

from kousoku.model.files.jsontext import WIDTH, to_text

VALUE = {
    "short": [1, 2, 3],
    "long": list(range(100)),
    "pairs": [["mul", k, k + 1] for k in range(40)],
    "deep": [{"name": "x" * 30, "numbers": [1e-300, 0.1, -5.5] * 20}] * 2,
    "empty": [],
    "nothing": {},
    "sentence": "x" * 200,
    "letters": "ω′ · λ",
}


def test_it_reads_back_as_what_was_written() -> None:
    assert json.loads(to_text(VALUE)) == VALUE


def test_lines_are_short_unless_one_string_is_long() -> None:
    lines = to_text(VALUE).splitlines()
    assert max(len(line) for line in lines if "sentence" not in line) <= WIDTH
    assert not any(line != line.rstrip() for line in lines)


def test_a_long_list_is_wrapped_and_not_one_element_a_line() -> None:
    assert len(to_text(list(range(100))).splitlines()) < 10


def test_letters_stay_letters() -> None:
    assert "ω′ · λ" in to_text(VALUE)


def test_what_is_not_finite_is_refused() -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        to_text([float("nan")])
