"""``kousoku check``: all problems of scene files, and notes on them."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kousoku.cli.completing import files
from kousoku.cli.console import BAD_INPUT, AsJson, print_json
from kousoku.cli.moving import KindsOption
from kousoku.model.errors import AssemblyError, Problem, SceneError

if TYPE_CHECKING:
    from kousoku.model.records.own_kind import OwnKind

#: Problem of a force without a finite value at the start.
NO_VALUE = (
    "has no finite value where the scene starts, as x/abs(x) where x is 0; take x/sqrt(x^2 + 1e-6),"
    " or start elsewhere"
)
#: The same of the formula of an event.
NOT_SEEN = (
    "has no finite value where the scene starts; write it so that it has one, as sqrt(max(x, 0)) in"
    " place of sqrt(x) and x - 1 of log(x), or start elsewhere"
)


def check(
    scene_files: Annotated[
        list[Path],
        typer.Argument(
            metavar="SCENE...", help="Scene files, *.toml.", autocompletion=files(".toml")
        ),
    ],
    *,
    kind: KindsOption = None,
    as_json: AsJson = False,
) -> None:
    """Check scenes: keys, names, formulas, whether joints close, and what drivers may prescribe.

    Nothing is generated. The exit code is 2 where a scene is wrong; notes do not count.
    """
    from kousoku.own_kinds import own_kinds

    kinds = own_kinds(kind)
    scenes = [checked(path, kinds) for path in scene_files]
    if as_json:
        print_json({"scenes": scenes})
    else:
        for scene in scenes:
            for line in (*scene["problems"], *scene["notes"]):
                typer.echo(line["text"])
            if scene["is_valid"]:
                typer.echo(f"{scene['file']}: {scene['what']}")
    if not all(scene["is_valid"] for scene in scenes):
        raise typer.Exit(BAD_INPUT)


def checked(path: Path, kinds: Mapping[str, "OwnKind"] | None) -> dict[str, Any]:
    """Findings about a scene file, ready for JSON.

    Parameters
    ----------
    path : Path
        The file.
    kinds : mapping of str to OwnKind, optional
        Kinds of one's own that its joints may be of.

    Returns
    -------
    dict
        ``file``, ``is_valid``, ``what`` it is, and ``problems`` and ``notes``: each has ``line``,
        0 where there is none, ``key``, ``problem``, and all of it as ``text``.
    """
    from kousoku.model.reading.read import located, read_scene

    what, notes, problems = "", tuple[str, ...](), list[dict[str, Any]]()
    try:
        what, notes = _examined(read_scene(path, kinds=kinds))
    except (SceneError, AssemblyError) as raised:
        error = located(raised, path)
        if isinstance(error, SceneError):
            problems = [
                _line(path, problem.line, problem.key, problem.problem)
                for problem in error.problems
            ]
        else:
            key, *_ = (*error.keys, "")
            head, _, text = str(error).partition(": ")
            number = head.rpartition(":")[2]
            problems = [_line(path, int(number) if number.isdigit() else 0, key, text)]
            problems[0]["text"] = str(error)
    return {
        "file": str(path),
        "is_valid": not problems,
        "what": what,
        "problems": problems,
        "notes": [{**_line(path, 0, "", note), "text": f"{path}: note: {note}"} for note in notes],
    }


def _examined(scene: Any) -> tuple[str, tuple[str, ...]]:
    """Sort of a scene, and its notes.

    Raises
    ------
    SceneError, AssemblyError
        It cannot be moved.
    """
    from kousoku.codegen.linkage.assemble import assemble
    from kousoku.model.records.dotted_keys import join
    from kousoku.model.validation.validate import check as checked_again

    if not scene.is_spatial:
        assemble(scene)
        return _counted(scene, {"links": "link", "sliders": "slider", "inputs": "input"}), (
            checked_again(scene)
        )
    from kousoku.codegen.dynamics.checking.start import events_without_value, forces_without_value
    from kousoku.codegen.dynamics.generate import compose_scene
    from kousoku.model.expressions.formulas import used_parameters
    from kousoku.model.lowering.about import notes_of_dry_friction

    composed = compose_scene(scene, scene.outputs)
    if names := forces_without_value(composed.written):
        raise SceneError.of([Problem(NO_VALUE, join("forces", name)) for name in names])
    if events := events_without_value(composed.program, composed.system):
        raise SceneError.of(
            [Problem(f"{when} {NOT_SEEN}", f"{join('events', name)}.when") for name, when in events]
        )
    degrees = f"{composed.degrees} degree{'s' * (composed.degrees != 1)} of freedom"
    tables = {"bodies": "body", "joints": "joint", "drivers": "driver"}
    tables |= {"inputs": "input", "forces": "force", "events": "event"}
    used = used_parameters(scene)
    unused = [name for name in scene.parameters if name not in used]
    return f"{_counted(scene, tables)}; {degrees}", (
        *composed.about.notes,
        *notes_of_dry_friction(scene),
        *(f"parameters.{name}: stands in no formula, and changes nothing" for name in unused),
    )


def _counted(scene: Any, tables: Mapping[str, str]) -> str:
    """Number of elements of a scene."""
    counts = {table: len(getattr(scene, table)) for table in tables}
    texts = [f"{n} {table if n != 1 else tables[table]}" for table, n in counts.items() if n]
    return ", ".join(texts)


def _line(path: Path, line: int, key: str, problem: str) -> dict[str, Any]:
    position = f"{path}:{line}" if line else str(path)
    text = ": ".join(part for part in (position, key, problem) if part)
    return {"line": line, "key": key, "problem": problem, "text": text}
