"""Keys of a scene that depend on a type: those of joints, couplings, forces and drivers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements import drivers
from kousoku.model.elements.forces import FORCES
from kousoku.model.elements.joints import inputs_of, keys_of
from kousoku.model.records.loads import Force
from kousoku.model.records.spatial import Driver, Joint

if TYPE_CHECKING:
    from collections.abc import Mapping

    import msgspec

    from kousoku.model.elements.inputs import ElementInput
    from kousoku.model.records.own_kind import OwnInput, OwnKind


def keys_of_type(record: type[msgspec.Struct], sort: object) -> tuple[str, ...]:
    """Keys of a record of a type, none where there is no such type."""
    if not isinstance(sort, str):
        return ()
    if record is Joint:
        return keys_of(sort)
    if record is Force and sort in FORCES:
        return ("type", *FORCES[sort].all_keys)
    return ()


def own_inputs(
    record: type[msgspec.Struct], sort: str, kinds: Mapping[str, OwnKind]
) -> Mapping[str, OwnInput | ElementInput] | None:
    """Inputs that a type alone has: a shipped one, or a kind of one's own.

    Drivers have no type: they may have the inputs of all kinds of drivers. None for an unknown type
    of joints, whose keys are unknown, too: the check of types reports it.
    """
    if record is Driver:
        return drivers.own_inputs()
    if record is Force:
        return FORCES[sort].inputs if sort in FORCES else {}
    if keys_of(sort):
        return inputs_of(sort)
    return kinds[sort].inputs if sort in kinds else None
