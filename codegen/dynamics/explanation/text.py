"""The text of an explanation: steps that a scene does not need, their savings, and the rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.text import counted, table
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.explanation.explain import Explanation

#: Joints that a line names.
MOST_JOINTS_SHOWN = 12


def explanation_text(explanation: Explanation) -> str:
    """Explanation as tables and lines."""
    total = sum(count for _, count in explanation.segments)
    parts = [
        table(
            ("step", "rows", "columns", "operations", "bytes", "what"),
            [
                (x.name, *(_saved(n) for n in (x.rows, x.columns, x.operations, x.bytes)), x.detail)
                for x in explanation.steps
            ],
            title=f"{explanation.name}: what each step saves",
        ),
        "",
        table(
            ("segment", "operations"),
            [(name, str(count)) for name, count in (*explanation.segments, ("all", total))],
            title="what remains",
        ),
        _structure(explanation),
        *_lines(explanation),
    ]
    return "\n".join(parts)


def _structure(explanation: Explanation) -> str:
    """Sizes of the equations that are solved."""
    s = explanation.structure
    return (
        f"{s.positions} coordinates, {s.velocities} velocities"
        f"{f', {s.dependent} of which follow from the others' if s.dependent else ''},"
        f" {counted(s.rows, 'row')}; C_q has"
        f" {s.elements} elements that are not zero, S {s.schur} in its lower triangle, its factors"
        f" {s.fill_in} more; solved in {counted(s.parts, 'part')}"
        f"{', in a coordinate plane' if explanation.is_planar else ''}"
    )


def _saved(count: int) -> str:
    return str(count) if count else ""


def _lines(explanation: Explanation) -> list[str]:
    """Lines about freedoms and dependences."""
    freedom, removed = explanation.freedom, explanation.removed
    degrees = counted(freedom.degrees, "degree")
    lines = [f"{degrees} of freedom: {freedom.columns} velocities less rank {freedom.rank}"]
    if not freedom.degrees:
        lines.append(
            f"the motion is that of {_named(explanation.drivers)}"
            if explanation.drivers
            else "nothing can move"
        )
    for group in freedom.dependent:
        where = (
            f"along the branch, {freedom.positions} positions looked at"
            if group.is_everywhere
            else "at the start only, where other motions branch off or end"
        )
        rows = counted(group.dimension, "row")
        verb = "depends" if group.dimension == 1 else "depend"
        lines.append(
            f"{rows} of {group.rows} {verb} on the others of {_named(group.joints)}: {where}"
        )
    if removed:
        lines.append(
            f"left out: {_named(removed)}; the others keep their rank at all of these positions,"
            f" {freedom.worst:.2g} of 1 at the worst"
        )
    if freedom.not_unique:
        lines.append(f"reactions are not unique at {_named(freedom.not_unique)}")
    if freedom.unknown:
        lines.append(
            f"dependent rows were not looked for in loops with too many rows, those of"
            f" {_named(freedom.unknown)}: degrees of freedom are at least that"
        )
    return lines


def _named(names: Sequence[str]) -> str:
    return listed(names, MOST_JOINTS_SHOWN)
