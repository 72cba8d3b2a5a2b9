"""The public names and their signatures are as committed: nobody's program breaks unnoticed."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_overloads

import pytest

import kousoku as ks
from kousoku.cataloging import Catalog
from kousoku.ledger.entry import Entry
from kousoku.runtime.integrate.result import AnimationOptions
from kousoku.runtime.kernel import Kernel
from kousoku.runtime.library import Library
from kousoku.runtime.options import RunOptions
from kousoku.runtime.report import Report
from kousoku.stages import KernelExplanation
from kousoku.state_matrices import Evaluation, Matrices
from kousoku.symbolic.derivation import Derivation
from kousoku.view import Animation, animate

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ROOT = Path(__file__).parents[2]
#: What the public functions return or take beside the public classes.
MORE = (
    *(Animation, AnimationOptions, Catalog, Derivation, Entry, Evaluation, Kernel),
    *(KernelExplanation, Library, Matrices, Report, RunOptions),
)
#: What the four lines may need beside the standard library, of what an installation brings.
NEEDED = {"numpy", "msgspec", "mpmath", "jinja2", "markupsafe", "typing_extensions"}


def signature(function: object) -> str:
    """Signature of a function of kousoku, without ``self``; empty for others."""
    if not inspect.isfunction(function) or not function.__module__.startswith("kousoku."):
        return ""
    text = str(inspect.signature(function))
    return text.replace("(self, ", "(").replace("(self)", "()")


def members(kind: type) -> Iterator[str]:
    """Fields, properties and methods that are public, those of bases too, by name."""
    if issubclass(kind, BaseException):
        return
    fields = {name for base in kind.__mro__ for name in getattr(base, "__annotations__", {})}
    for name in sorted({*dir(kind), *fields}):
        if name.startswith("_") or (hasattr(dict, name) and issubclass(kind, dict)):
            continue
        what = inspect.getattr_static(kind, name, None)
        function = getattr(what, "__func__", what)
        overloads = get_overloads(function) if inspect.isfunction(function) else []
        yield from (f"    .{name}{signature(one)}" for one in overloads or [function])


def shown(name: str, what: Any) -> Iterator[str]:
    """Lines of a public name."""
    if inspect.isclass(what):
        yield f"{name}{signature(what.__init__)}"
        yield from members(what)
    elif inspect.ismodule(what):
        yield name
        yield from (f"    .{one}{signature(getattr(what, one))}" for one in what.__all__)
    else:
        yield f"{name}{signature(what)}"


def test_names_and_signatures(golden: Callable[[str], None]) -> None:
    public = [(name, getattr(ks, name)) for name in ks.__all__]
    lines = [line for name, what in public for line in shown(name, what)]
    lines += [line for what in MORE for line in shown(what.__name__, what)]
    golden("\n".join([*lines, ""]))


def test_a_result_takes_the_options_of_an_animation() -> None:
    _, _, _, *options = inspect.signature(animate).parameters.values()
    wanted = {one.name: one.annotation for one in options}
    own = AnimationOptions.__annotations__
    assert {name: kind.__forward_arg__ for name, kind in own.items()} == wanted


def test_every_public_name_has_a_docstring() -> None:
    wanted = set(ks.__all__) - {"__version__"}
    assert {name for name in wanted if inspect.getdoc(getattr(ks, name))} == wanted


@pytest.mark.usefixtures("compiler")
def test_the_four_lines_import_what_they_need_and_no_more(tmp_path: Path) -> None:
    code = (
        "import sys, kousoku as ks\n"
        "run = ks.load(sys.argv[1]).simulate(0.1)\n"
        "run['crank_angle'], run.joint('a').force; run.animate(sys.argv[2])\n"
        "files = {n: getattr(m, '__file__', None) or '' for n, m in sys.modules.items()}\n"
        "print(*{n.partition('.')[0] for n, f in files.items() if 'site-packages' in f})\n"
    )
    out = subprocess.run(
        [sys.executable, "-c", code, ROOT / "scenes" / "loop_free.toml", tmp_path / "loop.html"],
        env=os.environ | {"KOUSOKU_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=True,
    )
    found = {name for name in out.stdout.split() if not name.startswith("_")}
    assert {"numpy"} < found - {"kousoku"} <= NEEDED


def test_completions_offer_the_public_names_alone() -> None:
    code = (
        "import kousoku as ks; ks.load, ks.ledger, ks.SceneBuilder;"
        "print(*(x for x in dir(ks) if not x.startswith('_')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [name for name in sorted(ks.__all__) if name[0] != "_"]
