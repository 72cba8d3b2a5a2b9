"""What commands print with ``--json``: one object each, with a format and a schema."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import typer.main
from jsonschema import Draft202012Validator

import kousoku.ledger
from kousoku.cli.answers import ANSWERS, answer_schema
from kousoku.cli.app import app
from kousoku.ledger.proof import Line, Proof
from tests.cli.conftest import validator_of

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenes"
LEVER, PENDULUM = SCENES / "lever_crank.toml", SCENES / "pendulum.toml"
STOPS = ROOT / "tests" / "scenes" / "second_loop_stops.toml"


def with_json() -> list[str]:
    group: Any = typer.main.get_command(app)
    commands = group.commands
    return [
        name
        for name, command in commands.items()
        if any("--json" in option.opts and option.is_flag for option in command.params)
    ]


def test_every_command_with_json_has_a_schema(run: Run) -> None:
    assert sorted(with_json()) == sorted(ANSWERS)
    for command in ANSWERS:
        code, out, err = run("schema", "--json", command)
        assert (code, err) == (0, "")
        assert json.loads(out) == answer_schema(command)
        Draft202012Validator.check_schema(json.loads(out))


def test_a_schema_of_another_command_is_refused(run: Run) -> None:
    code, out, err = run("schema", "--json", "verfy")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and "did you mean 'verify'?" in err


def test_a_schema_goes_into_a_file(run: Run, tmp_path: Path) -> None:
    place = tmp_path / "list.schema.json"
    assert run("schema", "--json", "list", "--out", place)[0] == 0
    assert json.loads(place.read_text(encoding="utf-8")) == answer_schema("list")


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize(
    ("command", "code"),
    [
        (["cache"], 0),
        (["check", LEVER, PENDULUM, "nowhere.toml"], 2),
        (["derive", "n1"], 0),
        (["explain", SCENES / "bricard.toml"], 0),
        (["explain", LEVER], 0),
        (["generate", "n1", "--out", "."], 0),
        (["generate", "n1", "--check"], 0),
        (["generate", "n1", "--check", "--out", "."], 1),
        (["ledger", "7.19"], 0),
        (["list"], 0),
        (["simulate", PENDULUM, "--end", 0.1, "--samples", 2, "--target", "numpy"], 0),
        (["simulate", PENDULUM, "--end", 9, "--most-steps", 3, "--target", "numpy"], 3),
        (["simulate", LEVER, "--end", 0.1, "--target", "numpy"], 0),
        (["solve", LEVER, "--target", "numpy"], 0),
        (["solve", STOPS, "--target", "numpy"], 3),
        (["solve", SCENES / "oldham_coupling.toml", "--target", "numpy"], 0),
        (["verify", "n1", "--target", "numpy"], 0),
    ],
)
def test_what_a_command_prints_is_what_its_schema_says(
    run: Run,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: list[Any],
    code: int,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kousoku.ledger, "prove", lambda _: Proof((Line("tested", "seen"),)))
    found, out, _ = run(*command, "--json")  # which compares it with the schema
    assert found == code
    answer = json.loads(out)
    assert answer["format"] == 1
    validator = validator_of(command[0])
    for changed in ({**answer, "format": 2}, {**answer, "more": 1}, {}, [answer]):
        assert not validator.is_valid(changed)
