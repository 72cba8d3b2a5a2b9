"""A force or a torque on a body, in frame O or in the body frame."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from kousoku.model.elements.checks import check_only_point
from kousoku.model.elements.force import ForceKind
from kousoku.model.errors import SceneError
from kousoku.model.mechanics.multibody import GROUND_INDEX, ForceElement
from kousoku.model.records.dotted_keys import require_known

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.elements.force import Constants, Formulas, Lowering
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.numbers.precise import High, Triple
    from kousoku.model.records.loads import Force
    from kousoku.model.records.orientation import Vector
    from kousoku.model.records.scene import Scene

AXES = "xyz"


@dataclass(frozen=True, slots=True)
class Load(ForceElement):
    """A force or torque on body j; i is the ground.

    Of ``constants`` ``s_j_b`` (3,) [m] is the point of a force; all others are vectors (3,) that
    are added up: ``force`` F [N] or ``torque`` N [N m], and a further one for each component that
    is a formula, such as ``force_x``. Formulas may depend on the motion. A force has the torque
    s̃′AᵀF about the centre of mass; three mass points, (torque-definition).

    Parameters
    ----------
    kind : {"force", "force_b", "torque", "torque_b"}
        Vectors of ``force`` and ``torque`` are in frame O, of ``force_b`` and ``torque_b``, which
        turn with the body, in its principal frame.
    """

    kind: str

    @property
    def is_torque(self) -> bool:
        """Whether it is a torque."""
        return self.kind.startswith("torque")

    @property
    def is_body_fixed(self) -> bool:
        """Whether its vectors are fixed in the body."""
        return self.kind.endswith("_b")

    @property
    def has_potential(self) -> bool:
        """Whether it has a potential: a force that is constant in frame O; no torque has one."""
        return not (self.is_torque or self.is_body_fixed or self.formulas)

    @property
    def vectors(self) -> tuple[Vector, ...]:
        """Summands (n, 3) [N or N m] of the load, without the values of formulas."""
        rows = (values for name, values in self.constants if name != "s_j_b")
        return tuple((x, y, z) for x, y, z in rows)


class OnBody(ForceKind):
    """Force or torque on a body."""

    name: ClassVar[str]

    def check(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse a load on no body, without components, or with those of both frames."""
        if force.body is None:
            raise SceneError("is missing; wanted the body that it acts on", key=f"{key}.body")
        require_known("body", force.body, scene.bodies, f"{key}.body")
        fixed, turning = (getattr(force, name) for name in (self.name, f"{self.name}_b"))
        if fixed is None and turning is None:
            raise SceneError(
                f"is missing; wanted its components in frame O, or in the body frame as "
                f"'{self.name}_b'",
                key=f"{key}.{self.name}",
            )
        if fixed is not None and turning is not None:
            raise SceneError(
                f"is given in frame O too, as {self.name}; wanted one of them",
                key=f"{key}.{self.name}_b",
            )
        if isinstance(fixed, str | float):
            raise SceneError(
                "is one number; wanted three components in frame O", key=f"{key}.{self.name}"
            )
        if scene.bodies[force.body].point:
            self._check_on_point(scene, force, key)

    @abstractmethod
    def _check_on_point(self, scene: Scene, force: Force, key: str) -> None:
        """Refuse keys that a point mass cannot have."""

    def kind_of(self, force: Force) -> str:
        """Kind of its element."""
        return self.name if getattr(force, self.name) is not None else f"{self.name}_b"

    def vectors(
        self, force: Force, kind: str, frame: BodyFrame, unit: High
    ) -> tuple[Constants, Formulas]:
        """Summands (3,) [N or N m] of the load, and the formulas of some of them.

        Components that are numbers make one vector. Each that is a formula stands beside the
        direction that it belongs to, in frame O or in the principal frame: F = F₀ + Σ f e.
        """
        from kousoku.model.mechanics.frames import to_vector
        from kousoku.model.numbers import precise

        turns = kind != self.name

        def converted(vector: Triple) -> Vector:
            return to_vector(precise.scale(unit, frame.principal(vector) if turns else vector))

        components = getattr(force, kind)
        numbers = [0.0 if isinstance(value, str) else value for value in components]
        constants = [(self.name, converted(precise.triple((numbers[0], numbers[1], numbers[2]))))]
        formulas = []
        for k, value in enumerate(components):
            if isinstance(value, str):
                x, y, z = (float(k == m) for m in range(3))
                constants.append((f"{self.name}_{AXES[k]}", converted(precise.triple((x, y, z)))))
                formulas.append((f"{self.name}_{AXES[k]}", value))
        return tuple(constants), tuple(formulas)


class ForceOnBody(OnBody):
    """A force F (3,) [N] on a point of a body, in frame O or the body's: F and s̃′AᵀF."""

    name = "force"
    title = "a force on a body"
    keys = ("body", "point", "force", "force_b")

    def _check_on_point(self, scene: Scene, force: Force, key: str) -> None:
        if force.force_b is not None:
            raise SceneError(
                "a point has no axes of its own; wanted 'force', in frame O", key=f"{key}.force_b"
            )
        check_only_point(scene, force.body or "", force.point, f"{key}.point")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Element of the force: s′ (3,) [m] in the principal frame, F (3,) [N] in its frame."""
        from kousoku.model.numbers import precise

        frame = lowering.frames[force.body or ""]
        kind = self.kind_of(force)
        vectors, formulas = self.vectors(force, kind, frame, lowering.unit)
        point = precise.triple(force.point or (0.0, 0.0, 0.0))
        constants = (("s_j_b", frame.point(point, lowering.unit)), *vectors)
        yield Load(name, kind, GROUND_INDEX, frame.index, constants, formulas=formulas)


class TorqueOnBody(OnBody):
    """A torque N (3,) [N m] on a body, N′ = AᵀN where it is given in frame O."""

    name = "torque"
    title = "a torque on a body"
    keys = ("body", "torque", "torque_b")

    def _check_on_point(self, scene: Scene, force: Force, key: str) -> None:
        raise SceneError("a point does not turn; wanted a body", key=f"{key}.body")

    def elements(self, name: str, force: Force, lowering: Lowering) -> Iterator[ForceElement]:
        """Element of the torque: N (3,) [N m] in its frame."""
        frame = lowering.frames[force.body or ""]
        kind = self.kind_of(force)
        vectors, formulas = self.vectors(force, kind, frame, lowering.unit * lowering.unit)
        yield Load(name, kind, GROUND_INDEX, frame.index, vectors, formulas=formulas)
