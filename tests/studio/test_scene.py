"""The scene of the studio: it goes where the text leads, and what is dragged there changes it."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_commands import SAMPLES
from tests.studio.browsing import clean, studio_page, until
from tests.studio.serving import Answer, Page

PROGRAM = """\
MODULE Seam
  PERS tooldata torch:=[TRUE,[[0,0,80],[1,0,0,0]],[0.9,[0,0,50],[1,0,0,0],0,0,0]];
  PERS wobjdata part:=[FALSE,TRUE,"",[[300,-50,200],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST robtarget home:=[[80,50,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! it waits
  CONST robtarget left := [[20,0,50],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget right:=[[120,0,50],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ home,v200,fine,torch\\WObj:=part;
    MoveL left,v100,fine,torch\\WObj:=part;
    MoveL right,v50,z5,torch\\WObj:=part;
    MoveL Offs(right,0,0,80),v50,z5,torch\\WObj:=part;
  ENDPROC
ENDMODULE
"""
CELL = """\
[robots.arm]
robot = "irb1200-7-0.7"
tool = "torch"

[bodies.torch]
cylinder = [10, 76]
position = [0, 0, 40]

[bodies.table]
box = [300, 300, 20]
position = [420, 0, 200]
"""
PROJECT = """\
[programs.seam]
source = "seam.mod"
robot = "irb1200-7-0.7"
cell = "cell.toml"

[programs.plate]
source = "ring.dxf"
robot = "irb1200-7-0.7"

[programs.numbered]
source = "numbered.mod"
robot = "irb1200-7-0.7"
"""
PSEUDO = """\
program places for irb1200-7-0.7

target above [400, 10, 350] [0, 0, 1, 0]
target  pick [400, 10, 250] [0, 0, 1, 0]  # the part

procedure main
  move joint above speed 200 mm/s blend fine
  move linear pick speed 100 mm/s blend fine
end
"""
MELFA = """\
10 ' Robot: RV-4FRL
20 Mov PHome
30 Mvs PNext ' on
40 End
PHome=(+320.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PNext=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
"""
ROUND = """\
10 ' Robot: RV-4FRL
20 Mov P11
30 Mvs P12
40 Mvr P12,P13,P14 ' half a circle
50 Mvs P15
60 Mov P3
70 End
P3=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P11=(+320.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P12=(+320.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P13=(+340.00,+60.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P14=(+360.00,+40.00,+300.00,+180.00,+0.00,+180.00)(7,0)
P15=(+320.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
"""
"""A run of moves that ends where it begins, beside a position like one of it."""
NUMBERED = """\
MODULE numbered
  CONST robtarget seam_1 := [[420,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget seam_2 := [[420,50,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ seam_1,v200,fine,tool0;
    MoveL seam_2,v50,fine,tool0;
  ENDPROC
ENDMODULE
"""


@pytest.fixture
def cell(folder: Path) -> Path:
    """A folder with programs of every kind."""
    (folder / "assistant.toml").write_text(PROJECT)
    (folder / "seam.mod").write_text(PROGRAM)
    (folder / "cell.toml").write_text(CELL)
    (folder / "places.pseudo").write_text(PSEUDO)
    (folder / "next.prg").write_text(MELFA)
    (folder / "round.prg").write_text(ROUND)
    (folder / "numbered.mod").write_text(NUMBERED)
    for name in ("taught.toml", "ring.dxf", "ring.process.toml"):
        shutil.copy(SAMPLES / name, folder)
    return folder


def codes(answer: Answer) -> list[str]:
    return [one["code"] for one in answer.value["findings"]]


def shown(page: Page, path: str) -> dict[str, Any]:
    answer = page.post("scene/show", path=path)
    assert answer.status == 200, answer.value
    value: dict[str, Any] = answer.value
    return value


def handle(scene: dict[str, Any], name: str) -> int:
    return next(i for i, one in enumerate(scene["handles"]) if one["name"] == name)


def moved(page: Page, scene: dict[str, Any], name: str, *place: float) -> Answer:
    at = handle(scene, name)
    return page.post("scene/moved", name=scene["name"], handle=at, position=list(place))


def edited(page: Page, scene: dict[str, Any], name: str, by: tuple[float, ...]) -> tuple[str, str]:
    """The file that is edited, and its text then."""
    at = handle(scene, name)
    place = [a + b for a, b in zip(scene["handles"][at]["position"], by, strict=True)]
    answer = page.post("scene/edit", name=scene["name"], handle=at, position=place)
    assert answer.status == 200, answer.value
    path = answer.value["path"]
    (one,) = answer.value["edits"]
    lines = page_text(page, path).split("\n")
    (first, begin), (last, end) = one["from"], one["to"]
    before, after = lines[first][:begin], lines[last][end:]
    lines[first : last + 1] = [before + one["text"] + after]
    return path, "\n".join(lines)


def page_text(page: Page, path: str) -> str:
    text: str = page.post("text/open_text", path=path).value["text"]
    return text


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


@pytest.mark.parametrize(
    ("path", "name", "line", "by", "said"),
    [
        (
            "seam.mod",
            "left",
            5,
            (1.5, 0.0, -0.25),
            "  CONST robtarget left := [[21.5,0,49.75],[0,0,1,0],[-1,0,-1,0],"
            "[9E9,9E9,9E9,9E9,9E9,9E9]];",
        ),
        (
            "seam.mod",
            "left",
            5,
            (0.0, 100.0, 0.0),  # the arm is turned otherwise there
            "  CONST robtarget left := [[20,100,50],[0,0,1,0],[0,0,0,0],"
            "[9E9,9E9,9E9,9E9,9E9,9E9]];",
        ),
        (
            "places.pseudo",
            "pick",
            4,
            (0.0, 2.0, 0.0),
            "target  pick [400, 12, 250] [0, 0, 1, 0]  # the part",
        ),
        (
            "next.prg",
            "PNext",
            6,
            (0.0, -10.0, 0.5),
            "PNext=(+320.00,+30.00,+300.50,+180.00,+0.00,+180.00)(7,0)",
        ),
        (
            "round.prg",
            "P13",
            11,
            (2.0, 0.0, 0.0),
            "P13=(+342.00,+60.00,+300.00,+180.00,+0.00,+180.00)(7,0)",
        ),
        (
            "round.prg",
            "P15",
            13,
            (0.0, -5.0, 0.0),
            "P15=(+320.00,-5.00,+300.00,+180.00,+0.00,+180.00)(7,0)",
        ),
        (
            "numbered.mod",
            "seam_2",
            3,
            (0.0, 1.0, 0.0),
            "  CONST robtarget seam_2 := [[420,51,300],[0,0,1,0],[0,0,0,0],"
            "[9E9,9E9,9E9,9E9,9E9,9E9]];",
        ),
        ("taught.toml", "corner", 36, (1.0, 0.0, 0.0), "position = [421, 60, 300]"),
    ],
)
def test_a_target_that_is_moved_is_one_edit(
    page: Page, cell: Path, path: str, name: str, line: int, by: tuple[float, ...], said: str
) -> None:
    before = (cell / path).read_text().split("\n")
    edits, text = edited(page, shown(page, path), name, by)
    after = text.split("\n")
    assert edits == path
    assert after[line - 1] == said
    assert after[: line - 1] == before[: line - 1]
    assert after[line:] == before[line:]
    assert (cell / path).read_text().split("\n") == before  # whoever edits saves as well


@pytest.mark.parametrize("path", ["seam.mod", "places.pseudo", "next.prg"])
def test_lines_that_end_as_on_other_systems_stay_so(page: Page, cell: Path, path: str) -> None:
    before = (cell / path).read_text().replace("  # the part", "").replace("\n", "\r\n")
    (cell / path).write_text(before, newline="")
    scene = shown(page, path)
    name = scene["handles"][-1]["name"]
    _, after = edited(page, scene, name, (1.5, 0.0, 0.0))
    pairs = zip(before.split("\n"), after.split("\n"), strict=True)
    changed = [one for one in pairs if one[0] != one[1]]
    assert [(one.count("\r"), other.count("\r")) for one, other in changed] == [(1, 1)]


def test_a_tool_of_five_axes_leans_and_rolls_as_its_text_says(page: Page, cell: Path) -> None:
    project = (cell / "assistant.toml").read_text()
    project += '\n[programs.lean]\nsource = "lean.mb4"\nrobot = "rv-2aj"\n'
    (cell / "assistant.toml").write_text(project)
    lines = ["10 MOV P1", "20 MVS P2", "30 END"]
    lines += ["P1=(250.00,0.00,250.00,20.00,150.00)(6,0)", "P2=(250,40.5,250,20,150)(6,0)"]
    (cell / "lean.mb4").write_text("\n".join(lines) + "\n")
    scene = shown(page, "lean.mb4")
    told = moved(page, scene, "P1", 270.0, 110.0, 230.0).value
    assert told["reached"]
    j1, j2, j3, j5, j6 = np.degrees(told["joints"])
    # B is the sum of what bends, and A what the hand rolls with J1 taken off.
    assert j1 == pytest.approx(math.degrees(math.atan2(110.0, 270.0)))
    assert j2 + j3 + j5 == pytest.approx(150.0)
    assert j6 == pytest.approx(20.0 - j1 * math.cos(math.radians(150.0)))
    _, text = edited(page, scene, "P1", (20.0, 110.0, -20.0))
    assert text.split("\n")[3] == "P1=(270.00,110.00,230.00,20.00,150.00)(6,0)"
    _, text = edited(page, scene, "P2", (-30.0, 0.0, -20.125))
    assert text.split("\n")[4] == "P2=(220,40.5,229.875,20,150)(6,0)"


def test_who_knows_a_target_that_is_moved_stays_as_it_is(page: Page, cell: Path) -> None:
    text = PROGRAM.replace("CONST robtarget left", "LOCAL  CONST robtarget left")
    (cell / "seam.mod").write_text(text)
    _, after = edited(page, shown(page, "seam.mod"), "left", (1.5, 0.0, 0.0))
    assert "  LOCAL  CONST robtarget left := [[21.5,0,50]," in after


def test_a_target_is_not_moved_by_a_frame_that_is_another_one_now(page: Page, cell: Path) -> None:
    assert cell.is_dir()
    scene, text = shown(page, "seam.mod"), page_text(page, "seam.mod")
    asked = {"name": scene["name"], "handle": handle(scene, "left"), "position": [321, -50, 250]}
    changed = text.replace("[300,-50,200]", "[300,-90,200]")
    done = page.post("text/change", path="seam.mod", version=1, text=changed, first=0, last=0)
    assert done.status == 200
    assert codes(page.post("scene/edit", **asked)) == ["ST052"]
    asked |= {"name": shown(page, "seam.mod")["name"]}
    assert page.post("scene/edit", **asked).status == 200


def test_a_drawing_is_placed_by_its_process_file(page: Page, cell: Path) -> None:
    scene = shown(page, "ring.dxf")
    assert shown(page, "ring.process.toml") == scene
    name = scene["handles"][0]["name"]
    x, y, z = scene["handles"][0]["position"]
    told = moved(page, scene, name, x + 20.0, y, z).value
    assert (told["reached"], told["left"]) == (True, 0)
    far = moved(page, scene, name, x + 900.0, y, z).value
    assert far["left"] == far["looked"] > 5
    path, text = edited(page, scene, name, (20.0, 0.0, 0.0))
    assert path == "ring.process.toml"
    assert text.endswith("\n[placement]\nposition = [20, 0, 0]\n")
    (cell / path).write_text(text)
    again = shown(page, "ring.dxf")
    assert again["handles"][0]["position"] == pytest.approx([x + 20.0, y, z])


def test_marks_that_place_a_drawing_are_not_dragged(page: Page, cell: Path) -> None:
    file = cell / "ring.process.toml"
    marks = "[[0, 0], [100, 0], [0, 50]]"
    taught = "[[0, 0, 0], [100, 0, 0], [0, 50, 0]]"
    file.write_text(f"{file.read_text()}\n[placement]\ndrawing = {marks}\ncell = {taught}\n")
    scene = shown(page, "ring.dxf")
    refused = page.post("scene/edit", name=scene["name"], handle=0, position=[1.0, 2.0, 3.0])
    assert codes(refused) == ["ST052"]


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


def test_a_text_that_has_changed_since_is_not_edited_blindly(page: Page, cell: Path) -> None:
    scene = shown(page, "seam.mod")
    file = cell / "seam.mod"
    file.write_text(file.read_text().replace("robtarget left", "robtarget other"))
    at = handle(scene, "left")
    refused = page.post("scene/edit", name=scene["name"], handle=at, position=[330.0, -50.0, 250.0])
    assert codes(refused) == ["ST052"]


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
