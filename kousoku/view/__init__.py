"""See a mechanism move: a page that needs nothing beside itself, stills, the mechanism at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.view.page import Animation

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from kousoku.model.records.scene import Scene

__all__ = ["Animation", "animate", "draw_mechanism", "still"]

#: Width and height of a still beside a line of text, in the pixels of a page.
SMALL = (320, 210)


def animate(
    result: Any,
    scene: Scene,
    path: str | os.PathLike[str] | None = None,
    *,
    paths_of: Sequence[str | tuple[str, Sequence[float]]] | str | None = None,
    forces: Sequence[str] | bool = True,
    fps: float = 30.0,
    speed: float | None = None,
    start: float | None = None,
    end: float | None = None,
    parameters: Mapping[str, float | str] | None = None,
) -> Animation:
    """Animation of a run.

    Parameters
    ----------
    result : Motion or Trajectory
        The run: of bodies, or of a linkage of nodes.
    scene : Scene
        What moved.
    path : path, optional
        File to write, ``*.html`` or ``*.svg``.
    paths_of : sequence of str or (str, (3,)), optional
        Points whose paths are drawn: a joint or a node, a body, or a body with a point in its
        frame. Joints between two moving bodies unless given.
    forces : bool or sequence of str
        Joints whose forces are drawn where the run has them: what each does to its body j.
    fps : float [1/s]
        Frames that are kept for a second of showing; the page draws what lies between them.
    speed : float, optional
        Seconds of motion in a second of showing; real time unless that is too short or too fast
        to be seen.
    start, end : float, optional [s]
        The part of the run that is shown.
    parameters : mapping of str to float or str, optional
        Values that the run had for parameters of the scene, where they are not those of the scene.

    Raises
    ------
    SolveError
        There is no such joint or body, or nothing to show.
    """
    from kousoku.view.picture import picture_of

    picture = picture_of(
        result,
        scene,
        paths_of=paths_of,
        forces=forces,
        fps=fps,
        speed=speed,
        start=start,
        end=end,
        parameters=parameters,
    )
    animation = Animation(picture)
    if path is not None:
        animation.save(path)
    return animation


def still(
    scene: Scene, result: Any = None, parameters: Mapping[str, float | str] | None = None
) -> str:
    """Small still as HTML: of the first row of a run, or of the mechanism at rest.

    Parameters
    ----------
    scene : Scene
        What is drawn.
    result : Result, optional
        The run.
    parameters : mapping of str to float or str, optional
        Values of its parameters; its own unless given.
    """
    from base64 import b64encode

    from kousoku.view.picture import picture_at_rest, picture_of
    from kousoku.view.stills import still_svg

    if result is None:
        picture = picture_at_rest(scene, parameters)
    else:
        picture = picture_of(result, scene, parameters=parameters, paths_of=())
    data = b64encode(still_svg(picture, size=SMALL).encode()).decode()
    return f'<img alt="{scene.name}" src="data:image/svg+xml;base64,{data}">'


def draw_mechanism(scene: Scene, parameters: Mapping[str, float | str] | None = None) -> Figure:
    """Draw a mechanism at rest, at the positions as they are written; needs matplotlib.

    Parameters
    ----------
    scene : Scene
        What is drawn: of bodies, or a linkage of nodes.
    parameters : mapping of str to float or str, optional
        Values of its parameters; its own unless given.
    """
    from kousoku.view.figure import draw
    from kousoku.view.picture import picture_at_rest

    return draw(picture_at_rest(scene, parameters))
