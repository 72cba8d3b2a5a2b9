"""The command line: what it prints, its exit codes, and what it imports."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

import kousoku as ks
from kousoku import __version__
from kousoku.symbolic import KINDS

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]


def test_version_is_printed(run: Run) -> None:
    assert run("--version") == (0, f"kousoku {__version__}\n", "")


@pytest.mark.parametrize(
    "command", ["derive", "generate", "verify", "solve", "ledger", "list", "new", "check", "schema"]
)
def test_every_command_explains_itself(run: Run, command: str) -> None:
    code, out, _ = run(command, "--help")
    assert code == 0
    assert "Usage" in out and len(out.splitlines()) > 5


def test_an_unknown_command_is_bad_input(run: Run) -> None:
    code, out, err = run("simulat")
    assert (code, out) == (2, "")
    assert "simulat" in err


def test_the_list_names_every_kind(run: Run) -> None:
    code, out, _ = run("list", "--json")
    listed = {row["name"]: row for row in json.loads(out)["packages"]}
    assert code == 0
    for name, kind in KINDS.items():
        assert listed[name]["kind"] == name
        assert len(listed[name]["kernels"]) >= len(kind.packages)


def test_the_list_is_a_table_for_people(run: Run) -> None:
    code, out, _ = run("list")
    assert code == 0
    assert any("constraint_z" in line and "inline" in line for line in out.splitlines())


def test_what_a_scene_may_have_is_listed(run: Run) -> None:
    code, out, _ = run("list", "joints")
    assert code == 0 and out == f"{ks.catalog()['joints']!r}\n" and "a turn about an axis" in out
    code, out, _ = run("list", "joints", "hinge")
    assert code == 0 and out == f"{ks.catalog()['joints']['revolute']!r}\n"
    code, out, _ = run("list", "forces", "--json")
    assert [one["name"] for one in json.loads(out)["entries"]] == [*ks.catalog()["forces"]]
    code, _, err = run("list", "joints", "hing")
    assert code == 2 and "did you mean 'hinge'" in err and err.count("\n") == 1


def test_no_line_of_the_help_is_cut_off(run: Run) -> None:
    code, out, _ = run("--help")
    assert (
        code == 0
        and "simulate  Move a mechanism in time.\n" in out
        and "..." not in out.partition("Commands:")[2]
    )


@pytest.mark.parametrize("name", ["n2", "INPLANE", "dot-2"])
def test_derive_prints_each_step_with_its_equation(run: Run, name: str) -> None:
    code, out, err = run("derive", name)
    assert (code, err) == (0, "")
    assert "7.16" in out and "8.12" in out


def test_derive_as_json_holds_the_steps_and_the_functions(run: Run) -> None:
    answer = json.loads(run("derive", "n1", "--json")[1])
    assert answer["kind"] == "n1"
    assert {"left", "right", "latex", "rule", "equation"} <= set(answer["steps"][0])
    assert [function["name"] for function in answer["functions"]][:1] == ["constraint"]


def test_derive_as_latex_is_an_environment(run: Run) -> None:
    out = run("derive", "n1", "--latex")[1]
    assert out.startswith("\\begin{align*}") and out.rstrip().endswith("\\end{align*}")


def test_an_unknown_kind_is_one_message_that_lists_the_known_ones(
    run: Run,
) -> None:
    code, out, err = run("derive", "n9")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and "n9" in err and "n2" in err
    assert "did you mean 'distance'?" in run("derive", "distanc")[2]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("simulate", "x.toml", "--end", "1,5"), "'--end': '1,5' is no number."),
        (("simulate", "x.toml", "--samples", "2.5"), "'--samples': '2.5' is no whole number."),
        (("simulate", "x.toml", "--target", "fortran"), "'--target': 'fortran' is not one of"),
        (("simulate", "x.toml", "--output", "energy"), "Did you mean 'energies'?"),
        (("new", "pendlum"), "Did you mean 'pendulum'?"),
        (("solve", "x.toml", "--divisions", "0"), "'--divisions': '0'; wanted at least 1."),
    ],
)
def test_an_argument_that_is_refused_is_named_and_so_is_what_is_wanted(
    run: Run, arguments: tuple[str, ...], told: str
) -> None:
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert told in err
    assert "Value error" not in err and "Input should" not in err


@pytest.mark.parametrize("arguments", [("--version",), ("--help",), ("list",)])
def test_commands_start_without_the_heavy_libraries(
    loaded_by: Callable[..., set[str]], arguments: tuple[str, ...]
) -> None:
    heavy = {"sympy", "mpmath", "matplotlib", "jinja2", "numpy"}
    assert not loaded_by(*arguments) & heavy
