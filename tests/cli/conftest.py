"""Run the command line in this process, and in a fresh one."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import pytest
from jsonschema import Draft202012Validator

from kousoku.cli import main
from kousoku.cli.answers import ANSWERS, answer_schema

if TYPE_CHECKING:
    from collections.abc import Callable


class Result(NamedTuple):
    """Exit code, stdout and stderr of a command."""

    code: int
    out: str
    err: str


@cache
def validator_of(command: str) -> Draft202012Validator:
    """Validator of the JSON of a command; keys that its schema has not are refused."""
    schema = answer_schema(command)
    for part in schema["$defs"].values():
        part["additionalProperties"] = False
    return Draft202012Validator(schema)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Callable[..., Result]:
    """Run a command in this process and return its exit code and what it printed.

    What it prints with ``--json`` is what its schema says, and nothing else.
    """

    def call(*arguments: object) -> Result:
        with pytest.raises(SystemExit) as stop:
            main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        code = stop.value.code
        command, *options = map(str, arguments)
        if command in ANSWERS and "--json" in options and captured.out:
            validator_of(command).validate(json.loads(captured.out))
        return Result(code if isinstance(code, int) else 0, captured.out, captured.err)

    return call


@pytest.fixture
def loaded_by() -> Callable[..., set[str]]:
    """Modules that a command loads in a fresh process without a compiler."""
    code = (
        "import sys, json\nfrom kousoku.cli import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit as stop: assert stop.code in (0, None), stop.code\n"
        "print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    )

    def call(*arguments: object) -> set[str]:
        done = subprocess.run(
            [sys.executable, "-c", code, *map(str, arguments)],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "KOUSOKU_CC": "none"},
        )
        return set(json.loads(done.stderr.splitlines()[-1]))

    return call
