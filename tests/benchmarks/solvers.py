"""Solvers: the time to an error, of kousoku and of what one would use instead."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tests.benchmarks.kit import (
    KINDS,
    BenchmarkTarget,
    Figures,
    Question,
    Record,
    Size,
    bullet_list,
    duration,
    number,
    table,
)
from tests.benchmarks.plots import ToolLine, work_precision
from tests.benchmarks.problems import linkage
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.problem import GROWTH, ROWS
from tests.benchmarks.race import TOO_LONG

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from tests.benchmarks.kit import Case

#: Errors at which tools are compared, and those that targets judge.
LEVELS = (1e-3, 1e-6, 1e-8, 1e-10)
JUDGED = (1e-6, 1e-10)
#: What has to give the error that is promised.
TIGHT = "tolerance 1e-12"
TITLES = {linkage.CONTEST: "Linkage of nodes: a six-bar, one of 60 divisions"}
#: The N-four-bar that reaches both errors takes at most this of Exudyn's time with so many steps.
FOUR_BARS, OVER_EXUDYN = "n_four_bar_40", 1 / 60
EXUDYN = ("generalised alpha, index 3", "10000 steps")
POSITION, ENERGY = 1e-6, 5e-6
#: Lines of kousoku that are not a user's call with the state at the end.
NOT_THE_DOOR = ("rows", "C alone")


def contests(size: Size) -> list[str]:
    """Names of the problems."""
    posed = [name for name, problem in PROBLEMS.items() if size.is_full or problem.is_quick]
    return [*posed, *linkage.contests(size)]


def cases(contest: str, size: Size) -> list[Case]:
    """Cases of a problem."""
    return linkage.cases() if contest == linkage.CONTEST else PROBLEMS[contest].cases(size)


def title_of(contest: str) -> str:
    """Title of a problem: what moves, in a few words."""
    return PROBLEMS[contest].title if contest in PROBLEMS else TITLES[contest]


def is_door(record: Record) -> bool:
    """Whether it is a call of a user of kousoku, with the state at the end."""
    return record.tool == "kousoku" and not any(word in record.line for word in NOT_THE_DOOR)


def best(records: Iterable[Record], error: float) -> Record | None:
    """Record that is fastest to an error of at most this."""
    reached = [
        one
        for one in records
        if one.fastest is not None and one.error is not None and one.error <= error
    ]
    return min(reached, key=lambda one: one.fastest or 0.0, default=None)


@dataclass(frozen=True, slots=True)
class Beside:
    """kousoku's time to an error beside the best of others.

    Parameters
    ----------
    contest : str
        The problem.
    error : float
        The error that is reached.
    ours : Record or None
        A user's call.
    scene : Record or None
        The best tool that starts from a scene.
    equations : Record or None
        The best one on equations of all bodies.
    reduced : Record or None
        The best one on equations that were reduced by hand.
    """

    contest: str
    error: float
    ours: Record | None
    scene: Record | None
    equations: Record | None
    reduced: Record | None

    @property
    def bodies(self) -> Record | None:
        """The best of those that get all bodies: a scene, or their equations."""
        return best((one for one in (self.scene, self.equations) if one), self.error)

    @property
    def ratio(self) -> float | None:
        """The time of kousoku over that of the best that gets all bodies."""
        return _ratio(self.ours, self.bodies)

    @property
    def ratio_reduced(self) -> float | None:
        """The time of kousoku over that of the best on reduced equations."""
        return _ratio(self.ours, self.reduced)


def _ratio(ours: Record | None, theirs: Record | None) -> float | None:
    if ours is None or theirs is None or not ours.fastest or not theirs.fastest:
        return None
    return ours.fastest / theirs.fastest


def beside(records: Sequence[Record], error: float) -> list[Beside]:
    """Comparison at an error, problem by problem."""
    found = []
    for contest in dict.fromkeys(one.contest for one in records):
        own = [one for one in records if one.contest == contest]
        found.append(
            Beside(
                contest,
                error,
                best((one for one in own if is_door(one)), error),
                *(
                    best((one for one in own if one.kind == kind), error)
                    for kind in ("scene", "equations", "reduced")
                ),
            )
        )
    return found


def body(records: Sequence[Record], figures: Figures) -> str:
    """Tables and plots."""
    posed = [one for one in records if one.contest in PROBLEMS]
    parts = [_overview(posed), _tight(posed)]
    for contest in dict.fromkeys(one.contest for one in records):
        own = [one for one in records if one.contest == contest]
        parts += [
            f"### {title_of(contest)}",
            _plot(contest, own, figures),
            *([_levels(own), _own_columns(own)] if contest in PROBLEMS else [_all(own)]),
        ]
    return "\n\n".join(filter(None, parts))


def _overview(records: Sequence[Record]) -> str:
    """Rows of the overview, one a problem: times, and the ratios to the best of others."""
    rows = []
    for error in JUDGED:
        for one in beside(records, error):
            rows.append(
                [
                    title_of(one.contest),
                    f"{error:.0e}",
                    _told(one.ours, with_tool=False),
                    _told(one.scene),
                    _told(one.equations),
                    _times(one.ratio),
                    _told(one.reduced),
                    _times(one.ratio_reduced),
                ]
            )
    heads = ["problem", "error", "kousoku", "best from a scene", "on equations given", "ratio"]
    return table([*heads, "best reduced by hand", "ratio"], rows)


TIGHT_WORDS = """\
What a tolerance of 1e-12 gives: a tolerance is what the error of a step may be, errors of all steps
add up, and the motion makes each of them larger: of positions and velocities that are moved by a
part of the length and of the largest velocities bodies are later off by so many times as much
(`python -m tests.benchmarks.problems.growth`). 1e-10 is promised where that is no more than 100,
and more in proportion where it is more; that is kept as long as all steps together err by no more
than one tolerance. Beside it stands what another implementation of the method makes of the
equations of all bodies at the same tolerance."""

#: Another implementation of the method whose errors stand beside those of kousoku.
OTHER_DOP853 = "SciPy", "DOP853, index 1"


def _tight(records: Sequence[Record]) -> str:
    """Rows of the tightest tolerance, beside how far motions magnify errors."""
    tight = [one for one in records if one.setting == TIGHT]
    own = [one for one in tight if is_door(one)]
    others = {one.contest: one for one in tight if (one.tool, one.line) == OTHER_DOP853}
    lines = list(dict.fromkeys(one.line for one in own))
    rows = []
    for contest in dict.fromkeys(one.contest for one in own):
        found = {one.line: one for one in own if one.contest == contest}
        told = [
            f"{number(one.error)} in {one.extra.get('steps', 0):.0f} steps" if one else "–"
            for one in map(found.get, lines)
        ]
        other = others.get(contest)
        problem = PROBLEMS[contest]
        judged = [number(other.error) if other else "–", number(problem.promised)]
        rows.append([problem.title, f"{GROWTH[contest]:.2g}", *told, *judged])
    if not rows:
        return ""
    errors = [*(f"error of {line}" for line in lines), " ".join(("error of", *OTHER_DOP853))]
    heads = ["problem", "errors grow, times", *errors, "promised"]
    return f"{TIGHT_WORDS}\n\n{table(heads, rows)}"


def _told(record: Record | None, *, with_tool: bool = True) -> str:
    if record is None:
        return "–"
    return f"{duration(record.fastest)} {f'{record.tool} ' if with_tool else ''}{record.line}"


def _times(ratio: float | None) -> str:
    """Ratio of two digits, without an exponent."""
    return "–" if ratio is None else f"{float(f'{ratio:.2g}'):g}"


def _lines(records: Sequence[Record]) -> dict[tuple[str, str], list[Record]]:
    found: dict[tuple[str, str], list[Record]] = {}
    for one in records:
        found.setdefault((one.tool, one.line), []).append(one)
    return found


def _plot(contest: str, records: Sequence[Record], figures: Figures) -> str:
    """Plot: a line of kousoku for the default and the C, one a line of peers."""
    lines = [
        ToolLine(
            f"{tool} {line}",
            [
                (one.error, one.fastest)
                for one in own
                if one.error is not None and one.fastest is not None
            ],
            tool == "kousoku",
        )
        for (tool, line), own in _lines(records).items()
        if not line.endswith("rows")
    ]
    title = title_of(contest)
    svg = work_precision(title, "largest error of positions over 100 times", lines)
    return figures.add(f"solvers_{contest}", svg, f"Time against error: {title}") if svg else ""


def _all(records: Sequence[Record]) -> str:
    """Rows of all cases."""
    rows = [
        [
            f"{one.tool} {one.line}",
            KINDS[one.kind],
            one.setting,
            duration(one.fastest),
            duration(one.median),
            number(one.error),
            one.note,
        ]
        for one in records
    ]
    return table(["", "", "setting", "fastest", "median", "error", "remarks"], rows)


def _levels(records: Sequence[Record]) -> str:
    """Time of each line to some errors."""
    rows = []
    for (tool, line), own in _lines(records).items():
        times = [best(own, level) for level in LEVELS]
        least = min((one.error for one in own if one.error is not None), default=None)
        notes = "; ".join(dict.fromkeys(one.note for one in own if one.note))
        cells = [
            duration(one.fastest) if one else (TOO_LONG if TOO_LONG in notes else "–")
            for one in times
        ]
        kind = KINDS[own[0].kind]
        rows.append([f"{tool} {line}", kind, *cells, number(least), notes])
    heads = ["", "", *(f"to {level:.0e}" for level in LEVELS), "least error", "remarks"]
    return table(heads, rows)


def _own_columns(records: Sequence[Record]) -> str:
    """Kousoku's runs: what a tolerance gives, method by method."""
    own = {(one.line, one.setting): one for one in records if one.tool == "kousoku"}
    has_methods = any(is_door(one) and one.line != "auto" for one in own.values())
    rows = []
    for (line, setting), one in own.items():
        if not is_door(one) or (line == "auto" and has_methods) or one.fastest is None:
            continue
        rows.append(
            [
                line,
                setting.removeprefix("tolerance "),
                duration(one.fastest),
                duration(one.median),
                *(duration(_fastest(own.get((other, setting)))) for other in _others(line)),
                number(one.error),
                number(one.extra.get("reactions")),
                number(one.extra.get("energy")),
                *(f"{one.extra.get(name, 0):.0f}" for name in ("steps", "evaluations")),
            ]
        )
    heads = ["kousoku", "tolerance", "fastest", "median", f"with {ROWS} rows", "C alone"]
    more = ["error", "of reactions", "energy [J]", "steps", "evaluations"]
    return table([*heads, *more], rows)


def _others(line: str) -> tuple[str, str]:
    """Lines of the same method with a table of rows, and of the C alone."""
    return f"{line}, {ROWS} rows", f"{line}, C alone"


def _fastest(record: Record | None) -> float | None:
    return None if record is None else record.fastest


def targets(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Targets that the page promises."""
    found = [
        BenchmarkTarget(
            one.contest, f"time over the best with all bodies, error {error:.0e}", one.ratio, 1.0
        )
        for error in JUDGED
        for one in beside([one for one in records if one.contest in PROBLEMS], error)
        if one.bodies is not None
    ]
    found += _over_exudyn(records)
    for contest in dict.fromkeys(one.contest for one in records):
        tight = [
            one
            for one in records
            if one.contest == contest and is_door(one) and one.setting == TIGHT
        ]
        if tight and contest in PROBLEMS:
            errors = [one.error for one in tight]
            known = [error for error in errors if error is not None]
            worst = max(known) if len(known) == len(errors) else None
            promised = PROBLEMS[contest].promised
            found.append(
                BenchmarkTarget(
                    contest, "error of positions at 1e-12, all methods", worst, promised
                )
            )
    return found


def _over_exudyn(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Target beside Exudyn: the loosest run that keeps positions and the energy."""
    own = [one for one in records if one.contest == FOUR_BARS]
    theirs = [one for one in own if (one.line, one.setting) == EXUDYN]
    if not theirs:
        return []
    kept = [one for one in own if is_door(one) and one.extra.get("energy", ENERGY + 1) <= ENERGY]
    ratio = _ratio(best(kept, POSITION), theirs[0])
    return [BenchmarkTarget(FOUR_BARS, "time over Exudyn's with 10,000 steps", ratio, OVER_EXUDYN)]


def words(records: Sequence[Record]) -> str:
    """List for each error of where kousoku wins, where it loses, and by how much."""
    parts = []
    for error in JUDGED:
        compared = beside([one for one in records if one.contest in PROBLEMS], error)
        ratios = {one.contest: one.ratio for one in compared if one.ratio is not None}
        wins = {name: 1 / ratio for name, ratio in ratios.items() if ratio < 1}
        losses = {name: ratio for name, ratio in ratios.items() if ratio >= 1}
        unmatched = [one.contest for one in compared if one.ours and not one.bodies]
        lost = [one.contest for one in compared if not one.ours]
        said = []
        if wins:
            said.append(f"is faster on {_list(wins)}")
        if losses:
            said.append(f"is slower on {_list(losses)}")
        if unmatched:
            said.append(f"is the only one of these to reach it on {_names(unmatched)}")
        if lost:
            said.append(f"does not reach it on {_names(lost)}")
        reduced = [one.ratio_reduced for one in compared if one.ratio_reduced is not None]
        if reduced:
            few, many = min(reduced), max(reduced)
            said.append(
                f"takes {_times(few)} to {_times(many)} times as long as with equations that a"
                " person reduced by hand first"
            )
        if said:
            lead = f"To an error of {error:.0e}, beside the best tool that gets all bodies, kousoku"
            parts.append(bullet_list(lead, said))
    return "\n\n".join(parts)


def _list(ratios: dict[str, float]) -> str:
    ordered = sorted(ratios.items(), key=lambda item: -item[1])
    return _joined([f"{title_of(name)} ({_times(ratio)} times)" for name, ratio in ordered])


def _names(contests: Sequence[str]) -> str:
    return _joined([title_of(name) for name in contests])


def _joined(texts: Sequence[str]) -> str:
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


QUESTION = Question(
    title="Solvers: time to an error",
    asks=(
        "A time is that of one call to the state at the end, of kousoku through `simulate` with all"
        " its checks; `C alone` is a run that was begun before (`restart` and `advance`). The error"
        " is the largest over 100 times of the positions of points, relative to a length of the"
        " problem, from a run with the same settings; that of reactions is relative to the largest"
        " one. *From a scene*: bodies and joints are enough; *equations given*: a person wrote"
        " constraints and forces of all bodies; *reduced by hand*: a person reduced them to as few"
        " coordinates as there are freedoms first. The first two get all bodies: the faster one of"
        " them is what kousoku is judged by.\n\n"
        "Digits come from equations written by hand, integrated by a Taylor series in quadruple"
        " precision; two forms of them agree, and published digits are met"
        " (`tests/benchmarks/problems`)."
        "\n\n"
        "What decides the numbers of others: **heyoka**, **SciPy** and **CasADi** get the rates as"
        " compiled code, whose derivatives CasADi wrote; implicit methods get the exact Jacobian."
        " heyoka's code is inlined where it compiles in seconds, and compact for longer equations."
        " IDAS controls its steps by positions and velocities alone. **Exudyn** gets planar bodies"
        " where the motion is in a plane, its sparse solver from twenty bodies on, modified Newton,"
        " and a spectral radius of 0.95: with 1 it does not pass singular positions, with 0.6 it"
        " loses forty times more energy; its explicit methods get a tree in joint coordinates."
        " **MuJoCo** steps in C; RK4 is its method of order 4, loops are as stiff as it takes them."
        " **Pinocchio** gives accelerations in joint coordinates to SciPy's DOP853, with its own"
        " constraints for loops. Fixed steps reach the 100 times exactly."
    ),
    contests=contests,
    cases=cases,
    body=body,
    targets=targets,
    words=words,
    seconds=80.0,
)
