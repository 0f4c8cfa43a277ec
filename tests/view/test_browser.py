"""The page in a real browser: it draws the arm and the path, and poses the arm as Python does."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

from assistant import robots
from assistant.cell.arms import placed
from assistant.cell.collision.carriers import Carriers
from assistant.program.arrays import Floats
from assistant.program.geometry import Pose
from tests.cli.test_commands import run
from tests.view.cases import data_of, numbers, written

BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome")
SOFTWARE: Final = (  # draws without a graphics card
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"),
    *("--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip("there is no Chromium here: apt-get install chromium")
    with playwright.sync_playwright() as one:
        opened = one.chromium.launch(executable_path=found, args=list(SOFTWARE))
        yield opened
        opened.close()


@pytest.fixture
def opened(
    browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> Iterator[tuple[Any, str]]:
    """The page of a program that touches a post, and its text; nothing goes wrong on it."""
    pytest.importorskip("coal")
    program, cell = written(tmp_path)
    out = tmp_path / "seam.html"
    run(capsys, "view", program, "--cell", cell, "--html", out)
    capsys.readouterr()
    page = browser.new_page(viewport={"width": 800, "height": 500})
    wrong: list[str] = []
    asked: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda fault: wrong.append(str(fault)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(out.as_uri())
    until(page, "view.drawn() > 0")
    yield page, out.read_text(encoding="utf-8")
    page.close()
    assert wrong == []
    assert asked == [out.as_uri()]


def until(page: Any, what: str) -> None:
    """Waits for what scripts of the page tell; playwright's own way is not allowed on it."""
    for _ in range(200):
        if page.evaluate(what):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"not within 10 s: {what}")


def picture(page: Any) -> Floats:
    """The scene as (height, width, 3), 0 to 1."""
    from matplotlib.image import imread

    page.wait_for_timeout(200)
    return np.asarray(imread(io.BytesIO(page.locator("canvas").screenshot())))[:, :, :3]


def test_arm_path_and_bodies_are_in_the_picture(opened: tuple[Any, str]) -> None:
    page, _ = opened
    seen = picture(page)
    red, green, blue = np.moveaxis(seen, 2, 0)
    assert ((red > 1.3 * green) & (green > 1.3 * blue)).sum() > 5000  # orange links
    assert ((blue > 2.0 * red) & (blue > 2.0 * green)).sum() > 500  # the blue post
    box = page.get_by_label("path of the tool")
    box.uncheck()
    without = picture(page)
    changed = np.abs(seen - without).max(axis=2) > 0.05
    assert 50 < changed.sum() < 0.05 * changed.size  # a line, and nothing else
    assert np.ptp(np.flatnonzero(changed.any(axis=1))) > 50


@pytest.mark.slow
def test_the_arm_moves_with_the_time_line(opened: tuple[Any, str]) -> None:
    page, _ = opened
    before = picture(page)
    page.get_by_role("slider").fill("1.5")
    assert page.evaluate("view.time()") == pytest.approx(1.5, abs=0.01)
    assert (np.abs(picture(page) - before).max(axis=2) > 0.05).mean() > 0.01
    page.locator("#play").click()
    until(page, "view.time() > 1.6")
    page.locator("#after").click()
    assert page.locator("#moves button.now").count() == 1


@pytest.mark.slow
def test_the_page_poses_links_where_they_are(opened: tuple[Any, str]) -> None:
    page, text = opened
    robot = robots.get("irb1200-7-0.7")
    carriers = Carriers((placed("arm", robot, Pose((50.0, 0.0, 20.0))),))
    motion = data_of(text)["motion"]
    times = numbers(motion["times"])
    joints = np.degrees(numbers(motion["joints"]).reshape(len(times), 6)) - robot.zero
    for row in (0, len(times) // 3, len(times) - 1):
        page.evaluate(f"view.setTime({times[row]})")
        seen = np.array(page.evaluate("view.carriers()")).reshape(-1, 4, 4)  # column by column
        origins, turns = carriers.at(joints[row : row + 1])
        assert np.abs(seen[:, 3, :3] - origins[0]).max() < 0.01
        assert np.abs(seen[:, :3, :3].transpose(0, 2, 1) - turns[0]).max() < 1e-5


@pytest.mark.slow
def test_a_finding_leads_into_the_scene_and_a_move_to_its_time(opened: tuple[Any, str]) -> None:
    page, text = opened
    data = data_of(text)
    at = next(i for i, one in enumerate(data["findings"]) if (one["mark"] or {}).get("time"))
    page.locator("#findings button").nth(at).click()
    assert page.evaluate("view.time()") == pytest.approx(data["findings"][at]["mark"]["time"])
    page.locator("#moves button").nth(2).click()
    assert page.evaluate("view.time()") == pytest.approx(data["moves"][2]["time"])
    assert "16" in page.locator("#moves button.now").inner_text()
