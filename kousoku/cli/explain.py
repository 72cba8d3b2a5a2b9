"""``kousoku explain``: what a scene does not need, what that saves, and what remains."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kousoku.cli.console import AsJson, print_json, print_table

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.explanation.explain import Explanation
    from kousoku.model.scene import Scene

#: Joints that a line names.
SHOWN = 12


def explain(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, *.toml.")],
    as_json: AsJson = False,
) -> None:
    """Say what a solver of a scene leaves out, what that saves, and what it solves.

    Operations are those of all segments, each run once; bytes are those of the workspace.
    """
    from kousoku.model.read import read_scene

    scene = read_scene(scene_file)
    if not scene.is_spatial:
        _explain_linkage(scene, as_json=as_json)
        return
    from kousoku.cli.scenes import naming
    from kousoku.codegen.dynamics.explanation.explain import explain as explained

    with naming(scene_file):
        found = explained(scene)
    if as_json:
        print_json(_data(found))
        return
    _print(found)


def _data(found: "Explanation") -> dict[str, Any]:
    freedom = found.freedom
    return {
        "name": found.name,
        "is_planar": found.is_planar,
        "steps": [asdict(step) for step in found.steps],
        "segments": dict(found.segments),
        "structure": asdict(found.structure),
        "freedom": asdict(freedom)
        | {"degrees": freedom.degrees, "not_unique": list(freedom.not_unique)},
        "removed": list(found.removed),
        "drivers": list(found.drivers),
    }


def _print(found: "Explanation") -> None:
    print_table(
        ("step", "rows", "columns", "operations", "bytes", "what"),
        [
            (x.name, *(_saved(n) for n in (x.rows, x.columns, x.operations, x.bytes)), x.detail)
            for x in found.steps
        ],
        title=f"{found.name}: what each step saves",
    )
    typer.echo()
    total = sum(count for _, count in found.segments)
    print_table(
        ("segment", "operations"),
        [(name, str(count)) for name, count in (*found.segments, ("all", total))],
        title="what remains",
    )
    s = found.structure
    typer.echo(
        f"{s.positions} coordinates, {s.velocities} velocities"
        f"{f', {s.dependent} of which follow from the others' if s.dependent else ''},"
        f" {_counted(s.rows, 'row')}; C_q has"
        f" {s.elements} elements that are not zero, S {s.schur} in its lower triangle, its factors"
        f" {s.fill_in} more; solved in {_counted(s.parts, 'part')}"
        f"{', in a coordinate plane' if found.is_planar else ''}"
    )
    for line in _lines(found):
        typer.echo(line)


def _saved(count: int) -> str:
    return str(count) if count else ""


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def _lines(found: "Explanation") -> list[str]:
    """Return what is known of freedoms and dependences."""
    freedom, removed = found.freedom, found.removed
    degrees = _counted(freedom.degrees, "degree")
    lines = [f"{degrees} of freedom: {freedom.columns} velocities less rank {freedom.rank}"]
    if not freedom.degrees:
        lines.append(
            f"the motion is that of {_names(found.drivers)}"
            if found.drivers
            else "nothing can move"
        )
    for one in freedom.dependent:
        where = (
            f"along the branch, {freedom.positions} positions looked at"
            if one.is_everywhere
            else "at the start only, where other motions branch off or end"
        )
        rows = _counted(one.dimension, "row")
        verb = "depends" if one.dimension == 1 else "depend"
        lines.append(f"{rows} of {one.rows} {verb} on the others of {_names(one.joints)}: {where}")
    if removed:
        lines.append(
            f"left out: {_names(removed)}; the others keep their rank at all of these positions,"
            f" {freedom.worst:.2g} of 1 at the worst"
        )
    if freedom.not_unique:
        lines.append(f"reactions are not unique at {_names(freedom.not_unique)}")
    if freedom.unknown:
        lines.append(
            f"dependent rows were not looked for in loops with too many rows, those of"
            f" {_names(freedom.unknown)}: degrees of freedom are at least that"
        )
    return lines


def _names(names: Sequence[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _explain_linkage(scene: "Scene", *, as_json: bool) -> None:
    """Say what is solved of a planar linkage, whose inputs determine everything."""
    from kousoku.codegen.linkage import specialise
    from kousoku.codegen.store import load_frozen
    from kousoku.model.assemble import assemble

    program = specialise(assemble(scene), load_frozen("link"))
    layout = program.layout
    blocks = [{"unknowns": len(x.unknowns), "rows": len(x.rows)} for x in layout.blocks]
    kernels = {x.name: x.operations.total() for x in program.package.kernels}
    if as_json:
        data = {"name": scene.name, "inputs": len(layout.system.inputs)}
        print_json({**data, "blocks": blocks, "kernels": kernels})
        return
    sizes = ", ".join(str(block["unknowns"]) for block in blocks)
    typer.echo(
        f"{scene.name}: {_counted(len(layout.system.inputs), 'input')},"
        f" {_counted(len(layout.unknowns), 'unknown')} solved block after block: {sizes}"
    )
    print_table(("kernel", "operations"), [(name, str(n)) for name, n in kernels.items()])
