"""Kernels of the outputs of a linkage: motions of nodes, angles of links."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from kousoku.codegen.linkage.layout import WorkspaceLayout

#: Name, power of the second in the unit, and meaning of each order of derivative.
MOTIONS = (
    ("position", "", "positions"),
    ("velocity", "/s", "velocities"),
    ("acceleration", "/s^2", "accelerations"),
)


def node_kernel(layout: WorkspaceLayout) -> Kernel:
    """Kernel of the motion of all nodes: position, velocity, acceleration, (24), (25).

    Each output is (nodes, 2), in frame O, in the order of the scene, in its unit, per s and s².
    """
    graph = Graph()
    assembly = layout.assembly
    names = ", ".join(name for name, _, _ in assembly.nodes)
    unit, shape = assembly.scene.unit, (len(assembly.nodes), 2)
    outputs, results = [], []
    for order, (name, per, meaning) in enumerate(MOTIONS):
        outputs.append(Quantity(name, shape, unit + per, f"{meaning} of {names} in frame O"))
        terms = [term for _, x, y in assembly.nodes for term in (x, y)]
        results.append(tuple(layout.node(graph, term, order) for term in terms))
    return drop_dead(
        Kernel(
            name="nodes",
            title="Motion of the nodes",
            formula="node = offset + factor * coordinate",
            source="Yamada and Tatsumi 1981, (18), (24), (25)",
            inputs=(layout.workspace,),
            outputs=tuple(outputs),
            nodes=tuple(graph.nodes),
            results=tuple(results),
        )
    )


def angle_kernel(layout: WorkspaceLayout) -> Kernel:
    """Kernel of the angles β of all links, their first and second derivatives [rad, per s and s²].

    Each output is (links,), counter-clockwise from +x of frame O, from the first node of the link
    to the second, (10)-(13); the angle is in (−π, π].
    """
    graph = Graph()
    columns = [_angle(layout, graph, name) for name in layout.assembly.scene.links]
    names = ", ".join(layout.assembly.scene.links)
    outputs = tuple(
        Quantity(name, (len(columns),), f"rad{per}", f"{meaning} of links {names}")
        for name, per, meaning in (
            ("angle", "", "angles"),
            ("angle_dot", "/s", "angular velocities"),
            ("angle_ddot", "/s^2", "angular accelerations"),
        )
    )
    return drop_dead(
        Kernel(
            name="angles",
            title="Angles of the links",
            formula="tan(beta) = (y2 - y1) / (x2 - x1)",
            source="Yamada and Tatsumi 1981, (10)-(13)",
            inputs=(layout.workspace,),
            outputs=outputs,
            nodes=tuple(graph.nodes),
            results=tuple(tuple(column[k] for column in columns) for k in range(3)),
        )
    )


def _angle(layout: WorkspaceLayout, g: Graph, link: str) -> tuple[int, int, int]:
    """Angle β, β̇ = d × v / l² and β̈ = (d × a − 2 (d · v) β̇) / l² of a link."""
    terms = {name: (x, y) for name, x, y in layout.assembly.nodes}
    first, second = (terms[node] for node in layout.assembly.scene.links[link].nodes)
    (dx, dy), (vx, vy), (ax, ay) = (
        tuple(
            g.sub(
                layout.node(g, end, order),
                layout.node(g, start, order),
            )
            for start, end in zip(first, second, strict=True)
        )
        for order in range(3)
    )
    square = g.add(g.mul(dx, dx), g.mul(dy, dy))
    rate = g.div(g.sub(g.mul(dx, vy), g.mul(dy, vx)), square)
    coriolis = g.mul(g.const(2), g.mul(g.add(g.mul(dx, vx), g.mul(dy, vy)), rate))
    acceleration = g.div(g.sub(g.sub(g.mul(dx, ay), g.mul(dy, ax)), coriolis), square)
    return g.atan2(dy, dx), rate, acceleration
