"""Explanation of a planar linkage: blocks of unknowns, and operations of its kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.codegen.linkage.assemble import assemble
from kousoku.codegen.linkage.generate import layout_of, program_of
from kousoku.model.text import counted, table
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.codegen.linkage.layout import WorkspaceLayout
    from kousoku.model.records.scene import Scene


@dataclass(frozen=True, slots=True)
class LinkageExplanation:
    """Explanation of the solver of a linkage, whose inputs determine everything.

    Parameters
    ----------
    name : str
        Name of the scene.
    inputs : int
        Count of the inputs.
    blocks : tuple of (int, int)
        Unknowns and rows of each block, in the order of solving.
    kernels : tuple of (str, int)
        Operations of each kernel.
    findings : tuple of str
        Notes on merged, dropped and omitted parts, a sentence each.
    """

    name: str
    inputs: int
    blocks: tuple[tuple[int, int], ...]
    kernels: tuple[tuple[str, int], ...]
    findings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        unknowns = sum(unknowns for unknowns, _ in self.blocks)
        return (
            f"<LinkageExplanation of {self.name}: {counted(self.inputs, 'input')},"
            f" {counted(unknowns, 'unknown')}; print() shows what is solved>"
        )

    def __str__(self) -> str:
        sizes = ", ".join(str(unknowns) for unknowns, _ in self.blocks)
        unknowns = sum(unknowns for unknowns, _ in self.blocks)
        return (
            f"{self.name}: {counted(self.inputs, 'input')},"
            f" {counted(unknowns, 'unknown')} solved block after block: {sizes}\n"
            + "".join(f"{finding}\n" for finding in self.findings)
            + table(("kernel", "operations"), [(name, str(n)) for name, n in self.kernels])
        )

    def as_data(self) -> dict[str, Any]:
        """Explanation as data, ready for JSON."""
        return {
            "name": self.name,
            "inputs": self.inputs,
            "blocks": [{"unknowns": unknowns, "rows": rows} for unknowns, rows in self.blocks],
            "kernels": dict(self.kernels),
        }


def explain_linkage(scene: Scene) -> LinkageExplanation:
    """Explanation of the equations that are solved for a planar linkage.

    Parameters
    ----------
    scene : Scene
        A checked planar scene.

    Raises
    ------
    SceneError
        The scene has bodies.
    """
    layout = layout_of(assemble(scene))
    return LinkageExplanation(
        scene.name,
        len(layout.assembly.inputs),
        tuple((len(x.unknowns), len(x.rows)) for x in layout.blocks),
        tuple((x.name, x.operations.total()) for x in program_of(layout).kernels),
        (*layout.assembly.notes, *_left_out(layout)),
    )


def _left_out(layout: WorkspaceLayout) -> Iterator[str]:
    """Finding about unknowns of no block: rotations, as all nodes are wanted."""
    names = [layout.assembly.coordinates[c].name for c in layout.left_out]
    if names:
        yield f"rotations left out, on which nothing that is asked for depends: {listed(names)}"
