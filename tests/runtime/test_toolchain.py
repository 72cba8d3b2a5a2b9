"""Finding a compiler and saying which machine it builds for."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.model.errors import CompilerError, NoCompilerError
from kousoku.runtime.toolchain import FLAGS, LARGE_FLAGS, Toolchain, find_toolchain

if TYPE_CHECKING:
    from collections.abc import Callable

EMPTY = Toolchain(("cc",), "cc 1", "x86_64", "features", FLAGS)


@pytest.mark.usefixtures("compiler")
def test_the_compiler_of_this_machine_is_identified() -> None:
    found = find_toolchain()
    assert Path(found.command[0]).is_absolute()
    assert found.name
    assert found.flags[: len(FLAGS)] == FLAGS
    assert len(found.features) == 64


def test_kernels_are_built_without_contraction_and_without_fast_math() -> None:
    assert "-ffp-contract=off" in FLAGS
    assert not {"-ffast-math", "-Ofast", "-funsafe-math-optimizations"} & set(FLAGS)


@pytest.mark.parametrize("value", ["none", "None", " none "])
def test_none_switches_the_compiler_off(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    monkeypatch.setenv("KOUSOKU_CC", value)
    with pytest.raises(NoCompilerError, match="KOUSOKU_CC=none"):
        find_toolchain()


def test_a_machine_without_compiler_says_what_was_tried(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("KOUSOKU_CC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "ziglang", None)
    with pytest.raises(NoCompilerError, match=r"tried cc, gcc and clang.*kousoku\[compiler\]"):
        find_toolchain()


def test_a_chosen_compiler_that_is_not_there_is_an_error_and_not_a_fallback(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "/nowhere/cc")
    with pytest.raises(CompilerError, match="'/nowhere/cc': no such command") as raised:
        find_toolchain()
    assert not isinstance(raised.value, NoCompilerError)


def test_a_chosen_compiler_that_does_not_work_shows_its_output(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", wrapper("echo first; echo second >&2; exit 3"))
    with pytest.raises(CompilerError, match="does not work here; it said:\nfirst\nsecond"):
        find_toolchain()


def test_a_chosen_compiler_that_says_nothing_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", wrapper("exit 1"))
    with pytest.raises(CompilerError) as raised:
        find_toolchain()
    assert "does not work here; it said nothing (KOUSOKU_CC chooses another" in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_broken_compiler_is_passed_over_for_one_that_works(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    broken = wrapper("exit 1")
    monkeypatch.delenv("KOUSOKU_CC", raising=False)
    monkeypatch.setenv("CC", broken)
    assert find_toolchain().command[0] != broken


def test_a_chosen_compiler_may_have_arguments_and_blanks_in_its_path(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[..., str]
) -> None:
    path = wrapper("", "my cc")
    monkeypatch.setenv("KOUSOKU_CC", path)
    assert find_toolchain().command == (path,)
    monkeypatch.setenv("KOUSOKU_CC", f"'{path}' -DX=1")
    assert find_toolchain().command == (path, "-DX=1")


@pytest.mark.usefixtures("compiler")
def test_flags_of_the_user_come_last_and_count(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = find_toolchain()
    monkeypatch.setenv("KOUSOKU_CFLAGS", "-DA='b c' -O1")
    changed = find_toolchain()
    assert changed.flags[-2:] == ("-DA=b c", "-O1")
    assert changed.fingerprint != usual.fingerprint


@pytest.mark.usefixtures("shipped_flags")
def test_a_flag_that_the_compiler_refuses_is_named(
    monkeypatch: pytest.MonkeyPatch, compiler: Toolchain
) -> None:
    monkeypatch.setenv("KOUSOKU_CFLAGS", "-fno-such-flag")
    with pytest.raises(CompilerError, match="no-such-flag") as raised:
        find_toolchain()
    assert not isinstance(raised.value, NoCompilerError), compiler


@pytest.mark.parametrize("field", ["command", "version", "machine", "features", "flags"])
def test_all_that_decides_the_machine_code_is_in_the_fingerprint(field: str) -> None:
    values = {name: getattr(EMPTY, name) for name in EMPTY.__slots__}
    values[field] = (*FLAGS, "-O1") if field == "flags" else "other"
    assert Toolchain(**values).fingerprint != EMPTY.fingerprint


def test_other_processor_features_give_another_target(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[..., str]
) -> None:
    fake = 'for a in "$@"; do [ "$a" = -dM ] && echo "#define __OTHER_FEATURE__ 1"; done'
    found = []
    for code in ("", fake):
        monkeypatch.setenv("KOUSOKU_CC", wrapper(code, f"cc{len(code)}"))
        found.append(find_toolchain())
    assert found[0].version == found[1].version
    assert found[0].features != found[1].features
    assert found[0].fingerprint != found[1].fingerprint


@pytest.mark.usefixtures("shipped_flags")
def test_native_flags_that_a_compiler_refuses_are_left_out(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    refuse = (
        'for a in "$@"; do case "$a" in -march=*|-mcpu=*) echo "bad $a" >&2; exit 1;; esac; done'
    )
    monkeypatch.setenv("KOUSOKU_CC", wrapper(refuse))
    assert find_toolchain().flags == FLAGS


def test_the_packaged_compiler_is_found_where_nothing_else_is(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("ziglang")
    monkeypatch.delenv("KOUSOKU_CC", raising=False)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_toolchain().command[1:] == ("-m", "ziglang", "cc")
    monkeypatch.setenv("KOUSOKU_CC", "zig cc")
    assert find_toolchain().command == (sys.executable, "-m", "ziglang", "cc")


def test_messages_of_the_compiler_are_in_english(
    monkeypatch: pytest.MonkeyPatch, wrapper: Callable[[str], str]
) -> None:
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    monkeypatch.setenv("KOUSOKU_CC", wrapper('echo "LC_ALL is $LC_ALL"; exit 1'))
    with pytest.raises(CompilerError, match=r"LC_ALL is C\n"):
        find_toolchain()


@pytest.mark.usefixtures("compiler")
def test_large_sources_are_compiled_with_vector_loops_and_little_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("KOUSOKU_CFLAGS", "-O3 -DMINE")
    toolchain = find_toolchain()
    small = toolchain.compile_command(["a.c"], "a.so")
    *parallel, large = toolchain.compile_commands(["a.c"], "a.so", is_large=True)

    place = small.index("-O3")
    assert [[*one].count("-flto=2") for one in parallel] in ([], [1])
    assert large == (*small[:place], *LARGE_FLAGS, *small[place + 1 :])
    assert large.index("-O3") > large.index("-O1")  # that of the user comes last
