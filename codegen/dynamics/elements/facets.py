"""Facets of a force: in a program, in the analyses before it, and in the check beside it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from kousoku.codegen.dynamics.operations.placement import seen_from_carriers
from kousoku.model.mechanics.multibody import ForceElement
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import (
        AppliedForces,
        BodyMotion,
        NewtonEulerEquations,
    )
    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.operations.jets import Jet
    from kousoku.codegen.dynamics.operations.placement import Placement
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System
    from kousoku.model.numbers.real import Real
    from kousoku.model.records.orientation import Vector

    #: Source of a force of the ground, which follows from its kind and constants.
    Source = Instance | RelativeCoordinate

E = TypeVar("E", bound=ForceElement)


@dataclass(frozen=True, slots=True)
class Applied:
    """Force and torque from outside on the part of a system that the bodies belong to.

    Parameters
    ----------
    forces, torques : tuple of (3,) [N, N m], or None
        Directions of frame O, whatever the position; None where they may be any.
    """

    forces: tuple[Vector, ...] | None = ()
    torques: tuple[Vector, ...] | None = ()


class ForceFacets(ABC, Generic[E]):
    """A force, in its program, in analyses, and in the check beside the program.

    Its load on a body is f = (F, N′) (6,): F [N] in frame O, N′ [N m] about the centre of mass in
    the principal frame. Without a statement here the worst is assumed: a force leaves every plane,
    keeps its bodies from being joined with others, and no momentum of a part that it acts on is
    constant.

    Parameters
    ----------
    force : ForceElement
        The element of the system.

    Attributes
    ----------
    is_carried : bool
        Whether it means the same between other bodies once :meth:`seen_from` moved its numbers.
    """

    is_carried: ClassVar[bool] = False

    def __init__(self, force: E) -> None:
        self.force = force

    # In a program.

    @abstractmethod
    def effect(self, tasks: ForceRecorder) -> tuple[SlotMatrix, ...]:
        """M⁻¹f (c, 1) [m/s², rad/s²] of body i and of body j, then the power (1, 1) [W], recorded.

        The power is that of the part without potential energy; it may be missing where no force is
        nonconservative, see :class:`~kousoku.model.mechanics.multibody.ForceElement`. The share of
        the ground is ignored.
        """

    def energy(self, tasks: ForceRecorder) -> SlotMatrix:
        """Energies (0, V) (2,) [J], recorded, of a force f = −∂V/∂q that has a potential energy."""
        raise NotImplementedError(f"no energy of a force of kind {self.force.kind}")

    def elongation(
        self, tasks: ForceRecorder
    ) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix, SlotMatrix]:
        """Arguments (1,) of its law, recorded: a value, its rate, the free value, the unit."""
        raise NotImplementedError(f"no elongation of a force of kind {self.force.kind}")

    # In analyses.

    def leaves_plane(self, system: System, normal: int) -> bool:
        """Whether it leads a system that starts in a coordinate plane out of it.

        Parameters
        ----------
        system : System
            A scene, with fixed numbers.
        normal : int
            Which axis is normal to the plane; it is so in all principal frames.
        """
        return True

    def seen_from(self, i: Placement, j: Placement) -> E:
        """Force between the bodies that carry its own: s′ → at + A s′, a′ → A a′.

        ``s_i_b`` and ``s_j_b`` are points (3,) [m], others that end in ``_i_b`` and ``_j_b``
        vectors.
        """
        constants = seen_from_carriers(self.force.constants, i, j)
        return replace(self.force, i=i.carrier, j=j.carrier, constants=constants)

    def resting_energy(self, i: Placement, j: Placement) -> Real:
        """Potential energy V, a number [J], where both bodies are carried by one."""
        energy: Real = precise.number(0.0)
        return energy

    def applied(self) -> Applied:
        """Forces and torques that it applies from outside to the part that its bodies belong to."""
        return Applied(None, None)

    def source(self, system: System) -> Source | None:
        """Source of the force of the ground through it, where that is not :meth:`applied`."""
        return None

    # In the check beside the program.

    def length_by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        constants: Mapping[str, Sequence[Real]],
    ) -> tuple[Jet, Real]:
        """Value of its law's argument along a motion, by geometry, and the free value.

        They are [m] or [rad], whatever the unit of the law; parameters are those of
        :meth:`by_definition`.
        """
        raise NotImplementedError(f"no elongation of a force of kind {self.force.kind}")

    @abstractmethod
    def by_definition(
        self,
        equations: NewtonEulerEquations,
        courses: Mapping[int, BodyMotion],
        names: Mapping[str, Jet],
        constants: Mapping[str, Sequence[Real]],
        loads: AppliedForces,
    ) -> tuple[Real, Real]:
        """Add f to the equations M v̇ = f of each body; return the power and the potential energy.

        The force is stated again, from its geometric definition: no kernel, no operation and
        nothing of :meth:`effect` has a part in it. Power [W] and energy [J] are numbers.

        Parameters
        ----------
        equations : NewtonEulerEquations
            Equations of the bodies, with ``apply_force`` and ``apply_torque``.
        courses : mapping of int to BodyMotion
            Courses of the bodies, by their indices; of the ground, too.
        names : mapping of str to Jet
            Values that formulas may name.
        constants : mapping of str to sequence of number
            Its constants, those that have a formula multiplied by it: points (3,) [m] in the
            principal frames, vectors in theirs.
        loads : AppliedForces
            Forces at the state, to which f is added.
        """
