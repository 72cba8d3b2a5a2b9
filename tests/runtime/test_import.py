"""Importing the runtime is fast because it loads little."""

from __future__ import annotations

import subprocess
import sys

#: Not needed until a library is loaded, verified, or something goes wrong.
LATE = {
    "fcntl",
    "hashlib",
    "importlib.machinery",
    "jinja2",
    "kousoku.runtime.build",
    "kousoku.runtime.plan",
    "kousoku.runtime.toolchain",
    "logging",
    "mpmath",
    "msgspec",
    "rich",
    "shlex",
    "subprocess",
    "sympy",
    "sysconfig",
    "tempfile",
    "typer",
}


def test_import_adds_little_to_numpy() -> None:
    code = (
        "import sys, numpy; before = set(sys.modules)\n"
        "import kousoku.runtime; print(*sorted(set(sys.modules) - before))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    added = set(run.stdout.split())
    assert "kousoku.runtime.library" in added
    assert not added & LATE
    assert len(added) < 60


def test_a_compiled_solver_loads_no_integrator_in_python() -> None:
    code = (
        "import sys, kousoku.runtime.dynamics, kousoku.runtime.dynamics_targets\n"
        "print(*(name for name in sys.modules if name.startswith('kousoku.runtime.integrate.')))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.rpartition(".")[2] for name in run.stdout.split()}
    assert loaded == {"body_tables", "events", "motion", "result", "settings", "state"}
