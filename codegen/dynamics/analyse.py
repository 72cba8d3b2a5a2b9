"""Analyses of a system before it is composed, one after the other.

Each takes the system that the one before it returns, and returns its results with it:

1. bodies that fixed joints hold together become one, ``simplification/lump.py``;
2. the plane in which all bodies stay, if there is one, ``simplification/planarity.py``;
3. masses where drivers move what has none, ``simplification/placeholder_masses.py``;
4. rows and columns that are not structurally zero, ``simplification/outline.py``;
5. rows that depend on others, and degrees of freedom, ``redundancy/freedom.py``.

Whether the coordinates of joints with the ground describe bodies is left open here: ``choose.py``
composes without them and with them, as :func:`with_joint_coordinates` finds them, and keeps the
program that costs less. Composing itself decides nothing of all that.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.operations.body_coordinates import (
    require_few_joints,
    require_masses,
    with_all_inertias,
)
from kousoku.codegen.dynamics.redundancy.constant_rows import require_constant_rows_hold
from kousoku.codegen.dynamics.redundancy.freedom import Mobility, mobility_of
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.redundancy.mass_ratio import has_extreme_mass_ratio
from kousoku.codegen.dynamics.redundancy.own_rows import repeated_rows, require_own_rows_implied
from kousoku.codegen.dynamics.redundancy.redundant_rows import by_instance, shares_out, take_over
from kousoku.codegen.dynamics.simplification.axis_permutation import (
    Plane,
    permuted,
    permuted_columns,
    permuted_rows,
    shift_of,
)
from kousoku.codegen.dynamics.simplification.conserved_momenta import conserved_momenta
from kousoku.codegen.dynamics.simplification.ground_joints import velocity_transformations_of
from kousoku.codegen.dynamics.simplification.lump import lump
from kousoku.codegen.dynamics.simplification.outline import outline_of
from kousoku.codegen.dynamics.simplification.placeholder_masses import with_placeholder_masses
from kousoku.codegen.dynamics.simplification.planarity import plane_of
from kousoku.model.errors import SceneError
from kousoku.model.lowering.parametric import fixed_system

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import ConservedMomenta, RowIndex
    from kousoku.codegen.dynamics.simplification.ground_joints import VelocityTransformation
    from kousoku.codegen.dynamics.simplification.outline import Outline
    from kousoku.model.mechanics.multibody import System

#: Most velocities that a joint leaves to a body: none where drivers lead it, and any number.
PRESCRIBED, ANY = 0, 6
#: Outputs that depend on masses.
MASS_OUTPUTS = ("reactions", "energies")


@dataclass(frozen=True, slots=True)
class Analysed:
    """System with all decisions on its equations.

    Parameters
    ----------
    system : System
        System whose equations are solved.
    outline : Outline
        Its plane, and rows and columns that are not structurally zero.
    mobility : Mobility
        Its degrees of freedom, and the rows that are left out.
    transformations : mapping of int to VelocityTransformation
        Bodies that the coordinates of their joint with the ground describe, in the axes of the
        plane; where there are some no row is left out.
    lumped : tuple of str
        Fixed joints that are left out with their rows, as their bodies are one.
    missing : tuple of str
        Keys of masses and moments that bodies lack and their motion may depend on.
    thin : tuple of str
        Those keys of ``missing`` whose bodies have their mass on a line: one moment is zero.
    """

    system: System
    outline: Outline
    mobility: Mobility
    transformations: Mapping[int, VelocityTransformation] = field(default_factory=dict)
    lumped: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    thin: tuple[str, ...] = ()

    @property
    def solved(self) -> list[RowIndex]:
        """Rows that have multipliers."""
        others = {*self.satisfied, *self.left_out}
        rows = self.outline.rows
        return [row for row in rows if row not in others] if others else list(rows)

    @property
    def satisfied(self) -> list[RowIndex]:
        """Rows that hold by themselves: those of joints whose coordinates describe bodies."""
        indices = {index for body in self.transformations.values() for index in body.instances}
        return [row for row in self.outline.rows if row.instance in indices]

    @property
    def left_out(self) -> list[RowIndex]:
        """Rows that depend on others."""
        dropped = set(self.mobility.dropped)
        return [row for row in self.outline.rows if row in dropped] if dropped else []

    @property
    def has_loops(self) -> bool:
        """Whether joints close loops, in which rows may become dependent somewhere."""
        return bool(loops_of(self.system))

    @property
    def refines(self) -> bool:
        """Whether a run may have to refine accelerations, where C_q M⁻¹ C_qᵀ loses digits."""
        return bool(self.left_out) or self.has_loops or has_extreme_mass_ratio(self.system)

    @property
    def takes_over(self) -> bool:
        """Whether rows that are left out take over where those that are solved lose rank."""
        return take_over(len(self.solved), len(self.left_out))

    @property
    def shares_out(self) -> bool:
        """Whether loops compute forces that are not unique, and not code of the scene."""
        return shares_out(len(self.solved), len(self.left_out))

    @property
    def momenta(self) -> tuple[ConservedMomenta, ...]:
        """Momenta that parts of the system conserve, in the axes of the plane."""
        return conserved_momenta(in_xy_plane(self).system, is_planar=self.outline.is_planar)


def analyse(system: System, wanted: Collection[str]) -> Analysed:
    """Assembled system with the results of all analyses that need no program.

    Parameters
    ----------
    system : System
        A scene, assembled.
    wanted : collection of str
        Outputs that are computed; with ``reactions`` no bodies are lumped.

    Raises
    ------
    SceneError, AssemblyError
        Bodies lack masses, rows do not hold, or depend on each other where they must not.
    """
    lumps = lump(system, wanted)
    plane = plane_of(lumps.system)
    with_masses = with_placeholder_masses(lumps.system, plane)
    missing, thin = with_masses.missing, with_masses.thin
    analysed = ranked(with_masses.system, plane)
    return replace(analysed, lumped=lumps.joints, missing=missing, thin=thin)


def with_all_rows(system: System, plane: Plane | None) -> Analysed:
    """System whose rows are all kept.

    Parameters
    ----------
    system : System
        A scene.
    plane : Plane, optional
        Its plane, as :func:`~kousoku.codegen.dynamics.simplification.planarity.plane_of` finds it;
        None for equations in space.

    Raises
    ------
    SceneError
        A body lacks a mass or a moment that its motion needs, or has too many joints.
    """
    require_few_joints(system)
    require_masses(permuted(system, shift_of(plane)), is_planar=plane is not None)
    outline = outline_of(system, plane)
    return Analysed(system, outline, Mobility.of(outline))


def ranked(system: System, plane: Plane | None) -> Analysed:
    """System without the rows that depend on others, at positions where the others hold.

    Parameters and refusals are those of :func:`with_all_rows`; rows that nothing changes must hold.
    """
    analysed = with_all_rows(system, plane)
    fixed = fixed_system(system)
    require_constant_rows_hold(fixed, analysed.outline)
    mobility = mobility_of(fixed, analysed.outline)
    require_own_rows_implied(fixed, mobility, is_planar=analysed.outline.is_planar)
    mobility = replace(mobility, idle=(*mobility.idle, *repeated_rows(fixed, mobility)))
    if mobility.closed:
        system = assemble(system, [(row.instance, row.row) for row in mobility.dropped])
        analysed = with_all_rows(system, plane and plane_of(system))
    return replace(analysed, mobility=mobility)


def with_joint_coordinates(analysed: Analysed, most_free: int) -> Analysed:
    """System in which bodies on joints with the ground have the coordinates of these.

    Parameters
    ----------
    analysed : Analysed
        The system in absolute coordinates, with all its rows.
    most_free : int
        Most velocities that a joint may leave to a body.
    """
    in_plane, is_planar = in_xy_plane(analysed), analysed.outline.is_planar
    rows = by_instance(in_plane.outline.rows)
    candidates = velocity_transformations_of(in_plane.system, rows, is_planar=is_planar)
    transformations = {k: body for k, body in candidates.items() if len(body.free) <= most_free}
    if not transformations:
        return analysed
    system = analysed.system if is_planar else with_all_inertias(analysed.system)
    return replace(analysed, system=system, transformations=transformations)


def in_xy_plane(analysed: Analysed) -> Analysed:
    """System with its axes in an order in which its plane, if any, is the xy-plane."""
    if not (shift := shift_of(analysed.outline.plane)):
        return analysed

    def in_axes(rows: Sequence[RowIndex]) -> tuple[RowIndex, ...]:
        return permuted_rows(rows, analysed.system, shift)

    outline, mobility = analysed.outline, analysed.mobility
    columns = tuple(permuted_columns(body_columns, shift) for body_columns in outline.columns)
    return replace(
        analysed,
        system=permuted(analysed.system, shift),
        outline=replace(outline, plane=Plane.XY, columns=columns, rows=in_axes(outline.rows)),
        mobility=replace(mobility, dropped=in_axes(mobility.dropped), idle=in_axes(mobility.idle)),
    )


def require_driven(analysed: Analysed, wanted: Collection[str]) -> None:
    """Refuse quantities that depend on masses that are missing.

    Raises
    ------
    SceneError
        Drivers leave freedoms, or what is wanted depends on masses; the message names a body that
        lacks one.
    """
    if not analysed.missing:
        return
    key = analysed.missing[0]
    lack, give = "is missing", "give it"
    if key in analysed.thin:
        lack = "has a moment of zero, as of a rod without thickness, about an axis of turning"
        give = "give the body some thickness, as of a cylinder"
    more = f" (one of {len(analysed.missing)} such)" if len(analysed.missing) > 1 else ""
    if analysed.mobility.degrees > 0:
        raise SceneError(
            f"{lack}, and drivers leave {analysed.mobility.degrees} of the freedoms, whose motion"
            f" depends on it{more}; {give}, or drive them",
            key=key,
        )
    for name in MASS_OUTPUTS:
        if name in wanted:
            raise SceneError(
                f"asks for {name}, which depend on {key}, and it {lack}{more}; {give}, or"
                f" leave {name} out: positions, velocities and accelerations need no mass here",
                key="outputs",
            )
