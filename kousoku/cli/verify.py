"""``kousoku verify``: recompute the reference values of generated packages on this machine."""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kousoku.cli.completing import files
from kousoku.cli.console import (
    DISAGREEMENT,
    AsJson,
    TargetChoice,
    checkout,
    find_packages,
    print_json,
    print_table,
    progress,
)
from kousoku.cli.moving import KindsOption
from kousoku.model.errors import LoadError
from kousoku.model.text import counted

if TYPE_CHECKING:
    from kousoku.runtime.choice import Target
    from kousoku.runtime.report import Report

#: Problems of one package in the summary; verifying it alone prints all of them.
MOST_PROBLEMS_SHOWN = 4


def verify(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Packages, kinds, folders or scene files; all when left out.",
            autocompletion=files(".toml"),
        ),
    ] = None,
    target: Annotated[
        TargetChoice,
        typer.Option(help="What to check: all that this machine can run, or one target."),
    ] = TargetChoice.AUTO,
    kind: KindsOption = None,
    as_json: AsJson = False,
) -> None:
    """Check that emitted code computes what was derived, within 4 units of rounding."""
    from kousoku.runtime.report import LIMIT
    from kousoku.runtime.toolchain import find_toolchain

    if target is TargetChoice.C:
        find_toolchain()  # without one nothing disagrees: there is nothing to check
    with ExitStack() as stack:
        folders = [folder for name in names or [""] for folder in _folders(name, stack, kind)]
        reports = verify_all(folders, target.value)
    if as_json:
        ok = all(report.ok for report in reports)
        packages = [report.to_dict() for report in reports]
        print_json({"ok": ok, "limit": LIMIT, "packages": packages})
    elif names and len(reports) == 1:
        typer.echo(str(reports[0]))
    else:
        print_summary(reports)
    if not all(report.ok for report in reports):
        raise typer.Exit(DISAGREEMENT)


def _folders(name: str, stack: ExitStack, kinds: Sequence[Path] | None) -> list[Path]:
    """Folders that a name stands for; that of a scene file is generated.

    Raises
    ------
    LoadError
        There is no such package, scene or folder.
    """
    from kousoku.loading import GivenScene, cached_solver_folder
    from kousoku.own_kinds import own_kinds

    if name.endswith(".toml"):
        source = GivenScene.of(name, own_kinds(kinds))
        return [stack.enter_context(cached_solver_folder(source, references=True))]
    try:
        return find_packages(name)
    except LoadError:
        root = checkout()
        scene = None if root is None else root / "scenes" / f"{name}.toml"
        if scene is None or not scene.is_file():
            raise
        return [stack.enter_context(cached_solver_folder(GivenScene.of(scene), references=True))]


def verify_all(folders: Sequence[Path], target: "Target") -> list["Report"]:
    """Verify packages side by side: most of the time goes into the compiler's processes."""
    from kousoku.runtime.verify import verify as verified

    with progress() as bar, ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = pool.map(lambda folder: verified(folder, target=target), folders)
        return list(bar.track(jobs, total=len(folders), description="verify"))


def print_summary(reports: Sequence["Report"]) -> None:
    """Print one line for each package, then those not checked, and problems."""
    from kousoku.runtime.report import LIMIT

    rows = []
    for report in reports:
        worst = report.worst
        location = f"{worst.kernel} {worst.output}, {worst.label}" if worst else ""
        targets = ", ".join(dict.fromkeys(row.way.split()[0] for row in report.rows))
        number = f"{worst.worst:.2f}" if worst else "-"
        rows.append((report.package, targets, number, location, "ok" if report.ok else "WRONG"))
    print_table(("package", "targets", "worst [units]", "where", ""), rows)
    for note in dict.fromkeys(note for report in reports for note in report.notes):
        typer.echo(note)
    for report in reports:
        for problem in report.problems[:MOST_PROBLEMS_SHOWN]:
            typer.echo(f"{report.package}: {problem}", err=True)
        if (remaining := len(report.problems) - MOST_PROBLEMS_SHOWN) > 0:
            more = f"and {remaining} more; kousoku verify {report.package}"
            typer.echo(f"{report.package}: {more}", err=True)
    count = sum(report.ok for report in reports)
    typer.echo(
        f"{count} of {counted(len(reports), 'package')} compute"
        f"{'s' * (len(reports) == 1)} what was derived, within {LIMIT:g} units"
    )
