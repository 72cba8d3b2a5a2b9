"""``kousoku generate``: from kinds and scenes to folders of NumPy and C."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from kousoku.cli.completing import files
from kousoku.cli.console import (
    DISAGREEMENT,
    AsJson,
    checkout,
    generated_folder,
    print_json,
    progress,
)
from kousoku.cli.moving import KindsOption
from kousoku.model.errors import EmitError, KousokuError
from kousoku.model.files.manifest import MANIFEST_FILE, Manifest
from kousoku.model.text import counted

SourceTree = dict[str, str]


class Emitted(StrEnum):
    """Sources that a package gets."""

    ALL = "all"
    C = "c"
    NUMPY = "numpy"


@dataclass(frozen=True, slots=True)
class Order:
    """Package to generate.

    Parameters
    ----------
    folder : Path
        Where it goes.
    make : callable
        Gives its files.
    """

    folder: Path
    make: Callable[[], SourceTree]


def generate(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Kinds and scene files; all that kousoku ships when left out.",
            autocompletion=files(".toml"),
        ),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; fail where a folder would change.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            help="The folder of one package, new or its own; in any other folder each package gets"
            " one of its name."
        ),
    ] = None,
    target: Annotated[
        Emitted, typer.Option(help="With --out: leave out the sources of the other target.")
    ] = Emitted.ALL,
    *,
    kind: KindsOption = None,
    as_json: AsJson = False,
) -> None:
    """Derive, freeze, optimise and emit packages of NumPy and C.

    Without --out, a kind or scene that kousoku ships goes where it stands in a checkout, and any
    other into the user's cache. Kinds whose sources did not change are not derived again; --check
    derives all, and says of each file that differs which input changed.
    """
    if out is None and target is not Emitted.ALL:
        raise EmitError(f"--target {target}: wants --out, or what kousoku ships would lose files")
    orders = [order for name in names or [""] for order in _orders(name, out, check, kind)]
    if out is not None and len(orders) == 1 and _is_own(out):
        _require_place(out, orders[0].folder.name, target)
    if check and out is None and checkout() is None and not any(x.folder.exists() for x in orders):
        raise EmitError(
            f"--check: nothing was generated in {_kinds_folder().parent}: this"
            " kousoku is no checkout; in one run make generate-check, or install it editable,"
            " pip install -e ."
        )
    if out is not None and len(orders) == 1 and _is_own(out):
        orders = [replace(orders[0], folder=out)]
    is_all = not names and out is None and checkout() is not None
    with progress() as bar:
        trees = [_files(order, target) for order in bar.track(orders, description="generate")]
    if check:
        remarks = [*_leftovers(), *_record_differs(orders, trees)] if is_all else []
        _report_check(orders, trees, remarks, is_shipped=out is None, as_json=as_json)
        return
    from kousoku.codegen.generate import write_tree
    from kousoku.model.files.cache import write_atomically
    from kousoku.runtime.messages import listed

    rows = [
        (order.folder, write_tree(order.folder, tree))
        for order, tree in zip(orders, trees, strict=True)
    ]
    if is_all:
        path, text = _record(orders, trees)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            write_atomically(path, text.encode())
    if as_json:
        written = [{"folder": str(folder), "changed": changed} for folder, changed in rows]
        print_json({"packages": written})
        return
    for folder, changed in rows:
        if changed:
            typer.echo(f"{_shown(folder)}: {listed(changed)}")
    same = sum(not changed for _, changed in rows)
    typer.echo(f"{same} of {counted(len(rows), 'package')} unchanged")


def _is_own(folder: Path) -> bool:
    """Whether a folder is there for one package: it is new, or a package already."""
    return not folder.exists() or (folder / MANIFEST_FILE).is_file()


def _require_place(out: Path, package: str, target: Emitted) -> None:
    """Refuse a folder that cannot be imported as a package, or that holds another one.

    Raises
    ------
    EmitError
        The message says why.
    """
    from kousoku.model.validation.names import scene_name_problem

    name = out.resolve().name
    if target is not Emitted.C and (problem := scene_name_problem(name)):
        raise EmitError(f"--out {out}: Python could not import the package: {problem}")
    try:
        present = Manifest.from_json((out / MANIFEST_FILE).read_text(encoding="utf-8")).package
    except (OSError, ValueError, KeyError, TypeError, KousokuError):
        return  # it is new, or damaged and written again
    if present != package:
        raise EmitError(
            f"--out {out}: holds the package of {present}, not of {package}; choose another folder,"
            " or remove it first"
        )


def _shown(folder: Path) -> Path:
    """Folder as the user would type it here."""
    current = Path.cwd()
    return folder.relative_to(current) if folder.is_relative_to(current) else folder


def _files(order: Order, target: Emitted) -> SourceTree:
    """Package as it is written into its folder, without sources of the other target."""
    from kousoku.codegen.generate import beside_runtime, without

    left_out = {Emitted.ALL: (), Emitted.C: (".py",), Emitted.NUMPY: (".c", ".h")}[target]
    tree = without(order.make(), *left_out)
    is_shipped = order.folder.resolve().is_relative_to(generated_folder() / "kinds")
    return beside_runtime(tree) if is_shipped else tree


def _orders(
    name: str, out: Path | None, check: bool, own_folders: Sequence[Path] | None
) -> list[Order]:
    """Packages that a name stands for."""
    from kousoku.cli.scenes import committed_scenes
    from kousoku.codegen.generate import generate_kind, package_names, package_of

    scenes = {path.stem: path for path in committed_scenes()}
    is_file = name.endswith(".toml")
    if is_file and (Path(name).exists() or name.removesuffix(".toml") not in scenes):
        return [_scene_order(Path(name), out, own_folders)]
    if name.removesuffix(".toml") in scenes:  # as the head of its files says
        return [_scene_order(scenes[name.removesuffix(".toml")], out)]
    packages = (package_of(name),) if name else package_names()
    kinds = _kinds_folder() if out is None else out
    committed = None if check else generated_folder() / "kinds"
    orders = [Order(kinds / p, partial(generate_kind, p, committed)) for p in packages]
    return orders if name else orders + [_scene_order(path, out) for path in scenes.values()]


def _scene_order(path: Path, out: Path | None, own_folders: Sequence[Path] | None = None) -> Order:
    from kousoku.cli.scenes import scene_folder
    from kousoku.loading import GivenScene, generated, naming
    from kousoku.own_kinds import own_kinds

    source = GivenScene.of(path, own_kinds(own_folders))
    scene = source.read()
    folder = scene_folder(scene.name) if out is None else out / scene.name

    def make() -> SourceTree:
        with naming(source.file):
            return generated(scene, references=True)

    return Order(folder, make)


def _kinds_folder() -> Path:
    """Folder where the kinds go: a checkout's own one, never an installed package."""
    from kousoku.model.files.cache import cache_folder

    if checkout() is not None:
        return generated_folder() / "kinds"
    return cache_folder() / "generated" / "kinds"


def _leftovers() -> list[str]:
    """Committed folders that nothing generates any more."""
    from kousoku.cli.scenes import committed_scenes
    from kousoku.codegen.generate import package_names

    scenes = {path.stem for path in committed_scenes()}
    kinds = set(package_names())
    scene_manifests = sorted(generated_folder().glob(f"*/{MANIFEST_FILE}"))
    kind_manifests = sorted(generated_folder().glob(f"kinds/*/{MANIFEST_FILE}"))
    stale = [path.parent for path in scene_manifests if path.parent.name not in scenes]
    stale += [path.parent for path in kind_manifests if path.parent.name not in kinds]
    return [f"{folder} is not generated any more" for folder in stale]


def _record(orders: Sequence[Order], trees: Sequence[SourceTree]) -> tuple[Path, str]:
    """File that says of which sources the kinds were derived, and its text."""
    from kousoku.codegen.derived import RECORD_FILE, record_of

    folder = generated_folder() / "kinds"
    pairs = zip(orders, trees, strict=True)
    kinds = {order.folder.name: tree for order, tree in pairs if order.folder.parent == folder}
    return folder / RECORD_FILE, record_of(kinds)


def _record_differs(orders: Sequence[Order], trees: Sequence[SourceTree]) -> list[str]:
    """Line if the kinds were derived of other sources, also where that changed nothing."""
    path, text = _record(orders, trees)
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return []
    return [f"{path} differs; changed: sources that derive (symbolic/, codegen/) or their results"]


def _report_check(
    orders: Sequence[Order],
    trees: Sequence[SourceTree],
    leftovers: list[str],
    *,
    is_shipped: bool,
    as_json: bool,
) -> None:
    """Print how folders differ, and the files in them that are not kousoku's own.

    In a folder of the user's such files may be; in one that kousoku ships they are a difference.
    """
    from kousoku.codegen.generate import check_tree, foreign_files

    pairs = list(zip(orders, trees, strict=True))
    differences = [line for order, tree in pairs for line in check_tree(order.folder, tree)]
    differences += leftovers
    foreign = [str(path) for order, tree in pairs for path in foreign_files(order.folder, tree)]
    if is_shipped:
        differences += [f"{path} is not kousoku's own: move it elsewhere" for path in foreign]
    if as_json:
        print_json({"ok": not differences, "differences": differences, "foreign": foreign})
    else:
        for line in differences:
            typer.echo(line, err=True)
        for path in () if is_shipped else foreign:
            typer.echo(f"{path} is not kousoku's own: it is left alone", err=True)
        differing = counted(len(differences), "file differs", "files differ")
        typer.echo(f"{counted(len(orders), 'package')}, {differing}")
    if differences:
        raise typer.Exit(DISAGREEMENT)
