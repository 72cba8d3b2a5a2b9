"""Data of a linkage for its solver: nodes, links, inputs, blocks and tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.codegen.linkage.solution import span_of
from kousoku.model.linkage.input_motion import turns_of
from kousoku.runtime.kinematics.rows import LINKAGE_METHODS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.linkage.assemble import Affine, LinkElement
    from kousoku.codegen.linkage.blocks import DiagonalBlock
    from kousoku.codegen.linkage.layout import WorkspaceLayout

DATA_FORMAT = 1


def linkage_data(program: Program, layout: WorkspaceLayout) -> dict[str, Any]:
    """Data of ``motion.json``: fields of ``LinkageTables``, and of its ``RunRequest``."""
    assembly = layout.assembly
    scene, coordinates = assembly.scene, assembly.coordinates
    return {
        "format": DATA_FORMAT,
        "name": scene.name,
        "unit": scene.unit,
        "length": float(scene.largest_length),
        "outputs": list(scene.outputs),
        "nodes": list(scene.nodes),
        "links": [
            [name, *link.nodes, float(scene.length(name))] for name, link in scene.links.items()
        ],
        "inputs": [
            [name, coordinates[c].unit, float(coordinates[c].scale)]
            for name, c in zip(scene.inputs, assembly.inputs, strict=True)
        ],
        "unknowns": [
            [unknown.name, float(unknown.start), float(unknown.scale), unknown.unit == "rad"]
            for unknown in (coordinates[c] for c in layout.unknowns)
        ],
        "blocks": [
            {
                "unknowns": [coordinates[c].name for c in block.unknowns],
                "links": [*dict.fromkeys(assembly.elements[e].name for e, _ in block.rows)],
                "curves": _curves(layout, block),
            }
            for block in layout.blocks
        ],
        "work_size": program.size,
        "places": {region.name: [region.base, region.size] for region in program.regions},
        "segments": [segment.name for segment in program.segments],
        "run": _run(layout),
    }


def _run(layout: WorkspaceLayout) -> dict[str, Any]:
    """Run of the scene, as data."""
    scene = layout.assembly.scene
    inputs = [*scene.inputs.values()]
    turns = [turns_of(item) or 0.0 for item in inputs]
    return {
        "method": LINKAGE_METHODS.index(scene.method.scheme),
        "max_iterations": scene.method.iterations,
        "limit": float(scene.residual_limit),
        "divisions": scene.divisions,
        "rows": scene.divisions + 1,
        "origin": [float(item.start) for item in inputs],
        "span": [float(span_of(item)) for item in inputs],
        "turns": [int(n) if n.is_integer() else 0 for n in turns],
        "rate": [float(item.rate) for item in inputs],
        "rate_dot": [float(item.acceleration) for item in inputs],
    }


def _curves(layout: WorkspaceLayout, block: DiagonalBlock) -> list[dict[str, Any]]:
    """Curves that bend the equations of a block.

    ε1 alone is |d| = l. With ε2 or ε3 it is one of two rows of d = l (cos β, sin β), turned by a
    constant angle; with all three, ε3 − ε2 is linear: it adds the other angle.
    """
    rows, curves = set(block.rows), []
    for row, (number, deformation) in enumerate(block.rows):
        element = layout.assembly.elements[number]
        angles = [element.ends[index] for k, index in ((1, 2), (2, 5)) if (number, k) in rows]
        x1, y1, _, x2, y2, _ = element.ends
        x, y = [(-1, x1), (1, x2)], [(-1, y1), (1, y2)]
        curves.append(_curve(layout, row, element, x=x, y=y, angle=angles[:1]))
        if deformation == 2 and len(angles) == 2:
            curves.append(_curve(layout, row, element, x=[], y=[], angle=angles[1:]))
    return curves


def _curve(
    layout: WorkspaceLayout,
    row: int,
    element: LinkElement,
    *,
    x: Sequence[tuple[int, Affine]],
    y: Sequence[tuple[int, Affine]],
    angle: Sequence[Affine],
) -> dict[str, Any]:
    """Curve by which a link bends a row, with indices and factors of the terms that move."""
    sums = {"x": x, "y": y, "angle": [(1, term) for term in angle]}
    moving = {
        name: [
            [layout.place_of(term.coordinate), float(sign * term.factor)]
            for sign, term in terms
            if layout.is_moving(term)
        ]
        for name, terms in sums.items()
    }
    return {"row": row, "length": float(element.length), "is_arm": bool(angle), **moving}
