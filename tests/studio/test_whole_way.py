"""From an empty folder to a program that is taken back from a controller, in a real browser."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

import pytest

from tests.cli.test_commands import SAMPLES
from tests.studio.browsing import TABLET, WIDE, clean, studio_page, until

GREETING: Final = """\
program greeting

tool pen tip [0, 0, 120] [1, 0, 0, 0]

target above [400, 0, 300] [0, 0, 1, 0]

procedure greet
  mve joint above speed 200 mm/s blend fine tool pen
  message "hello"
end
"""
DROPS: Final = """([name, bytes]) => {
  const data = new DataTransfer();
  data.items.add(new File([new Uint8Array(bytes)], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true }));
}"""


def drop(page: Any, name: str, data: bytes) -> None:
    """As from the desktop."""
    page.evaluate(DROPS, [name, list(data)])
    page.locator(f"#files [data-path$='{name}']").wait_for()


def begun(page: Any, folder: Path) -> None:
    page.click("#create-empty")
    page.locator("#files [data-path='assistant.toml']").wait_for()
    assert page.locator("#begin").is_hidden()
    assert (folder / "assistant.toml").is_file()


def drawn(page: Any, folder: Path) -> None:
    """The drawing has a picture, and its process the finding of each blank."""
    drop(page, "plate.dxf", (SAMPLES / "plate.dxf").read_bytes())
    page.wait_for_selector("#panel-drawing polyline", state="attached")
    assert "CT303" in page.inner_text("#findings")


def processed(page: Any, folder: Path) -> None:
    page.fill("[data-path='tools.tool.tip']", "0, 0, 120")
    page.fill("[data-path='frames.work.position']", "150, 0, 100")
    page.fill("[data-layer=GLUE] [data-key=process]", "gluing")
    page.fill("[data-layer=GLUE] [data-key=speed]", "80")
    page.click("#panel-drawing .foot > button")
    until(page, "!document.querySelector('#findings').innerText.includes('CT303')")
    stated = tomllib.loads((folder / "drawings" / "plate.process.toml").read_text("utf-8"))
    assert stated["layers"]["GLUE"]["process"] == "gluing"


def programmed(page: Any, folder: Path) -> None:
    """A word that is wrong gets its own by the fix that is offered, and is saved."""
    drop(page, "greeting.pseudo", GREETING.encode())
    page.locator("#findings .fix", has_text="move").first.click()
    until(page, "!document.querySelector('#findings li.error')")
    page.click("#save")
    until(page, "document.querySelector('#file-state').dataset.word === 'saved'")
    text = (folder / "programs" / "greeting.pseudo").read_text("utf-8")
    assert text == GREETING.replace("mve", "move")


def seen(page: Any, folder: Path) -> None:
    """The drawing in its cell, and not what was shown before."""
    page.locator("#files [data-path='drawings/plate.dxf']").click()
    page.click("#tab-scene")
    page.click("#show-scene")
    page.locator("#scene iframe[title*='plate.dxf']").wait_for()
    until(page, "document.querySelectorAll('#scene iframe').length === 1")


def ran(page: Any, folder: Path) -> None:
    """The drawing as a program, on the virtual controller: what it did, and its plots."""
    page.click("#tab-run")
    until(page, "document.querySelector('#run-program').value === 'drawings/plate.dxf'")
    until(page, "document.querySelector('#run-robot').value === 'irb1200-7-0.7'")
    page.click("#run-start:not(:disabled)")
    page.locator("#plot-joints path").first.wait_for(state="attached")
    page.press("#run-log-part summary", "Enter")
    page.wait_for_selector("#run-log >> text=line to")


def built(page: Any, folder: Path) -> None:
    page.click("#build")
    page.locator("#files [data-path='build/cell1/greeting.mod']").wait_for()
    page.locator("#files [data-path='build/cell1/plate.mod']").wait_for()


def deployed(page: Any, folder: Path) -> None:
    page.click("#tab-controller")
    page.click("#connect-form button")
    page.wait_for_selector("#monitor table")
    page.click("#plan")
    page.wait_for_selector("#programs >> text=create")
    page.click("#deploy:not(:disabled)")
    page.wait_for_selector("#programs >> text=installed")
    assert there(folder).is_file()


def there(folder: Path) -> Path:
    """The program on the virtual controller."""
    return folder / ".robot-assistant" / "virtual" / "cell1" / "home" / "greeting.mod"


def drifted(page: Any, folder: Path) -> None:
    """Somebody else changes the program on the controller."""
    file = there(folder)
    file.write_text(file.read_text("utf-8").replace("hello", "good bye"), encoding="utf-8")
    page.click("#verify")
    page.wait_for_selector("#drift.changed")
    assert "good bye" in page.locator("#programs").text_content()


def rolled_back(page: Any, folder: Path) -> None:
    """First it is refused, as what was changed there would be lost; then it is said."""
    page.evaluate("document.querySelector('#programs table').classList.add('before')")
    page.click("#roll-back")
    page.wait_for_selector("#findings li.error")
    page.wait_for_selector("#programs table:not(.before)")
    assert there(folder).is_file()
    page.check("#programs input[value='greeting.mod']")
    page.click("#roll-back")
    page.wait_for_selector("#programs >> text=put back")
    assert not there(folder).exists()


STAGES: Final = (
    *(begun, drawn, processed, programmed, seen, ran, built, deployed, drifted, rolled_back),
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "options"),
    [
        (WIDE, {}),
        (TABLET, {"has_touch": True, "color_scheme": "dark"}),
        ({"width": 640, "height": 400}, {"device_scale_factor": 2}),  # as at 200 %
    ],
    ids=["wide", "tablet", "twice"],
)
def test_the_whole_way(
    browser: Any, address: str, folder: Path, size: dict[str, int], options: dict[str, Any]
) -> None:
    with studio_page(browser, address, size, **options) as page:
        for stage in STAGES:
            stage(page, folder)
            _nothing_wider_than_the_window(page)
        assert page.wrong == []


def test_the_short_way(browser: Any, address: str, folder: Path) -> None:
    """An empty project, a drawing and its process, a program whose fault is fixed."""
    with studio_page(browser, address) as page, clean(page):
        for stage in (begun, drawn, processed, programmed):
            stage(page, folder)


def _nothing_wider_than_the_window(page: Any) -> None:
    """At no size does the page scroll sideways."""
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
