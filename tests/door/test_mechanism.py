"""A mechanism: it pickles, says what it is, moves, and refuses in one line what it has not."""

from __future__ import annotations

import copy
import multiprocessing
import os
import pickle
import shutil
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks

if TYPE_CHECKING:
    from collections.abc import Callable

SCENES = Path(__file__).parents[2] / "scenes"
LOOP, LEVER, DRIVEN = (SCENES / f"{x}.toml" for x in ("loop_free", "lever_crank", "loop"))


@pytest.fixture
def loop(compiler: object) -> ks.Mechanism:
    return ks.load(LOOP)


@pytest.fixture
def lever() -> ks.Mechanism:
    return ks.load(LEVER, target="numpy")


def last_angle(mechanism: ks.Mechanism, mass: float) -> float:
    run = mechanism.simulate(0.5, samples=2, parameters={"mass": mass})
    return float(run["crank_angle"][-1])


def emptied(mechanism: ks.Mechanism, mass: float) -> float:
    """Angle that a child computes whose cache is empty, and stays so."""
    cache = Path(os.environ["KOUSOKU_CACHE"])
    assert not list(cache.glob("scenes/*"))
    return last_angle(mechanism, mass)


def test_a_mechanism_is_copied_and_pickled(loop: ks.Mechanism, lever: ks.Mechanism) -> None:
    copies: list[Callable[[Any], Any]] = [
        copy.copy,
        copy.deepcopy,
        lambda x: pickle.loads(pickle.dumps(x)),
    ]
    assert loop.scene.name == "loop_free"  # what was read goes along, too
    for again in copies:
        other = again(loop)
        assert (repr(other), other.scene, other.outputs) == (repr(loop), loop.scene, loop.outputs)
        assert last_angle(other, 2.0) == last_angle(loop, 2.0)
        linkage = again(lever)
        positions = linkage.solve().node("O3").position
        np.testing.assert_array_equal(positions, lever.solve().node("O3").position)


def test_a_mechanism_goes_to_processes_that_have_no_cache(
    compiler: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "full"))
    loop = ks.load(LOOP)
    wanted = [last_angle(loop, mass) for mass in (1.0, 2.0, 3.0)]
    data = pickle.dumps(loop)
    shutil.rmtree(tmp_path / "full")
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "empty"))
    mechanism = pickle.loads(data)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        found = list(pool.map(emptied, [mechanism] * 3, (1.0, 2.0, 3.0)))
    assert found == wanted


def public_objects() -> dict[str, Any]:
    loop, lever = ks.load(LOOP), ks.load(LEVER)
    run = loop.simulate(0.1, samples=3)
    going = loop.begin([0.0, 0.1, 0.2])
    going.advance(2)
    builder = ks.SceneBuilder("bar", unit="m").body("bar", position=(0, 0, 0))
    return {
        **{"mechanism": loop, "linkage": lever, "scene": loop.scene, "builder": builder},
        **{"result": run, "trajectory": lever.solve(), "body": run.body("crank")},
        **{"ledger": run.ledger, "iterations": lever.solve().ledger, "animation": run.animate()},
        **{"run": going, "saved": going.save(), "matrices": loop.matrices(*run.state(1))},
        **{"evaluation": loop.evaluate(*run.state(1)), "explanation": ks.explain(loop)},
        **{"derivation": ks.derive("n1"), "kinds": ks.kinds, "catalog": ks.catalog()},
        **{"solver": loop.solver, "solver of a linkage": lever.solver, "files": loop.files},
        **{"explanation of a linkage": ks.explain(lever)},
        "report": ks.verify(SCENES.parent / "generated" / "pendulum", target="numpy"),
    }


def test_what_is_public_says_what_it_is_in_ten_lines(compiler: object) -> None:
    for name, thing in public_objects().items():
        lines = repr(thing).splitlines()
        assert 1 <= len(lines) <= 10, name
        assert max(map(len, lines)) <= 240, name
        assert " object at 0x" not in lines[0], name


def test_nobody_changes_what_others_read(loop: ks.Mechanism) -> None:
    run = loop.simulate(0.1, samples=3)
    for values in (run["crank_angle"], run.body("crank").position, run.time, run.joint("a").force):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 9.0


def test_a_column_that_is_read_as_an_attribute_is_shown_the_way(loop: ks.Mechanism) -> None:
    run: Any = loop.simulate(0.1, samples=3)
    with pytest.raises(AttributeError, match=r"'crank_angle'; it is a column: run\['crank_angle'"):
        _ = run.crank_angle
    assert not hasattr(pickle.loads(pickle.dumps(run)), "nothing")


def test_kernels_of_a_kind_pickle() -> None:
    kernels = ks.kinds.p2_z
    assert pickle.loads(pickle.dumps(kernels)) is kernels
    assert pickle.loads(pickle.dumps(ks.kinds)) is ks.kinds


def test_what_is_public_pickles(compiler: object) -> None:
    for name, thing in public_objects().items():
        if name != "run":  # save() gives what can be sent
            assert repr(pickle.loads(pickle.dumps(thing))) == repr(thing), name


@pytest.mark.parametrize("scene", [LOOP, LEVER])
def test_a_notebook_shows_a_picture(compiler: object, scene: Path) -> None:
    mechanism = ks.load(scene)
    run = mechanism.simulate(2.0, samples=2001)
    for thing in (mechanism, run):
        thing._repr_html_()  # what it needs is imported
        begin = time.process_time()
        page = thing._repr_html_()
        assert time.process_time() - begin < 0.2
        assert page.count("<img") == 1 and "data:image/svg+xml;base64," in page
        assert "<script" not in page and len(page) < 50_000
    assert not getattr(run, "_tables", None)  # tables of all rows are not made for it


def test_a_result_without_mechanism_is_shown_as_text(lever: ks.Mechanism) -> None:
    run = lever.solve()
    run.mechanism = None
    assert run._repr_html_().startswith("<pre>Trajectory of lever_crank")


def test_matrices_and_accelerations_are_those_of_a_row(loop: ks.Mechanism) -> None:
    run = loop.simulate(0.5, samples=3)
    for k in (0, 1, -1):
        found, told = loop.matrices(*run.state(k)), loop.evaluate(*run.state(k))
        left = found.M @ told.v_dot + found.C_q.T @ told.lam - found.f
        assert np.abs(left).max() < 1e-9 * np.abs(found.f).max()
        np.testing.assert_allclose(found.C_q @ told.v_dot, found.gamma, atol=1e-9)


def test_a_run_goes_on_and_is_resumed(loop: ks.Mechanism) -> None:
    times = np.linspace(0.0, 0.5, 11)
    whole = loop.simulate(times=times)
    run = loop.begin(times)
    run.advance(3)
    saved = pickle.loads(pickle.dumps(run.save()))
    for one in (run, loop.resume(saved)):
        np.testing.assert_array_equal(one.finish()["crank_angle"], whole["crank_angle"])
    with pytest.raises(ks.SolveError):
        ks.load(SCENES / "pendulum.toml").resume(saved)


def test_a_linkage_is_solved_and_follows_its_input(lever: ks.Mechanism) -> None:
    assert len(lever.solve()) == 61
    assert len(lever.solve(divisions=12)) == 13
    run = lever.simulate(0.5, samples=6)
    assert run["time"].tolist() == np.linspace(0, 0.5, 6).tolist()
    assert run.node("O3").position.shape == (6, 2)


def test_a_scene_of_bodies_with_inputs_is_solved_at_their_divisions(compiler: object) -> None:
    mechanism = ks.load(SCENES / "oldham_coupling.toml")
    assert len(mechanism.solve(divisions=8)) == 9


def test_the_duration_of_a_scene_is_the_end(compiler: object) -> None:
    text = f"duration = 0.25\n{LOOP.read_text(encoding='utf-8')}"
    assert ks.load(text).simulate(samples=3).time.tolist() == [0.0, 0.125, 0.25]
    assert ks.load(text).simulate(0.5, samples=2).time[-1] == 0.5


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda m, r: r.body("coupla"), "no body 'coupla'.*did you mean 'coupler'"),
        (lambda m, r: r.joint("e"), "no joint 'e': there are a, b, c, d"),
        (lambda m, r: r.driver("motor"), "no driver 'motor'"),
        (lambda m, r: r.node("O3"), "no node 'O3': the result has"),
        (lambda m, r: r["crank_angl"], "no column 'crank_angl'.*mean 'crank_angle'"),
        (lambda m, r: r.energy["total"], r'load\(\.\.\., outputs=\[\.\.\., "energies"\]\)'),
        (lambda m, r: r.body("crank").acceleration, 'outputs=.*"accelerations"'),
        (lambda m, r: r.state(9), "no row 9: there are 3"),
        (lambda m, r: m.solve(), "has no inputs"),
        (
            lambda m, r: m.solve(turns=2),
            "turns is an option of linkages of nodes",
        ),
        (lambda m, r: m.simulate(), "wants a last time in seconds"),
        (lambda m, r: m.simulate(-1), "end"),
        (lambda m, r: m.simulate(1, tolerence=1e-6), "did you mean 'tolerance'"),
        (lambda m, r: m.simulate(1, parameters={"mas": 1}), "did you mean 'mass'"),
        (lambda m, r: m.simulate(1, initial={"crank": 1}), "no coordinate 'crank'"),
        (lambda m, r: m.resume(3), "."),
    ],
)
def test_what_a_scene_of_bodies_has_not_is_one_line(
    loop: ks.Mechanism, ask: Callable[..., object], says: str
) -> None:
    run = loop.simulate(0.1, samples=3)
    refused = (ks.KousokuError, KeyError, AttributeError, IndexError, TypeError)
    with pytest.raises(refused, match=says) as caught:
        ask(loop, run)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda m: m.begin([0, 1]), "lever_crank: a run that goes on: of scenes of bodies"),
        (lambda m: m.resume(None), "of scenes of bodies"),
        (lambda m: m.evaluate(0, [], []), "accelerations: of scenes of bodies"),
        (lambda m: m.solve(parameters={"k": 1}), "a linkage has no parameters"),
        (lambda m: m.simulate(1, tolerance=1e-6), "tolerance is an option of scenes of bodies"),
        (lambda m: m.simulate(), "wants a last time"),
        (lambda m: m.solve().body("O3"), "no body 'O3': the result has"),
        (lambda m: m.solve().node("O9"), "no node 'O9': there are O1, O2, O3, O4"),
        (lambda m: m.solve().link("l1").angle, 'outputs=.*"angles"'),
    ],
)
def test_what_a_linkage_has_not_is_one_line(
    lever: ks.Mechanism, ask: Callable[..., object], says: str
) -> None:
    with pytest.raises((ks.KousokuError, KeyError, AttributeError), match=says) as caught:
        ask(lever)
    assert "\n" not in str(caught.value)


# ---- progress -----------------------------------------------------------------------------------

LOADING = f"import kousoku as ks; ks.load({str(LOOP)!r}, target='numpy')"


def test_loading_is_silent_in_a_pipe(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADING],
        capture_output=True,
        text=True,
        env={**os.environ, "KOUSOKU_CACHE": str(tmp_path)},
        check=True,
    )
    assert done.stdout == ""
    assert done.stderr.splitlines() in ([], [done.stderr.strip()])
    assert "generating" not in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="a terminal is made of a pty")
def test_loading_is_told_on_a_terminal(tmp_path: Path) -> None:
    import pty

    master, slave = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", LOADING],
        stdout=subprocess.PIPE,
        stderr=slave,
        env={**os.environ, "KOUSOKU_CACHE": str(tmp_path), "TERM": "xterm"},
    ) as process:
        os.close(slave)
        seen = b""
        while True:
            try:
                part = os.read(master, 4096)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            seen += part
        assert process.stdout is not None
        assert process.stdout.read() == b""
    os.close(master)
    assert process.returncode == 0
    assert b"generating loop_free" in seen
