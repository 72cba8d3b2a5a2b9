"""Find a C compiler, say what it is and which machine it builds for.

``KOUSOKU_CC`` chooses the compiler (a command such as ``gcc-13``, ``/opt/bin/clang`` or
``zig cc``; ``none`` for no compiler). Without it ``CC``, ``cc``, ``gcc`` and ``clang`` are tried,
then the package ``ziglang`` of the optional extra ``kousoku[compiler]``. ``KOUSOKU_CFLAGS`` adds
flags. All flags of all builds stand in this file.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

from kousoku.model.errors import CompilerError, NoCompilerError

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator, Sequence

#: Flags of every kernel: contraction stays off because fused operations would round differently
#: from the NumPy kernels; math functions need not set errno. gcc 12 contracts in spite of that flag
#: where it vectorises straight-line code (it makes vfmaddsub of a product, a sum and a difference).
FLAGS = (
    "-std=c99",
    "-O3",
    "-ffp-contract=off",
    "-fno-tree-slp-vectorize",
    "-fno-math-errno",
)
#: Flags for ``-O3`` where a source has more bytes than :data:`LARGE`: its many small kernels are as
#: fast, and compile in two thirds of the time. Smaller scenes may be one long function each, which
#: would take up to 1.8 times as long.
LARGE_FLAGS = ("-O1", "-ftree-vectorize")
LARGE = 800_000
#: Flags with which gcc, unless it was built without that, compiles such a source in two processes.
PARALLEL_FLAGS = ("-flto=2", "-flto-partition=balanced")
#: Copyright holder, which the version of gcc alone names.
GCC = "Free Software Foundation"
#: Flags for the features of this machine's processor; the first that the compiler takes.
NATIVE_FLAGS = (("-march=native",), ("-mcpu=native",), ())
#: The math library comes after the sources.
LIBRARIES = () if sys.platform == "win32" else ("-lm",)
#: File name extension of a shared library.
EXTENSION = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
#: A library of pure functions needs no start-up code. GCC's would set the processor to flush
#: subnormals in the whole process under some unsafe flags, and that of a library whose file was
#: damaged while a process had it open would crash the process at its end.
_SHARED = {
    "win32": ("-shared",),
    "darwin": ("-dynamiclib", "-fPIC"),
    "linux": ("-shared", "-fPIC", "-nostartfiles"),
}.get(sys.platform, ("-shared", "-fPIC"))
_NONE_FOUND = (
    "no C compiler found (tried cc, gcc and clang; pip install 'kousoku[compiler]' brings one)"
)
#: Headers that every kernel includes: a compiler without them is no compiler for us.
_PROBE = b"#include <math.h>\n#include <stddef.h>\n"


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A compiler and all that decides which machine code it makes.

    Parameters
    ----------
    command : tuple of str
        The compiler and its leading arguments.
    version : str
        Everything it prints for ``--version``.
    machine : str
        Its target triple, ``""`` where it does not tell.
    features : str
        SHA-256 of all macros that it predefines under ``flags``: architecture, processor features,
        ABI, and the effect of every flag on floating-point semantics.
    flags : tuple of str
        Compile flags, those of ``KOUSOKU_CFLAGS`` last.
    """

    command: tuple[str, ...]
    version: str
    machine: str
    features: str
    flags: tuple[str, ...]

    @property
    def name(self) -> str:
        """The first line of the version, for messages."""
        return self.version.partition("\n")[0]

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the compiler, the resolved target and the flags.

        The command counts too: a script around a compiler may add flags that show in no macro.
        """
        flags = (*self.flags, *_SHARED, *LIBRARIES)
        identity = (*self.command, self.version, self.machine, self.features, *flags)
        return hashlib.sha256("\0".join((*identity, sys.platform)).encode()).hexdigest()

    def compile_command(
        self, sources: Sequence[str], library: str, extra: Sequence[str] = ()
    ) -> tuple[str, ...]:
        """Command that builds a shared library from C sources."""
        flags = (*self.flags, *extra, *_SHARED)
        return (*self.command, *flags, "-o", library, *sources, *LIBRARIES)

    def compile_commands(
        self,
        sources: Sequence[str],
        library: str,
        extra: Sequence[str] = (),
        *,
        is_large: bool = False,
    ) -> Iterator[tuple[str, ...]]:
        """Commands that build a library of which some sources may be large, the fastest first."""
        if not is_large:
            yield self.compile_command(sources, library, extra)
            return
        index = FLAGS.index("-O3")  # those of KOUSOKU_CFLAGS come behind
        flags = (*self.flags[:index], *LARGE_FLAGS, *self.flags[index + 1 :])
        variants = (
            [PARALLEL_FLAGS, ()] if GCC in self.version and (os.cpu_count() or 1) > 1 else [()]
        )
        for extra_flags in variants:
            yield replace(self, flags=(*extra_flags, *flags)).compile_command(
                sources, library, extra
            )


def find_toolchain() -> Toolchain:
    """Compiler of this machine.

    A compiler is probed once a process for each setting of the environment; it is never remembered
    on disk, so that a library built for another processor cannot be taken for this one's.

    Raises
    ------
    NoCompilerError
        There is none that works, or ``KOUSOKU_CC=none``.
    CompilerError
        What ``KOUSOKU_CC`` or ``KOUSOKU_CFLAGS`` asks for is not there or does not work.
    """
    chosen = os.environ.get("KOUSOKU_CC", "").strip()
    flags = tuple(_split(os.environ.get("KOUSOKU_CFLAGS", "")))
    if chosen.lower() == "none":
        raise NoCompilerError("KOUSOKU_CC=none switches the C compiler off")
    if chosen:
        return _chosen(chosen, os.environ.get("PATH", ""), flags)
    return _first(os.environ.get("CC", "").strip(), os.environ.get("PATH", ""), flags)


@cache
def _chosen(text: str, path: str, added: tuple[str, ...]) -> Toolchain:
    command = _located(text, path)
    if command is None:
        raise CompilerError(
            f"KOUSOKU_CC={text!r}: no such command; set it to a C compiler, "
            "or to 'none' to use the NumPy kernels"
        )
    return probe(command, added)


@cache
def _first(preferred: str, path: str, added: tuple[str, ...]) -> Toolchain:
    refusals = []
    commands = [_located(text, path) for text in (preferred, "cc", "gcc", "clang")]
    for command in (*commands, _packaged_zig()):
        if command is None:
            continue
        try:
            probe(command, ())
        except CompilerError as error:
            refusals.append(str(error))
        else:
            return probe(command, added)
    raise NoCompilerError("\n".join(refusals) or _NONE_FOUND)


def _located(text: str, path: str) -> tuple[str, ...] | None:
    """Command with its program's full path, None where there is no such program."""
    executable = shutil.which(text, path=path)  # a path may hold blanks
    if executable:
        return (executable,)
    words = _split(text)
    program = shutil.which(words[0], path=path) if words else None
    if program:
        return (program, *words[1:])
    zig = _packaged_zig() if words[:1] == ["zig"] else None
    return zig and (*zig[:-1], *words[1:])


def _packaged_zig() -> tuple[str, ...] | None:
    from importlib.util import find_spec

    return (sys.executable, "-m", "ziglang", "cc") if find_spec("ziglang") else None


def _split(text: str) -> list[str]:
    import shlex

    return shlex.split(text, posix=sys.platform != "win32")


@cache
def probe(command: tuple[str, ...], added: tuple[str, ...]) -> Toolchain:
    """Ask a compiler what it is and what it builds for.

    Raises
    ------
    CompilerError
        It cannot be started, or does not preprocess two standard headers; its output is shown.
    """
    version = run((*command, "--version"))
    refusals = []
    for native in NATIVE_FLAGS:
        flags = (*FLAGS, *native, *added)
        macros = run((*command, *flags, "-dM", "-E", "-x", "c", "-"), stdin=_PROBE)
        if macros.returncode == 0:
            machine = run((*command, "-dumpmachine"))
            return Toolchain(
                command=command,
                version=output(version),
                machine=output(machine) if machine.returncode == 0 else "",
                features=hashlib.sha256(macros.stdout).hexdigest(),
                flags=flags,
            )
        refusals.append(output(macros))
    quoted = f"it said:\n{refusals[0]}\n" if refusals[0] else "it said nothing "
    raise CompilerError(
        f"the C compiler {' '.join(command)!r} does not work here; {quoted}"
        "(KOUSOKU_CC chooses another compiler; KOUSOKU_CC=none the NumPy kernels)"
    )


def run(
    command: Sequence[str], *, stdin: bytes = b"", cwd: str | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Run a compiler with its messages in English and wait for it.

    Raises
    ------
    CompilerError
        It cannot be started.
    """
    import subprocess

    environment = {**os.environ, "LC_ALL": "C"}
    try:
        return subprocess.run(
            command, input=stdin, capture_output=True, cwd=cwd, env=environment, check=False
        )
    except OSError as error:
        raise CompilerError(f"cannot start the C compiler {' '.join(command)!r}: {error}") from None


def output(process: subprocess.CompletedProcess[bytes]) -> str:
    """Everything a compiler printed."""
    return (process.stdout + process.stderr).decode(errors="replace").strip()
