"""What is wrong at the door is an error of kousoku that says what there is, or what is wanted."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import kousoku as ks
from kousoku.runtime import load

if TYPE_CHECKING:
    from collections.abc import Callable

SCENES = Path(__file__).parents[2] / "scenes"
N1 = SCENES.parent / "generated" / "kinds" / "n1"

pytestmark = pytest.mark.usefixtures("numpy_solver")


@pytest.fixture(scope="module")
def run() -> ks.Result:
    return ks.load(SCENES / "loop_free.toml", target="numpy").simulate(0.01, samples=2)


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda run: run["crank_angel"], "no column 'crank_angel': .*did you mean 'crank_angle'"),
        (
            lambda run: run["crank"],
            "no column 'crank': those of crank are crank.x, crank.y,",
        ),
        (lambda run: run.body("rod"), "no body 'rod': there are crank, coupler, rocker"),
        (lambda run: run.node("O1"), r"no node 'O1': the result has \.body"),
        (lambda run: run.columns_of("rod"), "no column 'rod'"),
        (lambda run: run[["rocking"]], r"no column \['rocking'\]: there are time, crank.x"),
        (lambda run: run.columns_of(["rocking"]), r"no column \['rocking'\]"),
        (lambda run: run.position[["rod"]], r"no position of bodies, none of \['rod'\]"),
        (lambda run: run.position["rod"], "no position of bodies, none of 'rod'"),
        (lambda run: run.parameters["length"], "no parameter, none of 'length': there are mass"),
        (lambda run: run.parameters["mas"], "did you mean 'mass'"),
        (lambda run: run.events["lands"], "loop_free: it has no events"),
        (lambda run: run.ledger.works["motor"], "^none of 'motor': there are none$"),
        (lambda run: ks.catalog()["joints"]["revolut"], "did you mean 'revolute'"),
        (lambda run: load(N1, target="numpy")["rate"], "n1 has no kernel 'rate'"),
    ],
)
def test_a_name_that_there_is_not_is_a_key_error_and_one_of_kousoku(
    run: ks.Result, ask: Callable[[ks.Result], object], says: str
) -> None:
    with pytest.raises(KeyError, match=says) as found:
        ask(run)
    assert isinstance(found.value, ks.KousokuError)
    assert not str(found.value).startswith(("'", '"'))  # as KeyError shows a text
    assert str(pickle.loads(pickle.dumps(found.value))) == str(found.value)


def test_an_option_of_a_page_that_there_is_not_names_all(run: ks.Result) -> None:
    wrong: dict[str, Any] = {"foo": 1}
    with pytest.raises(ks.KousokuError, match="no option 'foo': there are path, paths_of, forces"):
        run.animate(**wrong)


@pytest.mark.parametrize("name", ["x.csv", "x.npz", "x.html", "x.svg"])
def test_no_folder_is_made_for_a_file(run: ks.Result, tmp_path: Path, name: str) -> None:
    place = tmp_path / "misspelt" / name
    write = run.animate if place.suffix in {".html", ".svg"} else run.save
    with pytest.raises(ks.SolveError) as refused:
        write(place)
    assert str(refused.value) == f"{place}: there is no folder {place.parent}; make it first"
    assert not place.parent.exists()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"length": 3}, "no parameter 'length': its formulas have mass"),
        ({"mass": "2 kg"}, "parameter mass is '2 kg', wanted a finite number"),
    ],
)
def test_parameters_of_a_picture_are_those_of_the_scene(
    run: ks.Result, given: dict[str, Any], says: str
) -> None:
    pytest.importorskip("matplotlib")
    with pytest.raises(ks.SolveError, match=f"^loop_free: {says}"):
        run.mechanism.plot(given)
    with pytest.raises(ks.SolveError, match=f"^loop_free: {says}"):
        run.animate(parameters=given)
    assert run.mechanism.plot({"mass": 2.0}).axes


def test_what_is_no_name_is_no_kind_and_no_equation() -> None:
    wrong: Any = 3.5
    with pytest.raises(ks.KousokuError, match=r"unknown kind 3\.5; known are rotation"):
        ks.derive(wrong)
    with pytest.raises(ks.KousokuError, match=r"no equation 3\.5 in the ledger"):
        ks.ledger.find(wrong)


@pytest.mark.parametrize(
    ("name", "message"),
    [("n1", "'n1' is taken by a kind that kousoku ships"), ("a b", "'a b' is not a name")],
)
def test_a_name_of_ones_own_is_refused_before_anything_is_derived(name: str, message: str) -> None:
    with pytest.raises(ks.KousokuError, match=message):
        ks.derive(name, C=ks.body("i").axis().dot(ks.body("j").axis()))


def test_a_step_that_there_is_not_says_how_many_there_are() -> None:
    steps = ks.derive("n1")
    with pytest.raises(IndexError, match=f"n1 has no step 99: there are {len(steps)}"):
        steps[99]


def test_kernels_are_those_of_a_kind_or_of_a_folder() -> None:
    for given in (N1, str(N1), "n1", "N1"):
        assert ks.kernels(given, target="numpy").manifest.package == "n1"
    with pytest.raises(ks.KousokuError, match="unknown kind 'nowhere/n1'"):
        ks.kernels("nowhere/n1")
    with pytest.raises(ks.KousokuError, match="is not a generated package"):
        ks.kernels(str(SCENES))
    wrong: Any = 3
    with pytest.raises(ks.KousokuError, match=r"^3 is no derivation; wanted what derive returned"):
        ks.kernels(wrong)


def test_a_target_that_there_is_not_is_refused() -> None:
    wrong: Any = "cuda"
    with pytest.raises(ks.KousokuError, match="got 'cuda', wanted 'auto', 'c' or 'numpy'"):
        ks.load(SCENES / "pendulum.toml", target=wrong)


@pytest.mark.parametrize("text", ["", " "])
@pytest.mark.parametrize("take", [ks.load, ks.explain])
def test_nothing_is_no_scene(take: Callable[[str], object], text: str) -> None:
    with pytest.raises(ks.SceneError, match=r"^' ?' is no scene; wanted the path of a scene file"):
        take(text)


@pytest.mark.parametrize("path", ["nowhere", "", SCENES])
def test_what_is_no_generated_folder_cannot_be_verified(path: str | Path) -> None:
    with pytest.raises(ks.KousokuError, match=r"is no generated folder, which has a manifest.json"):
        ks.verify(path)


@pytest.mark.parametrize("initial", [{"rocking": 0.3}, {"rocking_dot": 0.3}])
def test_what_follows_from_a_driver_names_it(initial: dict[str, float]) -> None:
    loop = ks.load(SCENES / "loop.toml", target="numpy")
    with pytest.raises(ks.SolveError, match=r"wanted 0: drivers.motor says so at t = 0"):
        loop.simulate(1, initial=initial)


def test_what_follows_from_another_coordinate_names_no_driver() -> None:
    loop = ks.load(SCENES / "loop_free.toml", target="numpy")
    with pytest.raises(ks.SolveError, match="it follows from the rest"):
        loop.simulate(1, initial={"crank_angle": 0.5, "rocking": 1.0})


def test_a_kind_is_verified_by_its_name() -> None:
    report = ks.verify("dot-1", target="numpy")
    assert report.ok and report.package == "n1"


def test_an_event_that_there_is_not_names_those_that_there_are() -> None:
    ball = ks.load(SCENES / "bouncing_ball.toml", target="numpy")
    with pytest.raises(KeyError, match=r"none of 'land': there are lands, .* 'lands'"):
        ball.simulate(1.0, samples=2).events["land"]


def test_the_text_of_a_scene_is_verified_as_its_file_is() -> None:
    text = (SCENES / "pendulum.toml").read_text(encoding="utf-8")
    assert ks.verify(text, target="numpy").ok
    what: Any = 3
    with pytest.raises(ks.KousokuError, match="is no scene"):
        ks.verify(what)
