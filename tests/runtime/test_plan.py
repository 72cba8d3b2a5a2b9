"""The extension that calls kernels: built where it can be, missed nowhere."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime import load, plan

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain

pytestmark = pytest.mark.usefixtures("warm_cache")
SOURCE = Path(plan.__file__).parent / "_call.c"


@pytest.fixture
def plan_type(compiler: Toolchain) -> Any:
    """Type of the extension."""
    built = plan.plan_type(compiler)
    if built is None:
        pytest.skip("no headers of Python and NumPy")
    return built


def test_the_extension_is_clean_under_warnings(
    compiler: Toolchain, plan_type: Any, tmp_path: Path
) -> None:
    headers = [f"-isystem{sysconfig.get_path('include')}", f"-isystem{np.get_include()}"]
    warnings = ["-std=c11", "-Wall", "-Wextra", "-Wshadow", "-Werror"]
    run = subprocess.run(
        [*compiler.command, *warnings, *headers, "-c", str(SOURCE), "-o", str(tmp_path / "o")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, (run.stderr, plan_type)


def test_a_plan_takes_clean_arguments_and_nothing_else(tiny: Path, plan_type: Any) -> None:
    library = load(tiny, target="c")
    addresses = [
        ctypes.cast(library.function(f"kousoku_tiny_sphere_{way}"), ctypes.c_void_p).value
        for way in ("call", "batch")
    ]
    call = plan_type(*addresses, ((3,), ()), ((1,), (1, 4)))
    r = np.array([1.0, 2.0, 3.0])
    assert call((r, 2.0), None, 1)[0] == [28.0]
    assert call((r, 2.0), None, 0) == ()
    for inputs in [(r,), (r, 2), (r, None), ([1, 2, 3], 2.0), (r[::-1], 2.0), (r[None, None], "")]:
        assert call(inputs, None, 3) is None
    for out in [1, (r,), (r, r), (r[:1], None), [None, None]]:
        assert call((r, 2.0), out, 3) is None
    assert call((r[None, None, None, None, None], 2.0), None, 3) is None


def test_a_plan_refuses_nonsense_with_an_exception(plan_type: Any) -> None:
    for arguments in [
        (),
        (1, 2, 3, 4),
        ("a", "b", (), ()),
        (1, 2, ((1, 2, 3, 4, 5),), ()),
        (1, 2, (("a",),), ()),
        (1, 2, (3,), ()),
        (1, 2, ((1,),) * 25, ()),
        (1, 2, (), ((1,),) * 25),
    ]:
        with pytest.raises((TypeError, ValueError)):
            plan_type(*arguments)
    call = plan_type(1, 2, ((3,),), ((1,),))
    calls: list[tuple[Any, ...]] = [(), (1, 2, 3), ((), None), ((np.ones(3),), None, "mask")]
    for wrong in calls:
        with pytest.raises(TypeError):
            call(*wrong)


def test_calls_keep_no_references(tiny: Path, plan_type: Any) -> None:
    kernel = load(tiny, target="c").sphere
    assert kernel._fast is not None, plan_type
    r, length, out = np.ones(3), np.array(2.0), (np.empty(1), np.empty((1, 4)))
    held = (r, length, out, *out, None)

    def held_more() -> list[int]:
        before = [sys.getrefcount(thing) for thing in held]
        for _ in range(1000):
            for given in (out, (out[0], None), (None, None), None):
                kernel(r, length, out=given)
            with pytest.raises(ValueError, match="shape"):
                kernel(r[:2], length, out=out)
        return [abs(sys.getrefcount(thing) - b) for thing, b in zip(held, before, strict=True)]

    # Others hold None, too, and let it go when garbage is collected: a leak holds it every time.
    rounds = [held_more() for _ in range(3)]
    assert all(min(more) < 100 for more in zip(*rounds, strict=True))


@pytest.mark.release
def test_strange_arguments_are_harmless_under_a_sanitizer(
    compiler: Toolchain, plan_type: Any, tmp_path: Path
) -> None:
    flags = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
    (tmp_path / "x.c").write_text("int x(int a) { return a + 1; }\n", encoding="utf-8")
    command = [*compiler.command, *flags, "-shared", "-fPIC", "x.c", "-o", "x"]
    if subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode:
        pytest.skip(f"no sanitizer for {plan_type}")
    tests = [
        str(Path(__file__).with_name(name)) for name in ("test_arguments.py", "test_kernel.py")
    ]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-k", "extension", *tests],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "KOUSOKU_CFLAGS": " ".join(flags)},
    )
    assert run.returncode == 0, run.stdout


@pytest.mark.parametrize("missing", ["Python.h", "numpy/arrayobject.h"])
def test_without_headers_ctypes_does_the_calls(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, missing: str, tmp_path: Path, compiler: Toolchain
) -> None:
    if missing == "Python.h":
        monkeypatch.setattr(sysconfig, "get_path", lambda _: str(tmp_path))
    else:
        monkeypatch.setattr(np, "get_include", lambda: str(tmp_path))
    library = load(tiny, target="c")
    assert plan.plan_type(compiler) is None
    assert library.sphere._fast is None
    assert library.sphere([1, 2, 3], 2)[0] == [28.0]


def test_an_extension_that_does_not_compile_is_done_without(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, compiler: Toolchain
) -> None:
    (tmp_path / "numpy").mkdir()
    for name in ("Python.h", "numpy/arrayobject.h"):
        (tmp_path / name).write_text("#error not today\n", encoding="utf-8")
    monkeypatch.setattr(sysconfig, "get_path", lambda _: str(tmp_path))
    monkeypatch.setattr(np, "get_include", lambda: str(tmp_path))
    library = load(tiny, target="c")
    assert library.sphere._fast is None, compiler
    assert library.sphere([1, 2, 3], 2)[0] == [28.0]


def test_another_version_of_numpy_gets_another_extension(
    monkeypatch: pytest.MonkeyPatch, plan_type: Any, compiler: Toolchain
) -> None:
    headers = plan._headers()
    assert headers is not None
    first = plan._build(compiler, headers)
    monkeypatch.setattr(np, "__version__", "99.0")
    assert plan._build(compiler, headers) != first, plan_type
