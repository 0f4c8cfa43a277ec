"""The scene of the studio: it goes where the text leads, and what is dragged there changes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.studio.browsing import clean, studio_page, until
from tests.studio.scenes import PROGRAM, codes, moved, page_text, shown
from tests.studio.serving import Page


def test_a_program_stands_in_its_cell(page: Page, cell: Path) -> None:
    assert (cell / "cell.toml").is_file()
    scene = shown(page, "seam.mod")
    assert scene["moves"]
    assert [(one["name"], one["line"]) for one in scene["handles"]] == [
        ("home", 4),
        ("left", 5),
        ("right", 6),
    ]
    assert scene["handles"][1]["position"] == [320.0, -50.0, 250.0]
    answer = page.get(f"scene/{scene['name']}/page")
    assert answer.status == 200
    assert "unsafe-inline" not in answer.value.split("<style", 1)[0]
    assert page.get("scene/nothing/page").status == 404


def test_rows_of_a_path_are_held_by_the_names_that_the_text_gives_them(
    page: Page, cell: Path
) -> None:
    assert cell.is_dir()
    found = {one["name"]: one["line"] for one in shown(page, "round.prg")["handles"]}
    assert found == {"P11": 9, "P12": 10, "P13": 11, "P14": 12, "P15": 13, "P3": 8}


def test_reach_and_touching_are_told_while_something_is_dragged(page: Page, cell: Path) -> None:
    assert cell.is_dir()
    scene = shown(page, "seam.mod")
    there = moved(page, scene, "left", 340.0, -60.0, 260.0).value
    assert (there["reached"], there["other"], there["touches"]) == (True, False, None)
    assert len(there["joints"]) == 6
    assert moved(page, scene, "left", 340.0, 60.0, 260.0).value["other"]  # J1 has passed 0
    low = moved(page, scene, "left", 340.0, -60.0, 205.0).value
    assert set(low["touches"]) == {"torch", "table"}
    far = moved(page, scene, "left", 1340.0, -60.0, 205.0).value
    assert (far["reached"], far["joints"]) == (False, None)


def test_what_is_typed_counts_before_it_is_saved(page: Page, cell: Path) -> None:
    assert cell.is_dir()
    page_text(page, "seam.mod")
    change = {"from": [4, 28], "to": [4, 30], "text": "60"}
    asked = {"path": "seam.mod", "version": 1, "changes": [change], "first": 0, "last": 9}
    assert page.post("text/change", **asked).status == 200
    scene = shown(page, "seam.mod")
    assert scene["handles"][1]["position"] == [360.0, -50.0, 250.0]


def test_what_cannot_be_shown_is_told(page: Page, cell: Path) -> None:
    (cell / "broken.mod").write_text("MODULE broken\n  PROC main(\nENDMODULE\n")
    (cell / "alone.process.toml").write_text('unit = "mm"\n')
    assert page.post("scene/show", path="broken.mod").status == 422
    assert codes(page.post("scene/show", path="alone.process.toml")) == ["ST051"]
    assert codes(page.post("scene/show", path="../elsewhere.mod")) == ["ST023"]
    lost = page.post("scene/moved", name="nothing", handle=0, position=[0, 0, 0])
    assert codes(lost) == ["ST050"]
    scene = shown(page, "seam.mod")
    for wrong in ({"handle": 99}, {"handle": 0.5}, {"handle": 0, "position": [1, 2]}):
        asked = {"name": scene["name"], "handle": 0, "position": [0, 0, 0], **wrong}
        assert codes(page.post("scene/moved", **asked)) == ["ST011"]


FRAME = "document.querySelector('#scene iframe')?.contentWindow"


def scene_is_there(window: Any, path: str) -> None:
    window.get_by_role("treeitem", name=path).click()
    until(window, f"{FRAME}?.view?.drawn() > 0")
    until(window, "document.querySelector('#drag-state').textContent === ''")


def on_page(window: Any, place: list[float]) -> tuple[float, float]:
    """Where a place of the world is on the page, px."""
    x, y = window.evaluate(f"{FRAME}?.view.seen({place})")
    box = window.locator("#scene iframe").bounding_box()
    return box["x"] + x, box["y"] + y


def lines(window: Any) -> list[str]:
    found: list[str] = window.locator("#editor .cm-line").all_text_contents()
    return found


def test_lines_lead_the_arm_and_what_is_dragged_changes_its_line(
    browser: Any, address: str, cell: Path
) -> None:
    with studio_page(browser, address) as window, clean(window):
        scene_is_there(window, "seam.mod")
        bar, scene = window.locator("#panel-scene .bar").first, window.locator("#scene iframe")
        assert scene.bounding_box()["y"] == sum(bar.bounding_box()[key] for key in ("y", "height"))
        window.click("#theme")
        ground = f"{FRAME}.getComputedStyle({FRAME}.document.body).backgroundColor"
        assert window.evaluate(ground) == "rgb(22, 27, 34)"
        view = f"{FRAME}?.view"
        before = window.evaluate(f"{view}.carriers()")
        window.locator("#editor .cm-line").nth(9).click()  # the line leads the arm
        until(window, f"{view}.time() > 0")
        assert window.evaluate(f"{view}.lineAt()") == {"path": "seam.mod", "line": 10}
        assert window.evaluate(f"{view}.carriers()") != before
        assert window.locator(".arm-here").inner_text().strip().startswith("MoveL right")
        at = on_page(window, [320.0, -50.0, 250.0])
        window.mouse.click(*at)  # the target leads to its line
        until(window, "document.querySelector('.cm-activeLineGutter').textContent === '5'")
        assert window.locator("#drag-name").inner_text() == "left"
        kept = lines(window)
        x, y = on_page(window, [320.0, -50.0, 250.0])
        window.mouse.move(x, y)
        window.mouse.down()
        window.mouse.move(x + 400, y - 300, steps=4)
        until(window, "document.querySelector('#drag-state').className === 'bad'")
        window.keyboard.press("Escape")
        window.mouse.up()
        assert lines(window) == kept
        window.mouse.move(x, y)
        window.mouse.down()
        window.mouse.move(x + 12, y - 9, steps=4)
        until(window, "document.querySelector('#drag-state').className === 'good'")
        window.mouse.up()
        until(window, "document.querySelectorAll('#editor .cm-line')[4].textContent.length > 86")
        assert [i for i, line in enumerate(lines(window)) if line != kept[i]] == [4]
        assert (cell / "seam.mod").read_text() == PROGRAM  # nobody has saved it
        window.locator("#undo").click()
        assert lines(window) == kept
        window.locator("#editor .cm-line").nth(0).click()
        window.keyboard.press("Control+Home")
        window.keyboard.type("x")  # what the scene shows is what was there before
        until(window, "document.querySelector('#drag-state').className === 'doubtful'")
        assert not window.evaluate(f"{view}.movable")


@pytest.mark.slow
def test_what_is_in_hand_is_moved_by_keys_and_by_numbers(
    browser: Any, address: str, cell: Path
) -> None:
    assert cell.is_dir()
    with studio_page(browser, address) as window, clean(window):
        scene_is_there(window, "seam.mod")
        view = f"{FRAME}?.view"
        window.mouse.click(*on_page(window, [320.0, -50.0, 250.0]))
        until(window, f"{view}.held() !== null")
        window.locator("#scene iframe").focus()
        window.keyboard.press("ArrowRight")
        window.keyboard.press("Shift+PageUp")
        until(window, f"{view}.held().place[2] === 260")
        assert window.evaluate(f"{view}.held().place") == [321.0, -50.0, 260.0]
        window.locator("#drag-y").fill("-42.5")
        window.locator("#drag-y").press("ArrowUp")
        window.locator("#drag-y").press("Enter")
        until(
            window,
            "document.querySelectorAll('#editor .cm-line')[4].textContent.includes('[21,8.5,60]')",
        )
        until(window, f"{view}?.held()?.place[2] === 260")
        window.keyboard.press("Escape")


@pytest.mark.slow
def test_a_drawing_is_dragged_as_a_whole(browser: Any, address: str, cell: Path) -> None:
    assert cell.is_dir()
    with studio_page(browser, address) as window, clean(window):
        scene_is_there(window, "ring.dxf")
        view = f"{FRAME}?.view"
        window.evaluate(f"{view}.take(0)")
        x, *_ = window.evaluate(f"{view}.held().place")
        window.locator("#drag-x").fill(str(round(x + 15, 3)))
        until(window, "document.querySelector('#drag-state').className === 'good'")
        window.locator("#drag-form button").first.click()
        until(
            window,
            "document.querySelector('#editor')?.textContent.includes('position = [15, 0, 0]')",
        )
        until(window, f"Math.abs({view}?.held()?.place[0] - {x + 15}) < 0.01")
