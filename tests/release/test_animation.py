"""The page that shows a motion, in a browser: it moves, it is silent, it asks nobody for anything.

Needs Chromium with its driver, and selenium. Where they are missing the tests are skipped, unless
``KOUSOKU_BROWSER=required`` says that they must not be.
"""

from __future__ import annotations

import io
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import pytest
from msgspec import structs

from kousoku.model.reading.families import chain
from kousoku.model.reading.read import read_scene
from kousoku.runtime.dynamics import load_dynamics
from kousoku.view import animate
from tests.view.runs import arm, lever_crank, turning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.runtime.toolchain import Toolchain

SCENES = Path(__file__).parents[2] / "scenes"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--window-size=900,640", "--hide-scrollbars"),
)
HOSTILE = "</script><script>document.title='taken'</script><img src=x onerror=alert(2)>"
#: Milliseconds of script for a frame of 50 bodies: a sixtieth of a second, on a machine that has
#: more to do.
FRAME = 50.0


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Start a browser that has seen nothing before."""
    try:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
    except ImportError:
        _missing("selenium is not installed: pip install kousoku[browser]")
    program = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        _missing("no chromium with chromedriver: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = str(program)
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('browser')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    found = webdriver.Chrome(options=options, service=Service(str(driver)))
    yield found
    found.quit()


def _missing(reason: str) -> NoReturn:
    if os.environ.get("KOUSOKU_BROWSER") == "required":
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)


@pytest.fixture(scope="module")
def pages(
    tmp_path_factory: pytest.TempPathFactory,
    bodies_folder: Callable[..., Path],
    compiler: Toolchain,
) -> dict[str, Path]:
    """Write a page of a spatial loop, of a planar linkage, of a chain, and of hostile names."""
    folder = tmp_path_factory.mktemp("pages")
    assert compiler is not None
    for scene, end in ((read_scene(SCENES / "loop.toml"), 2.0), (chain(50), 1.0)):
        solver = load_dynamics(bodies_folder(scene, ("reactions",)), target="c")
        animate(solver.simulate(end, samples=201), scene, folder / f"{scene.name}.html")
    animate(*lever_crank(), folder / "lever_crank.html")
    animate(turning(), structs.replace(arm(), title=HOSTILE), folder / "hostile.html")
    for turns in (1, 48):
        run = turning(rows=21 * turns, end=turns * np.pi)
        animate(run, arm(), folder / f"turns_{turns}.html", paths_of=[("bar", (0.5, 0, 0))])
    cell = animate(turning(), arm())._repr_html_()
    (folder / "cell.html").write_text(f"<!doctype html><title>notebook</title>{cell}", "utf-8")
    return {path.stem: path for path in folder.iterdir()}


class Shown:
    """A page in the browser.

    Parameters
    ----------
    browser : WebDriver
        The browser.
    path : Path
        The page.
    time : float, optional
        Where it stands; it plays unless given.
    """

    def __init__(self, browser: Any, path: Path, time: float | None = None) -> None:
        self.browser = browser
        browser.get("about:blank")
        self.entries("browser")
        self.entries("performance")
        self.url = path.as_uri()
        browser.get(self.url + ("" if time is None else f"#t={time}"))
        self.wait()

    def entries(self, kind: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.browser.get_log(kind)
        return found

    def wait(self, seconds: float = 0.0) -> None:
        """Let the page draw at least two frames, and wait that long."""
        self.browser.execute_async_script(
            "const [seconds, done] = arguments;"
            "setTimeout(() => requestAnimationFrame(() => requestAnimationFrame(() => done())),"
            " 1000 * seconds);",
            seconds,
        )

    def pixels(self) -> Any:
        """Pixels of the picture as it is seen, (height, width, 3)."""
        from PIL import Image

        data = self.find("picture").screenshot_as_png
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), dtype=float)

    def find(self, name: str) -> Any:
        return self.browser.find_element("id", name)

    def time(self) -> float:
        return float(self.find("time").text.split()[2])

    def press(self, key: str) -> None:
        from selenium.webdriver.common.action_chains import ActionChains

        ActionChains(self.browser).send_keys(key).perform()
        self.wait()

    def slide(self, time: float) -> None:
        self.browser.execute_script(
            "const [slider, value] = arguments; slider.value = value;"
            "slider.dispatchEvent(new Event('input'));",
            self.find("slider"),
            time,
        )
        self.wait()

    def drag(self, kind: str) -> None:
        """Drag over the picture with a mouse or a finger."""
        from selenium.webdriver.common.actions.action_builder import ActionBuilder
        from selenium.webdriver.common.actions.interaction import POINTER_MOUSE, POINTER_TOUCH
        from selenium.webdriver.common.actions.pointer_input import PointerInput

        kinds = {"mouse": POINTER_MOUSE, "touch": POINTER_TOUCH}
        device: Any = PointerInput
        actions = ActionBuilder(self.browser, mouse=device(kinds[kind], kind))
        pointer: Any = actions.pointer_action
        pointer.move_to(self.find("picture")).pointer_down().move_by(90, 40).pointer_up()
        actions.perform()
        self.wait()


def differ(first: Any, second: Any) -> int:
    """Number of pixels that differ."""
    return int((np.abs(first - second).max(axis=-1) > 8.0).sum())


@pytest.mark.parametrize("name", ["loop", "lever_crank", "chain_50", "hostile", "cell"])
def test_the_browser_has_nothing_to_say_and_the_page_asks_for_nothing(
    browser: Any, pages: dict[str, Path], name: str
) -> None:
    page = Shown(browser, pages[name])
    page.wait(0.3)
    assert page.entries("browser") == []
    sent = [
        e["message"] for e in page.entries("performance") if "requestWillBeSent" in e["message"]
    ]
    assert not [message for message in sent if '"url":"http' in message]
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_it_plays_from_the_start_and_pixels_change(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["turns_48"])  # so long that none begins anew, on a busy machine
    time, before = page.time(), page.pixels()
    page.wait(0.4)
    assert page.time() > time
    assert differ(before, page.pixels()) > 500
    page.find("play").click()
    page.wait()
    time, before = page.time(), page.pixels()
    page.wait(0.3)
    assert page.time() == time
    assert differ(before, page.pixels()) == 0


def test_it_takes_the_time_that_the_motion_takes(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["lever_crank"])
    script = "return [performance.now() / 1000, document.getElementById('slider').value]"
    clock, time = browser.execute_script(script)
    page.wait(1.0)
    later, reached = browser.execute_script(script)
    assert float(reached) - float(time) == pytest.approx(later - clock, abs=0.3)


def test_the_slider_and_the_address_set_the_time(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["loop"], 0.5)
    assert page.time() == 0.5
    for name in ("names", "axes", "paths", "forces"):  # the bodies move, not only what is beside
        page.find(name).click()
    page.wait()
    at_half = page.pixels()
    page.slide(1.5)
    assert page.time() == pytest.approx(1.5, abs=0.01)
    assert differ(at_half, page.pixels()) > 500
    page.slide(0.5)
    assert differ(at_half, page.pixels()) < 20


def test_keys_play_and_step(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["loop"], 1.0)
    page.press("\ue014")  # arrow to the right
    assert page.time() == pytest.approx(1.02, abs=1e-3)
    page.press("\ue012")  # and to the left
    assert page.time() == pytest.approx(1.0, abs=1e-3)
    page.press(" ")
    page.wait(0.3)
    assert page.time() > 1.0
    page.press(" ")
    time = page.time()
    page.wait(0.2)
    assert page.time() == time
    before = page.pixels()
    page.press("\ue013")  # arrow up: seen from higher
    assert differ(before, page.pixels()) > 500


@pytest.mark.parametrize("kind", ["mouse", "touch"])
def test_a_drag_turns_it_and_reset_turns_it_back(
    browser: Any, pages: dict[str, Path], kind: str
) -> None:
    page = Shown(browser, pages["loop"], 0.5)
    before = page.pixels()
    page.drag(kind)
    turned = page.pixels()
    assert differ(before, turned) > 2000
    page.find("reset").click()
    page.wait()
    assert differ(before, page.pixels()) < 20


def test_the_wheel_comes_nearer(browser: Any, pages: dict[str, Path]) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    page = Shown(browser, pages["loop"], 0.5)
    before = page.pixels()
    origin = ScrollOrigin.from_element(page.find("picture"))
    ActionChains(browser).scroll_from_origin(origin, 0, -300).perform()
    page.wait()
    assert differ(before, page.pixels()) > 2000


def test_dark_is_dark_and_light_is_light(browser: Any, pages: dict[str, Path]) -> None:
    seen = {}
    for theme in ("dark", "light"):
        media = {"features": [{"name": "prefers-color-scheme", "value": theme}]}
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", media)
        seen[theme] = Shown(browser, pages["loop"], 0.5).pixels()
    assert np.median(seen["dark"]) < 64
    assert np.median(seen["light"]) > 192


@pytest.mark.parametrize("name", ["names", "axes", "paths", "forces"])
def test_what_is_shown_can_be_chosen(browser: Any, pages: dict[str, Path], name: str) -> None:
    page = Shown(browser, pages["loop"], 0.5)
    with_it = page.pixels()
    assert page.find(name).is_selected()
    page.find(name).click()
    page.wait()
    assert differ(with_it, page.pixels()) > 100


def test_a_path_of_many_turns_is_round(browser: Any, pages: dict[str, Path]) -> None:
    """It covers what one turn does; chords between few points would cover what is inside."""
    covered = []
    for name in ("turns_1", "turns_48"):
        page = Shown(browser, pages[name], 0.0)
        with_it = page.pixels()
        page.find("paths").click()
        page.wait()
        covered.append(np.abs(with_it - page.pixels()).max(axis=-1) > 24.0)
    once, often = covered
    assert once.sum() > 500
    near = np.array([np.roll(once, (x, y), (0, 1)) for x in range(-2, 3) for y in range(-2, 3)])
    assert (often & ~near.any(axis=0)).sum() < 0.02 * once.sum()


def test_all_of_it_is_in_the_frame(browser: Any, pages: dict[str, Path]) -> None:
    """Links and pins are darker than grid and ground; none of them touches the border."""
    page = Shown(browser, pages["lever_crank"], 0.0)
    page.find("names").click()
    for time in np.linspace(0.0, 6.28, 9):
        page.slide(float(time))
        colored = np.ptp(page.pixels(), axis=-1) > 60.0
        assert colored.any()
        assert not colored[:, :4].any() and not colored[:, -4:].any()
        assert not colored[:4].any() and not colored[-4:].any()


def test_names_of_strangers_are_text(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["hostile"])
    assert browser.title == HOSTILE
    assert page.find("title").text == HOSTILE
    assert browser.find_elements("tag name", "img") == []


def test_it_plays_in_a_cell_of_a_notebook(browser: Any, pages: dict[str, Path]) -> None:
    Shown(browser, pages["cell"])
    frame = browser.find_element("tag name", "iframe")
    browser.switch_to.frame(frame)
    first = browser.find_element("id", "time").text
    browser.execute_async_script("setTimeout(arguments[0], 400)")
    second = browser.find_element("id", "time").text
    browser.switch_to.default_content()
    assert first != second


def test_fifty_bodies_are_drawn_in_time(browser: Any, pages: dict[str, Path]) -> None:
    page = Shown(browser, pages["chain_50"])
    took = []
    for _ in range(20):
        page.wait(0.02)
        took.append(float(page.find("picture").get_attribute("data-milliseconds")))
    assert 0.0 < np.median(took) < FRAME
