"""Pictures of the studio: a visitor goes through it in Chromium, which takes them on the way."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path
from typing import Any, Final

from docs.browsing import chromium

PROJECT: Final = Path(__file__).parent.parent
SIZE: Final = {"width": 1280, "height": 720}
SEAM: Final = """\
program seam

tool gun tip [0, 0, 120] [1, 0, 0, 0]

target above [400, -80, 260] [0, 0, 1, 0]
target begin [400, -80, 200] [0, 0, 1, 0]
target end [460, 90, 200] [0, 0, 1, 0]

procedure main
  move joint above speed 200 mm/s blend fine tool gun
  move linear begin speed 100 mm/s blend fine tool gun
  move {0} end speed 40 mm/s blend fine tool gun
  message "done"
end
"""
PROJECT_FILE: Final = """\
[controllers.cell1]
address = "virtual:irc5"
robot = "irb1200-7-0.7"

[programs.seam]
source = "seam.pseudo"

[targets.cell1]
programs = ["seam"]
"""


def studio_drawing(page: Any, _: Path) -> None:
    """A drawing that was dropped, and what is done on each of its layers."""
    page.set_input_files("#drop-file", str(PROJECT / "samples" / "plate.dxf"))
    page.wait_for_selector("#panel-drawing polyline", state="attached")
    page.fill("[data-path='tools.tool.tip']", "0, 0, 120")
    page.fill("[data-path='frames.work.position']", "150, 0, 100")
    page.fill("[data-layer=GLUE] [data-key=process]", "gluing")
    page.click("#panel-drawing .foot > button")
    page.wait_for_selector("#scene-of:has-text('plate.dxf')", state="attached")
    page.wait_for_selector("#drag-state:empty", state="attached")
    page.locator("#panel-drawing .scroll").evaluate("(one) => one.scrollTo(0, 0)")


def studio_editor(page: Any, folder: Path) -> None:
    """A word that is wrong, with the fix that is offered for it."""
    _opened(page, folder, "lineer")
    page.locator("#findings .fix").first.wait_for()


def studio_run(page: Any, folder: Path) -> None:
    """A program on the virtual controller: the scene, the time line and its plots."""
    _opened(page, folder, "linear")
    page.locator("#scene iframe").wait_for()
    page.click("#tab-run")
    page.click("#run-start:not(:disabled)")
    page.locator("#plot-joints path").first.wait_for(state="attached")
    page.locator("#run-over-time").scroll_into_view_if_needed()


def studio_controller(page: Any, folder: Path) -> None:
    """What somebody changed on the controller since it was deployed."""
    _opened(page, folder, "linear")
    page.click("#build")
    page.locator("#files [data-path='build/cell1/seam.mod']").wait_for()
    page.click("#tab-controller")
    page.click("#connect-form button")
    page.wait_for_selector("#monitor table")
    page.click("#plan")
    page.wait_for_selector("#programs >> text=create")
    page.click("#deploy:not(:disabled)")
    page.wait_for_selector("#programs >> text=installed")
    there = folder / ".robot-assistant" / "virtual" / "cell1" / "home" / "seam.mod"
    there.write_text(there.read_text("utf-8").replace("v40", "v60"), encoding="utf-8")
    page.click("#verify")
    page.wait_for_selector("#drift.changed")
    page.locator("#programs").scroll_into_view_if_needed()


def _opened(page: Any, folder: Path, word: str) -> None:
    (folder / "seam.pseudo").write_text(SEAM.format(word), encoding="utf-8")
    (folder / "assistant.toml").write_text(PROJECT_FILE, encoding="utf-8")
    page.reload()
    page.locator("#files [data-path='seam.pseudo']").click()
    page.wait_for_selector("#editor .word-keyword")


STAGES: Final = (studio_drawing, studio_editor, studio_run, studio_controller)


def names() -> tuple[str, ...]:
    """Of the pictures."""
    return tuple(stage.__name__ for stage in STAGES)


def picture(name: str) -> bytes:
    """One of them, as PNG."""
    stage = next(one for one in STAGES if one.__name__ == name)
    with _page() as (page, folder):
        page.set_default_timeout(120_000)
        stage(page, folder)
        page.locator("#folder").evaluate("(one) => { one.hidden = true; }")
        page.wait_for_timeout(3000)
        taken: bytes = page.screenshot()
    return taken


@contextmanager
def _page() -> Iterator[tuple[Any, Path]]:
    """A studio of an empty folder, in a browser."""
    from assistant.studio.server import serving

    with tempfile.TemporaryDirectory() as name, chdir(PROJECT):
        folder = Path(name) / "cell"
        folder.mkdir()
        with serving(folder) as served, chromium() as opened:
            page = opened.new_page(viewport=SIZE, locale="en", color_scheme="light")
            page.goto(served.address)
            page.wait_for_selector("body.ready")
            yield page, folder
