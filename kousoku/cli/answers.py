"""Records that commands print with ``--json``; ``kousoku schema --json`` is made of them.

A key is never taken away, and never means something else, without another number of the format;
keys may be added. A number that is not finite is the text ``"inf"``, ``"-inf"`` or ``"nan"``.
"""

# Annotations are evaluated: msgspec makes the schemas of them.
from typing import Any, Literal, TypedDict

import msgspec

from kousoku.cli.console import ANSWER_FORMAT

JsonNumber = float | Literal["inf", "-inf", "nan"]


class Shelf(TypedDict):
    """Share of one sort of files in the cache."""

    entries: int
    bytes: int


class Cache(TypedDict):
    """Answer of ``kousoku cache``; ``limit`` is the bytes that it may take."""

    format: int
    folder: str
    limit: int
    removed: int
    shelves: dict[str, Shelf]


class Remark(TypedDict):
    """A problem or a note: line of the file, 0 where there is none, key, what, and all as text."""

    line: int
    key: str
    problem: str
    text: str


class CheckedScene(TypedDict):
    """Scene file that was checked; ``what`` is empty where it is not valid."""

    file: str
    is_valid: bool
    what: str
    problems: list[Remark]
    notes: list[Remark]


class CheckAnswer(TypedDict):
    """Answer of ``kousoku check``."""

    format: int
    scenes: list[CheckedScene]


class DerivationStep(TypedDict):
    """An equation, the rule that gives it, and the number of the equation where it has one."""

    left: str
    right: str
    latex: str
    rule: str
    equation: str


class DerivedFunction(TypedDict):
    """A function that a derivation ends in."""

    name: str
    formula: str
    source: str
    inputs: list[str]
    outputs: list[str]


class Derive(TypedDict):
    """Answer of ``kousoku derive``."""

    format: int
    name: str
    kind: str
    title: str
    source: str
    steps: list[DerivationStep]
    functions: list[DerivedFunction]


class ExplainedStep(TypedDict):
    """Saving of a step in a solver: rows, columns, operations, bytes of the workspace."""

    name: str
    detail: str
    rows: int
    columns: int
    operations: int
    bytes: int


class StructureAnswer(TypedDict):
    """Structure that remains to be solved; dense, schur and fill_in are counts of elements."""

    positions: int
    velocities: int
    dependent: int
    rows: int
    elements: int
    dense: int
    schur: int
    fill_in: int
    parts: int


class DependentRows(TypedDict):
    """Rows that depend on each other, and how many of them are too many."""

    joints: list[str]
    rows: int
    dimension: int
    is_everywhere: bool


class DroppedRow(TypedDict):
    """A row that is left out."""

    joint: str
    instance: int
    row: int


class ClosedRow(TypedDict):
    """A row that others imply but for the closure tolerance, in lengths of the scene or rad."""

    row: DroppedRow
    is_length: bool
    pivot: JsonNumber
    missed: JsonNumber


class FreedomAnswer(TypedDict):
    """Degrees of freedom, and the rows of constraints that depend on others."""

    columns: int
    rows: int
    rank: int
    dependent: list[DependentRows]
    dropped: list[DroppedRow]
    worst: JsonNumber
    positions: int
    unknown: list[str]
    drivers: int
    idle: list[DroppedRow]
    closed: list[ClosedRow]
    undetermined: list[tuple[str, list[str]]]
    degrees: int
    not_unique: list[str]


class ExplainBodies(TypedDict):
    """Answer of ``kousoku explain`` for a scene of bodies; segments have operations."""

    format: int
    name: str
    is_planar: bool
    steps: list[ExplainedStep]
    segments: dict[str, int]
    structure: StructureAnswer
    freedom: FreedomAnswer
    removed: list[str]
    drivers: list[str]


class BlockAnswer(TypedDict):
    """Unknowns that are solved together, and the rows that hold them."""

    unknowns: int
    rows: int


class ExplainLinkage(TypedDict):
    """Answer of ``kousoku explain`` for a linkage of nodes; kernels have operations."""

    format: int
    name: str
    inputs: int
    blocks: list[BlockAnswer]
    kernels: dict[str, int]


class WrittenPackage(TypedDict):
    """A folder, and the files in it that are others than before."""

    folder: str
    changed: list[str]


class Generate(TypedDict):
    """Answer of ``kousoku generate``."""

    format: int
    packages: list[WrittenPackage]


class GenerateCheck(TypedDict):
    """Answer of ``kousoku generate --check``, a line each; foreign are files of the user."""

    format: int
    ok: bool
    differences: list[str]
    foreign: list[str]


class LedgerEntry(TypedDict):
    """An equation of the documents; the proof is empty where it failed."""

    document: str
    title: str
    equation: str
    aliases: list[str]
    kind: Literal["sentence", "equation"]
    verdict: Literal["holds", "notation", "misprint"]
    printed: str
    corrected: str
    reason: str
    proof: str


class LedgerAnswer(TypedDict):
    """Answer of ``kousoku ledger``."""

    format: int
    entries: list[LedgerEntry]


class PackageAnswer(TypedDict):
    """A generated package; kind is null where it is none."""

    name: str
    kind: str | None
    title: str
    aliases: list[str]
    kernels: list[str]


class Listing(TypedDict):
    """Answer of ``kousoku list``."""

    format: int
    packages: list[PackageAnswer]


class CatalogEntry(TypedDict):
    """Thing that a scene may have, and what it is given by."""

    name: str
    title: str
    aliases: list[str]
    keys: dict[str, str]


class ListedSection(TypedDict):
    """Answer of ``kousoku list joints``."""

    format: int
    section: str
    entries: list[CatalogEntry]


class MovedByAssembly(TypedDict):
    """Change of a body by assembly; velocities where the scene gives one."""

    moved: JsonNumber
    turned: JsonNumber
    velocity: JsonNumber
    angular_velocity: JsonNumber


class ViolationAnswer(TypedDict):
    """Residuals of a joint's constraints: positions, velocities [1/s], accelerations [1/s²]."""

    metres: list[JsonNumber]
    radians: list[JsonNumber]


class MomentumAnswer(TypedDict):
    """Largest change of a momentum that nothing should change [kg m/s, kg m²/s]."""

    bodies: list[str]
    linear: JsonNumber | None
    angular: JsonNumber | None
    about: str


class ErrorEstimateAnswer(TypedDict):
    """Distance of the rows of a second run by another method."""

    length: JsonNumber
    angle: JsonNumber
    unit: str
    method: str
    unknown_from: JsonNumber | None
    stop: str


class TrustAnswer(TypedDict):
    """Trust that a run deserves, and what speaks against it."""

    is_trusted: bool
    energy_error: JsonNumber | None
    energy_moved: JsonNumber | None
    work_error: JsonNumber | None
    constraints: JsonNumber | None
    missed: JsonNumber
    closure_tolerance: JsonNumber
    drift: JsonNumber | None
    row_drift: JsonNumber | None
    pivot_ratio: JsonNumber | None
    unresolved: int
    impulse: JsonNumber | None
    impulse_time: JsonNumber | None
    stillness: JsonNumber | None
    below_tolerance: dict[str, JsonNumber]
    branch_point_time: JsonNumber | None
    meeting_time: JsonNumber | None
    error: ErrorEstimateAnswer | None
    limit: JsonNumber
    problems: list[str]


class RunLedgerAnswer(TypedDict):
    """Cost of a run, and how far it can be trusted; in metres, joules, seconds."""

    method: str
    tolerance: JsonNumber
    fixed_step: JsonNumber | None
    parameters: dict[str, JsonNumber]
    steps: int
    rejected: int
    derivatives: int
    factorisations: int
    corrections: int
    drift: JsonNumber
    avoided: int
    growth: JsonNumber
    growth_time: JsonNumber
    passed: int
    passed_time: JsonNumber | None
    unresolved: int
    unresolved_time: JsonNumber | None
    branch_points: int
    branch_point_time: JsonNumber | None
    meetings: int
    meeting_time: JsonNumber | None
    fallbacks: int
    fallback_time: JsonNumber | None
    refinements: int
    energy: JsonNumber | None
    energy_error: JsonNumber | None
    works: dict[str, JsonNumber]
    momenta: list[MomentumAnswer]
    violations: dict[str, ViolationAnswer]
    missed: dict[str, list[JsonNumber]]
    released: list[str]
    moved: dict[str, MovedByAssembly]
    events: dict[str, int]
    seconds: dict[str, JsonNumber]


class EventAnswer(TypedDict):
    """Event of a run: its action, how often it was, and when, unless it is only counted."""

    action: Literal["record", "count", "stop"]
    count: int
    times: list[JsonNumber]


class MovedBodies(TypedDict):
    """Answer of ``simulate`` and ``solve`` for a run of bodies; errors are null there."""

    format: int
    scene: str
    target: str
    rows: int
    bodies: list[str]
    is_complete: bool
    stopped_by: str
    events: dict[str, EventAnswer]
    not_unique: list[str]
    undetermined: dict[str, list[str]]
    reaction_length: JsonNumber
    notes: list[str]
    trust: TrustAnswer
    ledger: RunLedgerAnswer
    seconds: dict[str, JsonNumber]
    errors: dict[str, JsonNumber] | None
    plots: list[str]


class IterationsAnswer(TypedDict):
    """Corrections in a step, and in all of them."""

    min: int
    max: int
    total: int


class MovedLinkage(TypedDict):
    """Answer of ``simulate`` and ``solve`` for a linkage; errors are those of the closed form."""

    format: int
    scene: str
    unit: str
    target: str
    method: str
    divisions: int
    rows: int
    iterations: IterationsAnswer
    residual_max: JsonNumber
    condition_max: JsonNumber
    turn_gaps: dict[str, JsonNumber]
    seconds: dict[str, JsonNumber]
    errors: dict[str, JsonNumber] | None
    plots: list[str]


class VerifiedRow(TypedDict):
    """The worst error of an output in one way of calling, in units of rounding."""

    kernel: str
    output: str
    way: str
    worst: JsonNumber
    element: list[int]
    point: int
    label: str
    inputs: dict[str, str]
    got: JsonNumber
    wanted: JsonNumber
    limit: JsonNumber
    ok: bool


class VerifiedPackage(TypedDict):
    """Whether a package computes what was derived."""

    package: str
    folder: str
    ok: bool
    limit: JsonNumber
    rows: list[VerifiedRow]
    problems: list[str]
    notes: list[str]


class Verify(TypedDict):
    """Answer of ``kousoku verify``."""

    format: int
    ok: bool
    limit: JsonNumber
    packages: list[VerifiedPackage]


MOVED = MovedBodies | MovedLinkage
#: What each command prints.
ANSWERS: dict[str, Any] = {
    "cache": Cache,
    "check": CheckAnswer,
    "derive": Derive,
    "explain": ExplainBodies | ExplainLinkage,
    "generate": Generate | GenerateCheck,
    "ledger": LedgerAnswer,
    "list": Listing | ListedSection,
    "simulate": MOVED,
    "solve": MOVED,
    "verify": Verify,
}


def answer_schema(command: str) -> dict[str, Any]:
    """JSON schema of what a command prints with ``--json``."""
    records = getattr(ANSWERS[command], "__args__", (ANSWERS[command],))
    refs, parts = msgspec.json.schema_components(records, ref_template="#/$defs/{name}")
    for name in {record.__name__ for record in records}:
        parts[name]["properties"]["format"] = {"const": ANSWER_FORMAT}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"kousoku {command} --json",
        "anyOf": _with_short_names([*refs]),
        "$defs": {_short(name): _with_short_names(part) for name, part in parts.items()},
    }


def _short(name: str) -> str:
    """Name of a record in a schema, where nothing else has it: without ``Answer``."""
    return name.removesuffix("Answer")


def _with_short_names(part: Any) -> Any:
    """Part of a schema whose references and titles have the short names of records."""
    if isinstance(part, list):
        return [_with_short_names(item) for item in part]
    if not isinstance(part, dict):
        return part
    return {
        key: _short(value)
        if key in {"$ref", "title"} and isinstance(value, str)
        else _with_short_names(value)
        for key, value in part.items()
    }
