"""Many processes, killed processes, and file systems that are full or read-only."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.runtime import load

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.toolchain import Toolchain

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes of POSIX")

LOAD_AND_CALL = """
import sys
from kousoku.runtime import load
library = load(sys.argv[1])
print(library.target, library.sphere([1, 2, 3], 2)[0])
"""

LOAD_AND_TRUNCATE = """
import os, sys
from kousoku.runtime import load
os.truncate(load(sys.argv[1]).path, 100)
"""

#: One parent that has imported everything forks at once; every child finds the compiler itself.
FORK = """
import json, os, sys
import kousoku.runtime.build, kousoku.runtime.plan, kousoku.runtime.toolchain
from kousoku.runtime import load
read, write = os.pipe()
children = []
for _ in range(int(sys.argv[2])):
    child = os.fork()
    if not child:
        os.close(write)
        os.read(read, 1)  # until the parent lets all of them go
        library = load(sys.argv[1], target="c")
        right = library.sphere([1, 2, 3], 2)[0][0] == 28.0 and not library.damage
        os._exit(0 if right else 1)
    children.append(child)
os.close(write)
print(json.dumps([os.waitpid(child, 0)[1] for child in children]))
"""

#: A compiler that notes when it first builds, writes half a library, and waits until it may go on.
#: The words of the shell alone: a PATH need not have others.
SLOW = """
next=
for a in "$@"; do
  [ "$next" ] && [ ! -e {marker} ] && {{
    echo half > "$a"; : > {marker}; until [ -e {marker}.go ]; do :; done
  }}
  next=
  [ "$a" = -o ] && next=1
done
"""


def python(code: str, *arguments: object, **environment: str) -> subprocess.Popen[str]:
    """Start a fresh interpreter in a session of its own."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
        start_new_session=True,
    )


def test_fifty_processes_build_the_same_kernel_at_once(
    tiny: Path, cache: Path, wrapper: Callable[[str], str], tmp_path: Path
) -> None:
    log = tmp_path / "log"
    log_builds = f'for a in "$@"; do [ "$a" = -o ] && echo "$a" >> {log}; done'
    run = python(FORK, tiny, 50, KOUSOKU_CC=wrapper(log_builds))
    out, err = run.communicate(timeout=300)
    assert json.loads(out.splitlines()[-1]) == [0] * 50, err
    # One library of the kernel and one of the caller; the lock spares all others the work.
    assert len(log.read_text(encoding="utf-8").splitlines()) == 2
    left = {path.name.split("-")[0] for path in (cache / "lib").iterdir() if path.is_dir()}
    assert left == {"tiny", "kousoku_call"}


def test_where_files_cannot_be_locked_all_build_and_one_wins(
    tiny: Path, cache: Path, compiler: object
) -> None:
    no_locks = (
        "import errno, fcntl\n"
        "def refuse(*_): raise OSError(errno.ENOLCK, 'no locks')\n"
        "fcntl.flock = refuse\n"
    )
    run = python(no_locks + FORK, tiny, 4)
    out, err = run.communicate(timeout=100)
    assert json.loads(out.splitlines()[-1]) == [0] * 4, (err, compiler)
    assert len([path for path in (cache / "lib").iterdir() if path.is_dir()]) == 2


def test_a_library_that_is_truncated_while_it_is_open_harms_nobody(
    tiny: Path, cache: Path, compiler: Toolchain
) -> None:
    if "ziglang" in compiler.command:
        pytest.skip("zig links start-up code into every library")
    run = python(LOAD_AND_TRUNCATE + LOAD_AND_CALL, tiny)
    out, err = run.communicate(timeout=60)
    assert (out, run.returncode) == ("c [28.]\n", 0), (err, cache)


@pytest.mark.parametrize("whole_group", [True, False])
def test_a_process_killed_half_way_leaves_nothing_that_is_loaded(
    tiny: Path,
    cache: Path,
    wrapper: Callable[[str], str],
    tmp_path: Path,
    whole_group: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    marker = tmp_path / "compiling"
    monkeypatch.setenv("KOUSOKU_CC", wrapper(SLOW.format(marker=marker)))
    run = python(LOAD_AND_CALL, tiny)
    try:
        wait_for(marker)
        if whole_group:
            os.killpg(run.pid, signal.SIGKILL)
        else:
            run.kill()  # the compiler lives on
        run.wait()
        halves = [path for path in (cache / "lib").rglob("*") if path.suffix in {".so", ".dylib"}]
        assert halves, "the test is meant to leave half a library behind"
        # The lock of the dead process holds nobody up, and its half is not looked at.
        library = load(tiny)
        assert library.target == "c"
        assert library.damage == ""
        assert library.path not in halves
        assert library.sphere([1, 2, 3], 2)[0] == [28.0]
    finally:
        stop(run)


def test_a_process_waits_for_the_one_that_builds(
    tiny: Path, cache: Path, wrapper: Callable[[str], str], tmp_path: Path
) -> None:
    marker = tmp_path / "compiling"
    compiler = wrapper(SLOW.format(marker=marker))
    first = python(LOAD_AND_CALL, tiny, KOUSOKU_CC=compiler)
    second = None
    try:
        wait_for(marker)
        second = python(LOAD_AND_CALL, tiny, KOUSOKU_CC=compiler)
        time.sleep(0.5)
        assert second.poll() is None
        assert len(list((cache / "lib").glob(".build-*"))) == 1
        Path(f"{marker}.go").touch()
        assert second.communicate(timeout=60)[0] == "c [28.]\n"
        assert first.communicate(timeout=60)[0] == "c [28.]\n"
    finally:
        for run in filter(None, (first, second)):
            stop(run)


@pytest.mark.parametrize(
    ("prepare", "reason"),
    [
        ("mount -t tmpfs -o size=16k tmpfs {cache}", "No space left on device"),
        ("mount -t tmpfs tmpfs {cache} && mount -o remount,ro {cache}", "Read-only file system"),
        ("mount -t tmpfs -o size=8k,nr_inodes=2 tmpfs {cache}", "No space left on device"),
    ],
)
def test_where_the_cache_cannot_be_used_a_temporary_folder_is_and_one_message_says_so(
    tiny: Path, cache: Path, compiler: object, prepare: str, reason: str
) -> None:
    out, err = _with_a_cache_on(prepare, cache, tiny)
    assert out == "c [28.]\n", (err, compiler)
    *told, rest = err.split(" or set KOUSOKU_CACHE to a folder that can be written\n")
    assert rest == ""
    assert 1 <= len(set(told)) == len(told) <= 2  # a compiler that cannot write has its own words
    for message in told:
        assert message.startswith(f"cannot write the cache {cache}")
        assert reason in message
        assert "; compiled in a temporary folder, for this process alone; " in message


def test_a_cache_that_libraries_cannot_be_loaded_from_gives_one_message_and_the_numpy_kernels(
    tiny: Path, cache: Path, compiler: object
) -> None:
    out, err = _with_a_cache_on("mount -t tmpfs -o noexec tmpfs {cache}", cache, tiny)
    assert out == "numpy [28.]\n", (err, compiler)
    assert err.startswith("kousoku uses the NumPy kernels: ")
    assert "cannot load" in err
    assert err.count("kousoku uses") == 1


def _with_a_cache_on(prepare: str, cache: Path, folder: Path) -> tuple[str, str]:
    """Printed output, and messages, where the cache lies on a file system of its own."""
    cache.mkdir()
    enter = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c"]
    mounted = prepare.format(cache=cache)
    if not shutil.which("unshare") or subprocess.run([*enter, mounted], check=False).returncode:
        pytest.skip("this system does not let us mount a file system")
    command = f'{mounted} && exec "$0" "$@"'
    run = subprocess.run(
        [*enter, command, sys.executable, "-W", "error", "-c", LOAD_AND_CALL, str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    return run.stdout, run.stderr


@pytest.mark.parametrize("limit", [500, 6000])
def test_a_limit_on_the_size_of_files_gives_one_message_and_the_numpy_kernels(
    tiny: Path, cache: Path, compiler: object, limit: int
) -> None:
    limited = f"import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"
    run = python(limited + LOAD_AND_CALL, tiny, PYTHONDONTWRITEBYTECODE="1")
    out, err = run.communicate(timeout=60)
    assert out == "numpy [28.]\n", (err, compiler)
    assert "cannot write the cache" in err
    assert not list(cache.rglob("SHA256"))


def wait_for(marker: Path) -> None:
    for _ in range(3000):
        if marker.exists():
            return
        time.sleep(0.02)
    pytest.fail("the compiler was never started")


def stop(run: subprocess.Popen[str]) -> None:
    """Kill what is left of a session."""
    with suppress(ProcessLookupError):
        os.killpg(run.pid, signal.SIGKILL)
    run.communicate()
