"""Files of strangers: scenes, formulas, manifests, saved runs, names, and texts of options.

Each is taken, and then goes all the way to emitted text or to what can be asked of a run, or is
refused by one message of kousoku. :mod:`tests.stress.watched` hears what else happens.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import shutil
import tempfile
import time
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from unittest.mock import patch

import numpy as np
from hypothesis import strategies as st

import kousoku as ks
from kousoku.cli.app import main
from kousoku.loading import generated
from kousoku.model.errors import KousokuError, SceneError
from kousoku.model.files.manifest import Manifest
from kousoku.model.operations.expression import Expression
from kousoku.model.operations.graph import Op
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.records.dotted_keys import join
from tests.stress import strange_inputs as strange
from tests.stress import strange_runs
from tests.stress.force_laws import BUMP
from tests.stress.kit import ROOT, Disagreement, Fault, Outcome, Question, falsify
from tests.stress.strange_runs import QUESTIONS
from tests.stress.watched import SECONDS, warm, watched

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from hypothesis.strategies import SearchStrategy

    from tests.stress.kit import Size

T = TypeVar("T")

LINES, MARKS = 21, 1000
"""Lines of the longest message, and marks of its longest line."""

SIZES = {
    "formulas": (60, 2000),
    "scenes": (60, 1500),
    "tables": (40, 1500),
    "manifests": (80, 1100),
    "tokens": (60, 500),
    "runs": (30, 1000),
    "resumed": (60, 500),
    "options": (60, 500),
    "arguments": (60, 1000),
    "names": (4, 60),
}
"""Sorts of files: how many a case reads, quick and full."""

BATCHES = {"manifests": 20, "scenes": 10, "tables": 10, "formulas": 10, "runs": 10}
"""Cases of the full size, two of the other sorts; 20 of a thousand manifests each."""


def cases(size: Size) -> Iterator[str]:
    """Name the cases of each sort."""
    for sort, (quick, full) in SIZES.items():
        for batch in range(BATCHES.get(sort, 2) if size.is_full else 1):
            yield f"{sort} {size.seed} {batch} {size.examples(quick, full)}"


class Tried:
    """What a case counts while it tries inputs.

    Parameters
    ----------
    sort : str
        What strangers give.
    """

    def __init__(self, sort: str) -> None:
        self.sort, self.outcome = sort, Outcome()

    def each(
        self, strategy: SearchStrategy[T], check: Callable[[T], bool | None], case: str
    ) -> Outcome:
        """Try inputs; the smallest that is neither taken nor refused well is a finding.

        Parameters
        ----------
        strategy : SearchStrategy
            What is tried.
        check : callable
            Returns whether it was taken, None where it is none; raises what it finds.
        case : str
            The name of the case: sort, seed, batch, and how many.
        """
        _, seed, batch, count = case.split()

        def tried(one: T) -> None:
            start = time.process_time()
            is_taken = check(one)
            took = time.process_time() - start
            if is_taken is None:
                return
            self.outcome.count(f"{self.sort}: {'taken' if is_taken else 'refused'}")
            self.outcome.measure(
                "slowest input (s of processor time)", took, f"{self.sort} {seed} {batch}", SECONDS
            )

        found = falsify(strategy, tried, seed=1000 * int(seed) + int(batch), examples=int(count))
        if found is not None:
            example, error = found
            words = " ".join(str(error).split())
            self.outcome.find(
                f"{self.sort}: {type(error).__name__}: {words[:100]}",
                f"{words[:300]}; of {example!r:.1500}",
                f"python -m tests.stress strangers --case '{case}'",
                **_files(example),
            )
        return self.outcome


def _files(example: object) -> dict[str, str]:
    """Files that show an example: a scene where it is one."""
    if isinstance(example, tuple) and isinstance(example[0], str | dict):
        example = example[0]
    if isinstance(example, dict):
        return {"scene__toml": strange.written(example)}
    return {"input__txt": example if isinstance(example, str) else repr(example)}


def refused_well(error: KousokuError, place: str = "", begins: tuple[str, ...] = ()) -> None:
    """Check the message of a refusal: a few readable lines that name the place.

    Parameters
    ----------
    error : KousokuError
        The refusal.
    place : str
        What is wrong is in this file, or package.
    begins : tuple of str
        What is wrong is in one of these files, tables, or elements: a line begins with it.

    Raises
    ------
    Disagreement
        It is none that a user can read.
    """
    text = str(error)
    lines = text.split("\n")
    if len(lines) > LINES or any(not line.isprintable() or len(line) > MARKS for line in lines):
        raise Disagreement(f"a message of {len(lines)} lines, {len(text)} marks: {text!r:.200}")
    starts = tuple(f"{one}{mark}" for one in begins for mark in ".:[")
    is_there = not begins or any(line.startswith(starts) for line in lines)
    if not text or place not in text or not is_there:
        raise Disagreement(f"a message that names no place: {text!r:.200}")


def taken(read: Callable[[], ks.Scene], emit: bool, *begins: str) -> bool:
    """Whether a scene is taken; it then is composed, and the emitted modules are Python.

    A message of what is refused begins with one of some files, tables, or elements.
    """
    try:
        with watched():
            scene = read()
            # a scene does not know what file it is from: what composing it refuses is named in it
            begins = (*begins, scene.name, *scene.__struct_fields__)
            tree = generated(scene) if emit else {}
    except KousokuError as error:
        refused_well(error, begins=begins)
        return False
    for name, text in tree.items():
        if name.endswith(".py"):
            ast.parse(text, name)
    return True


def try_formulas(case: str) -> Outcome:
    """Try formulas in every place of a scene that has one."""
    some = st.tuples(
        st.sampled_from([*strange.WITH_FORMULA]), strange.formulas(), st.integers(0, 7)
    ).map(lambda of: (*strange.with_formula(of[0], of[1]), of[2] == 1))

    def check(of: tuple[dict[str, Any], str, bool]) -> bool:
        tree, place, emit = of
        return taken(lambda: scene_from_dict(tree), emit, place)

    return Tried("formulas").each(some, check, case)


def try_scenes(case: str) -> Outcome:
    """Try the texts of scenes, with a wrong mark or value here and there."""
    some = st.tuples(strange.edited_texts(), st.integers(0, 15).map(lambda k: k == 1))

    def check(of: tuple[str, bool]) -> bool:
        text, emit = of
        return taken(lambda: scene_from_toml(text, file="x.toml"), emit, "x.toml")

    return Tried("scenes").each(some, check, case)


#: What a message begins with that names a table of a scene, also one that is not there, or the
#: scene as a whole.
PLACES = (*ks.Scene.__struct_fields__, "has no mechanism")


def try_tables(case: str) -> Outcome:
    """Try scenes as tables of Python: whatever stands in them."""
    some = st.tuples(strange.edited_trees(), st.integers(0, 15).map(lambda k: k == 1))

    def check(of: tuple[dict[str, Any], bool]) -> bool:
        tree, emit = of
        tables = [join("", key) for key in tree]
        return taken(lambda: scene_from_dict(tree), emit, *tables, *PLACES)

    return Tried("tables").each(some, check, case)


PACKAGES = ("kinds/p1", "kinds/length", "kinds/mass_points", "pendulum", "lever_crank")
ALPHABET = "0123456789abcdefxyzEL \n\t\r\"'\\,:[]{}().-+_/é\0\u2028\U0001f600"


def try_manifests(case: str) -> Outcome:
    """Try manifests with one mark that is another, more, or less: none passes ``verify``."""

    def edit(text: str, of: tuple[int, int, str]) -> str:
        place, how, mark = of
        place %= len(text)
        return text[:place] + (mark * (how < 2)) + text[place + (how > 0) :]

    edits = st.tuples(st.integers(0, 10**6), st.integers(0, 2), st.sampled_from(ALPHABET))
    return _of_manifests("manifests", edits, edit, case, may_pass=False)


def try_tokens(case: str) -> Outcome:
    """Try manifests with values that are others: none runs what it does not list truly."""

    def edit(text: str, of: tuple[int, Any, int]) -> str:
        number, value, how = of
        tree = json.loads(text)
        every = strange.places(tree)
        *path, last = every[number % len(every)]
        table: Any = tree
        for key in path:
            table = table[key]
        if how == 0:
            del table[last]
        elif how == 1 and isinstance(table, list):
            table.append(table[last])
        else:
            table[last] = value
        try:
            return strange_json(tree)
        except (ValueError, TypeError):
            return text + "x"

    edits = st.tuples(st.integers(0, 10**6), strange.values(), st.integers(0, 3))
    return _of_manifests("tokens", edits, edit, case, may_pass=True)


def strange_json(tree: object) -> str:
    """Manifest as kousoku would write it, so that it is refused for what it says."""
    from kousoku.model.files.jsontext import to_text

    return to_text(tree)


def _of_manifests(
    sort: str, edits: SearchStrategy[T], edit: Callable[[str, T], str], case: str, *, may_pass: bool
) -> Outcome:
    """Try edits of manifests of packages; one that passes says what was said before."""
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as place:
        folders = {}
        for name in PACKAGES:
            shutil.copytree(ROOT / "generated" / name, Path(place, name))
            folders[name] = Path(place, name, "manifest.json")
        texts = {name: path.read_bytes().decode() for name, path in folders.items()}
        seen = {*texts.values()}

        def check(of: tuple[str, T]) -> bool | None:
            name, what = of
            path, text = folders[name], edit(texts[name], what)
            if text in seen:
                return None
            seen.add(text)
            path.write_bytes(text.encode("utf-8", "surrogatepass"))
            try:
                with watched(Path(place)):
                    report = ks.verify(path.parent, target="numpy")
                    problems = "\n".join(report.problems)
            except KousokuError as error:
                refused_well(error)
                return False
            finally:
                path.write_bytes(texts[name].encode())
            if not report.ok:
                refused_well(KousokuError(problems), name.rpartition("/")[2])
                seen.add(text)
                return False
            before = Manifest.from_json(texts[name])
            after = Manifest.from_json(text)
            if not may_pass or replace(after, files=()) != replace(before, files=()):
                raise Disagreement(f"{name}: an edited manifest passes verify")
            if not set(after.files) <= set(before.files):
                raise Disagreement(f"{name}: a manifest lists files that were not emitted")
            return True

        return Tried(sort).each(st.tuples(st.sampled_from(PACKAGES), edits), check, case)


def try_runs(case: str) -> Outcome:
    """Try saved runs with marks, values and numbers that are others."""
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as place:
        path = Path(place, "run.npz")

        def check(of: tuple[Any, ...]) -> bool:
            path.write_bytes(strange_runs.edited(*of))
            try:
                with watched(Path(place)):
                    run = ks.open_run(path)
            except KousokuError as error:
                refused_well(error, "run.npz")
                return False
            for ask in QUESTIONS:
                try:
                    with watched(Path(place)):
                        ask(run, Path(place))
                except KousokuError as error:
                    refused_well(error)
            return True

        return Tried("runs").each(strange_runs.edits(), check, case)


def try_resumed(case: str) -> Outcome:
    """Try states of runs to go on from, with numbers that are others: no step leads outside.

    Of most the digest is that of the other numbers, so that these themselves are looked at.
    """
    scene: Any = ks.load(ROOT / "scenes" / "bouncing_ball.toml")
    run = scene.begin(np.linspace(0.0, 1.0, 11))
    run.advance(4)
    saved = run.save()
    fields = [*scene.solver.state]
    number = st.sampled_from([np.nan, np.inf, -np.inf, -1.0, 0.0, 0.5, 1e9, 1e300, 5e-324, 2.0**31])
    edits = st.lists(
        st.tuples(st.sampled_from(fields), st.integers(0, 100), number | st.floats()),
        min_size=1,
        max_size=3,
    )
    some = st.tuples(edits, st.integers(0, 9).map(lambda k: k != 1))

    def check(of: tuple[list[tuple[str, int, float]], bool]) -> bool:
        (edits, is_sealed), state = of, saved.state.copy()
        for name, place, value in edits:
            view = scene.solver.state[name].view(state)
            if view.size:
                view.flat[place % view.size] = value
        other = replace(saved, state=state)
        try:
            with watched():
                again = scene.resume(other.sealed() if is_sealed else other)
                again.advance(50)
                _ = repr(again), again.motion().columns(), str(again.motion().ledger)
        except KousokuError as error:
            refused_well(error)
            return False
        if not is_sealed and state.tobytes() != saved.state.tobytes():
            raise Disagreement("a state that is none that was saved is taken")
        return True

    tried = Tried("resumed")
    for name in ("bouncing_ball", "pendulum"):
        no_numbers(tried.outcome, name, case)
    return tried.each(some, check, case)


def no_numbers(outcome: Outcome, name: str, case: str) -> None:
    """Go on from states in which one number after the other is NaN: steps never go by it."""
    scene: Any = ks.load(ROOT / "scenes" / f"{name}.toml")
    times = np.linspace(0.0, 0.5, 11)
    run = scene.begin(times)
    run.advance(4)
    saved, wanted = run.save(), run.finish().rows
    for field in scene.solver.state:
        state = saved.state.copy()
        scene.solver.state[field].view(state)[...] = np.nan
        try:
            rows = scene.resume(replace(saved, state=state).sealed()).finish().rows
        except KousokuError as error:
            refused_well(error)
            outcome.count("states with a NaN: refused")
            continue
        outcome.count("states with a NaN: the same rows")
        if not np.array_equal(rows, wanted):
            outcome.find(
                f"resumed: a NaN in {field} changes rows",
                name,
                f"python -m tests.stress strangers --case '{case}'",
            )


def try_options(case: str) -> Outcome:
    """Try texts behind the options of the command: it says what is wrong in a line, and exits."""
    texts = st.one_of(
        *[strange.formulas(), st.sampled_from(strange.NAMES), st.text(max_size=12)],
        st.tuples(st.sampled_from(["stiffness", "z", "z_dot", ""]), strange.formulas()).map(
            "=".join
        ),
        st.sampled_from([f"stiffness={x}" for x in strange.NUMBERS]),
        st.sampled_from([f"z={x}" for x in ("30deg", "nan", "inf", "-1e400", "0x1", "1 deg deg")]),
    )
    options = ("--set", "--initial", "--column", "--body", "--end", "--samples", "--tolerance")
    some = st.lists(
        st.tuples(st.sampled_from([*options, "--output", "--method", "--step"]), texts),
        min_size=1,
        max_size=3,
    )
    file = str(ROOT / "scenes" / "bouncing_ball.toml")
    given = ["simulate", file, "--target", "numpy", "--end", "0.01", "--samples", "2"]
    given += ["--tolerance", "1e-3", "--most-steps", "50"]

    def check(pairs: list[tuple[str, str]]) -> bool:
        words = [*given, *(f"{option}={text}" for option, text in pairs)]
        out, err = io.StringIO(), io.StringIO()
        status: object = 0
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                with watched(Path(tempfile.gettempdir()) / "never"):
                    main(words)
            except SystemExit as error:
                status = error.code
            except KeyboardInterrupt:
                status = 130
        said = err.getvalue()
        if status not in {0, None} and (not said.strip() or len(said) > LINES * MARKS):
            raise Disagreement(f"exit status {status}, {len(said)} marks are said")
        if "Traceback" in said or status == 1:
            raise Disagreement(f"exit status {status}: {said[-300:]}")
        return status in {0, None}

    main_once = io.StringIO()
    with contextlib.redirect_stdout(main_once), contextlib.suppress(SystemExit):
        main(given)
    return Tried("options").each(some, check, case)


def try_arguments(case: str) -> Outcome:
    """Try what programs hand to runs: a run is made, or an error of kousoku says what is wrong."""
    scene = ks.load(ROOT / "scenes" / "bouncing_ball.toml", target="numpy")
    run: Any = scene.simulate(0.01, samples=2, tolerance=1e-3)
    run.plot()
    some = strange.values()
    numbers = st.sampled_from([0.01, 2, np.float64(0.02), np.array([0.0, 0.01]), [0.0, 0.01], (0,)])
    mapping = st.dictionaries(
        st.sampled_from(["stiffness", "z", "z_dot", 3, None, ""]), some | numbers, max_size=2
    )
    options = {
        "end": some | numbers,
        "times": some | numbers,
        "samples": some | numbers,
        "tolerance": some | st.sampled_from([1e-3, 1e-300, 2.0]),
        "method": some | st.sampled_from(["dopri5", "dop853", "kinematics"]),
        "step": some | numbers,
        "largest_step": some | numbers,
        "most_steps": some | numbers,
        "parameters": mapping | some,
        "initial": mapping | some,
        "strict": some,
        "checks": some,
    }
    given = st.fixed_dictionaries({}, optional=options) | st.dictionaries(
        st.sampled_from(["q0", "v0", "limit", "x"]), some, max_size=1
    )
    calls = (
        *(lambda v: run[str(v)], lambda v: run.columns_of(str(v)), lambda v: run.body(str(v))),
        *(lambda v: str(v) in run, lambda v: run.events[str(v)], run.plot, run.save),
        *(lambda v: run.animate(speed=v), lambda v: ks.load(BUMP, outputs=v, target="numpy")),
        *(lambda v: ks.load(BUMP, target=v), ks.load, ks.open_run, ks.verify, ks.explain),
        *(scene.resume, lambda v: scene.matrices(v, v, v), scene.plot),
    )

    def check(of: tuple[dict[str, Any], int, Any]) -> bool:
        words, which, value = of
        which -= len(calls)
        full = {"end": 0.01, "samples": 2, "tolerance": 1e-3, "most_steps": 50} | words
        if "times" in words:
            del full["end"], full["samples"]
        try:
            with watched(Path(tempfile.gettempdir())):
                if which < 0:
                    scene.simulate(**full)
                elif not isinstance(value, str) or len(value) < 200:
                    calls[which](value)
        except KousokuError as error:
            refused_well(error)
            return False
        return True

    return Tried("arguments").each(
        st.tuples(given, st.integers(0, 2 * len(calls) - 1), some), check, case
    )


#: A scene with parts of all sorts that have names.
NAMED = """
name = "SCENE"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["accelerations", "coordinates", "reactions", "energies"]
parameters = { PARAMETER = 2 }
bodies.BODY = { position = [1, 0, 0], mass = "PARAMETER", inertia = { xx = 1, yy = 2, zz = 2 } }
bodies.OTHER = { position = [2, 0, 0], mass = 1, point = true }
joints.JOINT = { type = "revolute", bodies = ["ground", "BODY"], at = [0, 0, 0], axis = [0, 1, 0] }
coordinates.TURN = { joint = "JOINT" }
[forces]
FORCE = { type = "along", coordinate = "TURN", moment = "0.1*PARAMETER*sin(t) - TURN_dot" }
[forces.SPRING]
type = "spring_damper"
bodies = ["BODY", "OTHER"]
points = [[0,0,0],[0,0,0]]
stiffness = 5
[events]
EVENT = { when = "TURN + 0.01", action = "count" }
"""
PARTS = ("SCENE", "PARAMETER", "BODY", "OTHER", "JOINT", "TURN", "FORCE", "SPRING", "EVENT")
PLAIN = dict(
    zip(PARTS, ("plain", "par", "bar", "bob", "pin", "turn", "push", "pull", "hit"), strict=True)
)


def _named(names: dict[str, str]) -> str:
    text = NAMED
    for part in sorted(PARTS, key=len, reverse=True):
        text = text.replace(part, names[part])
    return text.replace("moment =", "force =")


def _moved(names: dict[str, str], target: str) -> Any:
    """Rows of the scene with some names."""
    which: Any = target
    run: Any = ks.load(_named(names), target=which).simulate(0.1, samples=3, tolerance=1e-5)
    return run.rows


@cache
def _plain(target: str) -> Any:
    """Rows of the scene with plain names."""
    return _moved(PLAIN, target)


def try_names(case: str) -> Outcome:
    """Try names of all parts of a scene: what is taken moves as with other names, to the bits."""
    words = st.sampled_from([name for name in strange.NAMES if name.isidentifier()])
    some = st.tuples(
        st.dictionaries(st.sampled_from(PARTS), words, min_size=1, max_size=4), st.booleans()
    )
    is_full = int(case.rpartition(" ")[2]) > SIZES["names"][0]
    _plain("numpy")

    def check(of: tuple[dict[str, str], bool]) -> bool:
        names, is_c = of
        text = _named(PLAIN | names)
        target = "c" if is_c and is_full else "numpy"
        try:
            scene_from_toml(text)
        except KousokuError as error:
            refused_well(error)
            return False
        if not np.array_equal(_moved(PLAIN | names, target), _plain("numpy")):
            raise Disagreement(f"names change what is computed in {target}: {names}")
        return True

    return Tried("names").each(some, check, case)


SORTS: dict[str, Callable[[str], Outcome]] = {
    "formulas": try_formulas,
    "scenes": try_scenes,
    "tables": try_tables,
    "manifests": try_manifests,
    "tokens": try_tokens,
    "runs": try_runs,
    "resumed": try_resumed,
    "options": try_options,
    "arguments": try_arguments,
    "names": try_names,
}


def run(case: str) -> Outcome:
    """Try the files of a case."""
    warm()
    return SORTS[case.partition(" ")[0]](case)


def evaluated() -> AbstractContextManager[object]:
    """Read a formula by running it as Python where it is no number."""
    from kousoku.model.expressions import parser

    right = parser._Parser.formula

    def formula(self: Any) -> Any:
        with contextlib.suppress(Exception):
            return Expression(Op.CONST, value=eval(self.text))
        return right(self)

    return patch.object(parser._Parser, "formula", formula)


def believed() -> AbstractContextManager[object]:
    """Take manifests as they are, whatever their digest."""
    right = Manifest.stated
    return patch.object(Manifest, "stated", lambda self: self.digest or right(self))


def raw() -> AbstractContextManager[object]:
    """Let what a damaged file of a run raises out, as it is."""
    from kousoku import saved

    return patch.object(saved, "_require_places", lambda _: None)


def not_finite() -> AbstractContextManager[object]:
    """Go on from states whose numbers are not finite."""
    return patch("kousoku.runtime.saved.FINITE", ())


def unsealed() -> AbstractContextManager[object]:
    """Take every state as what was saved, whatever its digest."""
    from kousoku.runtime import saved

    return patch.object(saved, "digest_of", lambda _: "")


def placeless() -> AbstractContextManager[object]:
    """Leave the dotted key out of each line of a message."""
    return patch.object(SceneError, "_line", lambda _, one: one.problem)


QUESTION = Question(
    asks="strangers' scenes, formulas, manifests, saved runs, names and options: does one run code,"
    " raise what is not kousoku's, or take more than 5 s or 1 GiB?",
    cases=cases,
    run=run,
    faults=(
        Fault("a reader that runs formulas as Python", evaluated, "formulas 1 0 20"),
        Fault("manifests whose digest is believed", believed, "manifests 1 0 30"),
        Fault("saved runs whose layout is believed", raw, "runs 1 0 300"),
        Fault("states whose numbers are not finite are gone on from", not_finite, "resumed 1 0 20"),
        Fault("states whose digest is believed", unsealed, "resumed 1 0 100"),
        Fault("messages that name no place", placeless, "tables 1 0 40"),
    ),
)
