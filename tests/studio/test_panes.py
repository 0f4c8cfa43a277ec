"""The panes of the page: nothing is cut off, and borders stay where they were put."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.cli.test_commands import SAMPLES
from tests.studio import test_whole_way as way
from tests.studio.browsing import clean, studio_page, until
from tests.studio.serving import Page
from tests.view.boxes import wrong_boxes

PLATE = (SAMPLES / "plate.dxf").read_bytes()


def dropped(page: Page) -> None:
    assert page.post("project/create", empty=True).status == 200
    assert page.send("project/drop", PLATE, name="plate.dxf").status == 200


def test_a_drawing_without_a_place_is_shown_alone(page: Page) -> None:
    dropped(page)
    shown = page.post("scene/show", path="drawings/plate.dxf").value
    assert shown["alone"] and not shown["moves"] and shown["handles"] == []
    assert {one["code"] for one in shown["findings"]} == {"CT303"}
    there = page.get(f"scene/{shown['name']}/page")
    assert there.status == 200 and '"drawn":[{"layer":"GLUE"' in there.value
    stated = {
        "tools": {"tool": {"tip": [0, 0, 120]}},
        "frames": {"work": {"position": [150, 0, 100]}},
    }
    assert page.post("drawing/process", path="drawings/plate.dxf", values=stated).status == 200
    shown = page.post("scene/show", path="drawings/plate.dxf").value
    assert shown["moves"] and not shown["alone"]


def test_the_robot_and_the_tool_of_a_drawing_are_chosen(page: Page, folder: Path) -> None:
    dropped(page)

    def field(name: str) -> Any:
        values = page.get("drawing", path="drawings/plate.dxf").value["values"]
        return next(one for one in values if one["field"] == name)

    assert field("robot")["value"] == "" and "rv-4frl" in field("robot")["choices"]
    assert field("motion.tool")["choices"] == ["tool"]
    asked = {"path": "drawings/plate.dxf", "values": {"robot": "irb1600-10-1.45"}}
    assert page.post("drawing/process", **asked).status == 200
    project = tomllib.loads((folder / "assistant.toml").read_text("utf-8"))
    assert project["programs"]["plate"]["robot"] == field("robot")["value"] == "irb1600-10-1.45"
    assert "robot" not in tomllib.loads(
        (folder / "drawings" / "plate.process.toml").read_text("utf-8")
    )
    wrong = page.post("drawing/process", path="drawings/plate.dxf", values={"robot": "nobody"})
    assert wrong.status == 422
    page.post("drawing/process", path="drawings/plate.dxf", values={"robot": None})
    assert field("robot")["value"] == ""


@pytest.mark.slow
def test_nothing_is_cut_off_or_stands_over_another(
    browser: Any, address: str, folder: Path
) -> None:
    with studio_page(browser, address) as page, clean(page):
        assert wrong_boxes(page) == {}
        assert (
            page.locator("#text-bar, #scene-bar, #project-does").filter(visible=True).count() == 0
        )
        for stage in (way.begun, way.drawn, way.processed, way.programmed, way.seen, way.ran):
            stage(page, folder)
            assert wrong_boxes(page) == {}, stage.__name__
        way.built(page, folder)
        page.click("#tab-controller")
        page.click("#connect-form button")
        page.wait_for_selector("#monitor table")
        assert wrong_boxes(page) == {}
        paths = (
            "[...document.querySelectorAll('#files [data-path]')].map((one) => one.dataset.path)"
        )
        settings = ["assistant.schema.json", "assistant.toml"]
        assert page.evaluate(paths)[-2:] == settings


@pytest.mark.slow
def test_borders_are_pulled_and_stay(browser: Any, address: str) -> None:
    with studio_page(browser, address) as page, clean(page):
        wide = "document.querySelector('#work').getBoundingClientRect().width"
        before, box = page.evaluate(wide), page.locator("#split-work").bounding_box()
        page.mouse.move(box["x"] + 2, box["y"] + 200)
        page.mouse.down()
        page.mouse.move(box["x"] + 152, box["y"] + 200, steps=3)
        page.mouse.up()
        assert page.evaluate(wide) == pytest.approx(before + 150, abs=4)
        page.reload()
        page.wait_for_selector("body.ready")
        assert page.evaluate(wide) == pytest.approx(before + 150, abs=4)
        page.focus("#split-work")
        page.keyboard.press("ArrowLeft")
        assert page.evaluate(wide) == pytest.approx(before + 134, abs=4)
        page.dblclick("#split-work")
        assert page.evaluate(wide) == pytest.approx(before, abs=1)


@pytest.mark.slow
def test_findings_are_closed_until_there_is_one(browser: Any, address: str, folder: Path) -> None:
    with studio_page(browser, address) as page, clean(page):
        assert page.locator("#findings").is_hidden()
        way.drop(page, "plate.dxf", PLATE)
        page.locator("#findings li.error").first.wait_for()
        page.click("#fold-findings")
        assert page.locator("#findings").is_hidden()
        page.click("#check")
        until(page, "document.querySelector('#findings').getAttribute('aria-busy') === 'false'")
        kinds = page.evaluate(
            "[...document.querySelectorAll('#findings li')].map((one) => one.className)"
        )
        assert kinds == sorted(kinds, key=("error", "warning", "info").index)
