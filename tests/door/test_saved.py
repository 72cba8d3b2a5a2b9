"""Runs that are kept in a file and opened again, and files that hold none."""

from __future__ import annotations

import io
import json
import pickle
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks
from kousoku.runtime.saved import digest_of
from kousoku.saved import OWN

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Output

SCENES = Path(__file__).parents[2] / "scenes"
ALL: tuple[Output, ...] = ("accelerations", "coordinates", "reactions", "energies")

SLIDER = """
name = "slider"
unit = "cm"
gravity = [0, 0, -981]
outputs = ["coordinates"]
coordinates = { file = { joint = "slide" }, allow_pickle = { joint = "pin" } }
[bodies]
kousoku = { position = [0, 0, 0], boxes = [{ mass = 1, size = [1, 1, 1] }] }
arm.position = [0, 0, 0]
arm.cylinders = [{ radius = 1, mass = 1, ends = [[0, 0, 0], [3, 0, 0]] }]
[joints]
slide = { type = "slider", bodies = ["ground", "kousoku"], at = [0, 0, 0], axis = [1, 0, 0] }
pin = { type = "hinge", bodies = ["kousoku", "arm"], at = [0, 0, 0], axis = [0, 1, 0] }
"""


@pytest.fixture
def loop(compiler: object) -> ks.Result:
    mechanism = ks.load(SCENES / "loop_free.toml", outputs=ALL)
    return mechanism.simulate(0.5, samples=21, parameters={"mass": 2.5})


@pytest.fixture(params=["solve", "simulate"])
def lever(request: pytest.FixtureRequest) -> ks.Result:
    mechanism = ks.load(SCENES / "lever_crank.toml", target="numpy")
    return mechanism.solve() if request.param == "solve" else mechanism.simulate(1, samples=11)


def require_same(run: ks.Result, opened: ks.Result) -> None:
    assert opened.units == run.units
    for name, column in run.columns().items():
        np.testing.assert_array_equal(opened[name], column)
    assert repr(opened) == repr(run)
    assert dict(opened.parameters) == dict(run.parameters)
    assert str(opened.ledger) == str(run.ledger)
    assert opened.notes == run.notes
    for k in (0, -1):
        for one, other in zip(opened.state(k), run.state(k), strict=True):
            np.testing.assert_array_equal(one, other)
    assert json.dumps(opened.summary()) == json.dumps(run.summary())
    assert opened.mechanism.scene == run.mechanism.scene


def kept(run: ks.Result, folder: Path) -> Path:
    run.save(folder / "run.npz")
    return folder / "run.npz"


def test_bodies_are_opened_as_they_were(loop: ks.Result, tmp_path: Path) -> None:
    opened = ks.open_run(kept(loop, tmp_path))
    require_same(loop, opened)
    assert opened.parameters["mass"] == 2.5 == opened.ledger.parameters["mass"]
    assert opened.ledger.steps == loop.ledger.steps
    assert str(opened.ledger.trust) == str(loop.ledger.trust)
    assert repr(opened).startswith("trust: energy ")
    assert opened.ledger.trust.is_trusted is True
    assert opened.ledger.trust.limit == loop.ledger.trust.limit
    kept_trust: Any = opened.ledger.trust
    with pytest.raises(AttributeError, match="the verdict that was kept has no 'colour'"):
        assert kept_trust.colour
    np.testing.assert_array_equal(opened.joint("a").force, loop.joint("a").force)
    assert opened.animate().html == loop.animate().html
    require_same(loop, pickle.loads(pickle.dumps(opened)))
    require_same(loop, ks.open_run(kept(opened, tmp_path)))


def test_a_file_of_before_there_was_a_digest_says_what_to_do(
    loop: ks.Result, tmp_path: Path
) -> None:
    text = refused(forged(kept(loop, tmp_path), about=about(format=1), digest=lambda _: None))
    assert "its format is 1, this kousoku reads 2; make the run again" in text


@pytest.mark.parametrize("name", ["rows", "positions", "condition", "about"])
def test_a_number_that_was_changed_is_not_read_as_a_result(
    loop: ks.Result, lever: ks.Result, tmp_path: Path, name: str
) -> None:
    path = kept(loop if name == "rows" else lever, tmp_path)
    with np.load(path) as file:
        arrays: dict[str, Any] = dict(file)
    changed = arrays[OWN + name].copy()
    if name == "about":
        changed = about(name="other")(changed)
    else:
        changed.view(np.uint8).flat[-2] ^= 1
    np.savez(path, **(arrays | {OWN + name: changed}))
    assert "its content is not what was saved, as its digest tells" in refused(path)


def test_a_linkage_is_opened_as_it_was(lever: ks.Result, tmp_path: Path) -> None:
    opened = ks.open_run(str(kept(lever, tmp_path)))
    require_same(lever, opened)
    np.testing.assert_array_equal(opened.node("O3").position, lever.node("O3").position)
    assert opened.animate().html == lever.animate().html
    with pytest.raises(AttributeError, match=r'load\(\.\.\., outputs=\[\.\.\., "angles"\]\)'):
        assert opened.link("l1").angle
    require_same(lever, ks.open_run(kept(opened, tmp_path)))


def test_what_was_opened_is_drawn(loop: ks.Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    opened = ks.open_run(kept(loop, tmp_path))
    pictures = []
    for run in (loop, opened):
        buffer = io.BytesIO()
        run.plot("crank_angle").savefig(buffer, format="raw")
        pictures.append(buffer.getvalue())
    assert pictures[0] == pictures[1]


@pytest.mark.usefixtures("numpy_solver")
def test_columns_may_have_the_names_of_arguments_of_numpy(tmp_path: Path) -> None:
    run = ks.load(SLIDER, target="numpy").simulate(0.01, samples=3)
    with np.load(kept(run, tmp_path)) as columns:
        for name in ("file", "allow_pickle", "kousoku.x"):
            np.testing.assert_array_equal(columns[name], run[name])
    require_same(run, ks.open_run(tmp_path / "run.npz"))


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    mechanism = ks.load(SCENES / "lever_crank.toml", target="numpy")
    files = [kept(mechanism.solve(), tmp_path).read_bytes() for _ in range(2)]
    assert files[0] == files[1]


def refused(path: Any) -> str:
    with pytest.raises(ks.SolveError) as caught:
        ks.open_run(path)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 400
    return text


def test_what_is_no_file_of_a_run_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "text.npz").write_text("time,x\n0,1\n")
    (tmp_path / "empty.npz").write_bytes(b"")
    np.save(tmp_path / "one.npy", np.zeros(3))
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    pickled: dict[str, Any] = {f"{OWN}about": np.array([{}], dtype=object)}
    np.savez(tmp_path / "pickled.npz", **pickled)
    for name in ("text.npz", "empty.npz", "one.npy", "other.npz", "pickled.npz"):
        assert refused(tmp_path / name).startswith(f"{tmp_path / name}: holds no run (")
    assert refused(tmp_path / "none.npz").endswith(
        "none.npz: cannot be read: No such file or directory"
    )
    assert "cannot be read: " in refused(tmp_path)
    for given in (7, None, b"x"):
        assert "holds no run" in refused(given) or "cannot be read" in refused(given)


def test_a_file_that_is_compressed_is_refused_before_it_fills_the_memory(
    lever: ks.Result, tmp_path: Path
) -> None:
    lever.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as found:
        np.savez_compressed(tmp_path / "small.npz", **dict(found))
    with pytest.raises(ks.SolveError, match="it is compressed, and may be larger than any memory"):
        ks.open_run(tmp_path / "small.npz")


def test_a_file_that_was_cut_off_or_changed_is_refused(lever: ks.Result, tmp_path: Path) -> None:
    path = kept(lever, tmp_path)
    data = path.read_bytes()
    for length in range(0, len(data), len(data) // 40):
        path.write_bytes(data[:length])
        refused(path)
    middle = data.index(f"{OWN}positions".encode()) + 400
    path.write_bytes(data[:middle] + bytes([data[middle] ^ 0x10]) + data[middle + 1 :])
    assert "Bad CRC-32" in refused(path)


def forged(path: Path, **changed: Callable[[Any], Any]) -> Path:
    """Write a file again with other arrays of its own, and with their digest."""
    with np.load(path) as file:
        arrays = dict(file)
    for name, change in changed.items():
        if (new := change(arrays.pop(OWN + name))) is not None:
            arrays[OWN + name] = new
    if "digest" not in changed:
        own = {name.removeprefix(OWN): arrays[name] for name in arrays if name.startswith(OWN)}
        del own["digest"]
        arrays[f"{OWN}digest"] = np.array(digest_of(own))
    other = path.with_name("forged.npz")
    with zipfile.ZipFile(other, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w") as entry:
                np.lib.format.write_array(entry, values)
    return other


def about(**parts: Any) -> Callable[[Any], Any]:
    def change(text: Any) -> Any:
        data = json.loads(str(text))
        for place, value in parts.items():
            *way, last = place.split("__")
            inside = data
            for key in way:
                inside = inside[int(key) if isinstance(inside, list) else key]
            inside[last] = value
        return np.array(json.dumps(data))

    return change


def spoiled(*place: int, value: float = np.nan) -> Callable[[Any], Any]:
    def change(values: Any) -> Any:
        values = values.copy()
        values[place] = value
        return values

    return change


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"about": about(format=3)}, "its format is 3, this kousoku reads 2"),
        ({"digest": lambda _: None}, "KeyError: 'digest'"),
        ({"about": about(type="wires")}, "Invalid value 'wires'"),
        ({"about": about(unit=7)}, "Expected `str`, got `int`"),
        ({"about": lambda _: np.array("{")}, "DecodeError"),
        ({"about": lambda _: np.zeros(2)}, "Expected `object`, got `array`"),
        ({"about": lambda _: None}, "nothing says what its columns belong to"),
        ({"about": about(parts__positions=["O1"])}, "wanted doubles"),
        ({"positions": lambda x: x[:-1]}, "wanted doubles"),
        ({"positions": lambda x: x.astype(complex)}, "wanted doubles"),
        ({"positions": lambda _: None}, "KeyError: 'positions'"),
        ({"positions": spoiled(3, 1, 0)}, "positions has numbers that are not finite"),
        ({"inputs": spoiled(3, 0, value=np.inf)}, "inputs has numbers that are not finite"),
        ({"positions": spoiled(3, 1, 0, value=1e308)}, "positions has numbers that are too large"),
        ({"residual": lambda x: x[:5]}, "wanted 5 counts"),
        ({"residual": lambda x: x[:, None]}, "wanted doubles"),
        ({"iterations": lambda x: x.astype(float)}, "wanted "),
    ],
)
def test_a_forged_linkage_is_refused(
    lever: ks.Result, tmp_path: Path, changed: dict[str, Any], says: str
) -> None:
    assert says in refused(forged(kept(lever, tmp_path), **changed))


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"about": about(layout__sizes={"q": 1})}, "do not begin with t, q and v"),
        ({"about": about(layout__unit=0.0)}, "is not so"),
        ({"about": about(layout__bodies__0__r=[0, 1, 99])}, "is not so"),
        ({"about": about(layout__bodies__0__r=[0, 1, -1])}, "is not so"),
        ({"about": about(layout__bodies__0__r=[0, 1])}, "is not so"),
        ({"about": about(layout__reactions__0__j=9)}, "is not so"),
        ({"about": about(layout__coordinates=[["x", True, [0, 90]]])}, "is not so"),
        ({"about": about(layout__works=[["x", 90]])}, "is not so"),
        ({"about": about(figures=3)}, "Expected `object`"),
        ({"rows": lambda x: x[:, :-1]}, "wanted doubles"),
        ({"rows": lambda x: x.astype(np.float32)}, "wanted doubles"),
        ({"rows": spoiled(4, 3)}, "rows has numbers that are not finite"),
        ({"rows": spoiled(4, 3, value=-2e150)}, "rows has numbers that are too large"),
        ({"rows": spoiled(4, 0, value=-1.0)}, "its times do not ascend"),
        ({"rows": lambda _: None}, "KeyError: 'rows'"),
    ],
)
def test_a_forged_run_of_bodies_is_refused(
    loop: ks.Result, tmp_path: Path, changed: dict[str, Any], says: str
) -> None:
    assert says in refused(forged(kept(loop, tmp_path), **changed))


def test_another_scene_than_the_one_that_moved_is_not_drawn(
    lever: ks.Result, tmp_path: Path
) -> None:
    for text in (SLIDER, "name = 3"):
        opened = ks.open_run(forged(kept(lever, tmp_path), about=about(scene=text)))
        assert len(opened) == len(lever)
        with pytest.raises(ks.KousokuError, match=r"not the one that moved|name"):
            opened.animate()


def test_no_array_that_was_not_read_is_given(lever: ks.Result, tmp_path: Path) -> None:
    path = kept(lever, tmp_path)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f8", "fortran_order": False, "shape": (10_000_000,)}
    )
    with np.load(path) as file:
        arrays = dict(file)
    with zipfile.ZipFile(path, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w") as entry:
                if name == f"{OWN}residual":
                    entry.write(header.getvalue())
                else:
                    np.lib.format.write_array(entry, values)
    assert "EOF" in refused(path)


def test_a_motion_that_stopped_and_a_run_know_what_moved(tmp_path: Path, compiler: object) -> None:
    loop = ks.load(SCENES / "loop_free.toml")
    with pytest.raises(ks.MotionError) as stop:
        loop.simulate(1, most_steps=3)
    begun = loop.begin([0.0, 0.1])
    again = pickle.loads(pickle.dumps(begun))
    results: list[Any] = [stop.value.result, begun.finish(), again.finish()]
    for motion in results:
        motion.save(tmp_path / "run.npz")
        assert ks.open_run(tmp_path / "run.npz").animate() is not None
        assert motion.animate() is not None


def test_events_are_kept_with_a_run(compiler: object, tmp_path: Path) -> None:
    events = """
[events]
back = { when = "file_dot", action = "count" }
over = { when = "t - 0.25", action = "stop" }
"""
    path = tmp_path / "slider.toml"
    path.write_text(SLIDER + events, encoding="utf-8")
    run: Any = ks.load(path).simulate(1.0, samples=11)
    run.save(tmp_path / "run.npz")
    again: Any = ks.open_run(tmp_path / "run.npz")
    assert again.stopped_by == run.stopped_by == "over"
    assert again.events["over"].time == pytest.approx([0.25], abs=1e-15)
    assert again.events["back"].count == run.events["back"].count
    np.testing.assert_array_equal(again.rows, run.rows)
    np.testing.assert_array_equal(again.told.rows, run.told.rows)
