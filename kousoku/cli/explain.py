"""``kousoku explain``: steps that a scene does not need, their savings, and the rest."""

import typer

from kousoku.cli.console import AsJson, print_json
from kousoku.cli.moving import KindsOption, SceneFile


def explain(
    scene_file: SceneFile,
    kind: KindsOption = None,
    as_json: AsJson = False,
) -> None:
    """Say what a solver of a scene leaves out, what that saves, and what it solves.

    Operations are those of all segments, each run once; bytes are those of the workspace.
    """
    from kousoku.checking import explain as explained

    explanation = explained(scene_file, kinds=kind)
    if as_json:
        print_json(explanation.as_data())
    else:
        typer.echo(str(explanation))
