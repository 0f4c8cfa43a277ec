"""What is dragged in a scene is one edit of the text that says where it is."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from tests.studio.scenes import PROGRAM, codes, edited, handle, moved, page_text, shown
from tests.studio.serving import Page

DRAGS: Final = 24
PROJECT: Final = '[controllers.cell]\naddress = "{address}"\nrobot = "{robot}"\n'
ROBTARGET: Final = re.compile(r"^ *(?:LOCAL )?CONST robtarget (p\d+) *:= *\[\[([^]]*)\](.*)$", re.M)
POSITION: Final = re.compile(r"^(P\d+)=\((([^,]*,){2}[^,]*)(,.*)$", re.M)


def turn(degrees: float) -> np.ndarray:
    """About z."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def half(degrees: float) -> str:
    """The quaternion of the same turn."""
    return f"[{np.cos(np.radians(degrees / 2)):.9f},0,0,{np.sin(np.radians(degrees / 2)):.9f}]"


def numbers(text: str) -> np.ndarray:
    return np.array([float(one) for one in text.split(",")])


def rapid(draw: random.Random) -> tuple[str, np.ndarray, np.ndarray]:
    """A module in a work object, and rotation and origin of that."""
    user, part = draw.uniform(-90, 90), draw.uniform(-90, 90)
    origin, rotation = np.array([250.0, 40.0, 120.0]), turn(user) @ turn(part)
    lines = ["MODULE dragged", "  ! CONST robtarget p0:=[[1,2,3],[1,0,0,0]];"]
    frame = f"[[250,40,120],{half(user)}],[[0,0,0],{half(part)}]"
    lines.append(f'  PERS wobjdata part:=[FALSE,TRUE,"",{frame}];')
    for row in range(6):
        x, y, z = (np.array([430.0, 30.0 * row + 20.0, 380.0]) - origin) @ rotation
        flange = -np.radians(user + part) / 2.0  # the tool points down, its x to the front
        down = f"[0,{-np.sin(flange):.9f},{np.cos(flange):.9f},0]"
        scope, said = draw.choice(["", "LOCAL "]), draw.choice([":=", " := "])
        rest = f"{down},[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! place {row} [1,2,3]"
        lines.append(
            f"  {scope}CONST robtarget p{row}{said}[[{x:.{row % 4}f},{y:.3f},{z:.1f}],{rest}"
        )
    lines.append("  PROC main()")
    lines += [f"    MoveJ p{row},v100,fine,tool0\\WObj:=part;" for row in range(6)]
    lines += ["  ENDPROC", "ENDMODULE", ""]
    return draw.choice(["\n", "\r\n"]).join(lines), rotation, origin


def melfa(draw: random.Random) -> tuple[str, np.ndarray, np.ndarray]:
    """A program whose `Base` is another one."""
    turned = float(draw.randint(-45, 45))
    rotation = turn(turned).T
    lines = [f"Base (10,20,0,0,0,{turned})", "Mov P1"]
    origin = -rotation @ np.array([10.0, 20.0, 0.0])
    lines += [f"Mvs P{row}" for row in range(2, 7)] + ["End"]
    for row in range(1, 7):
        x, y, z = (np.array([420.0, 25.0 * row, 360.0]) - origin) @ rotation
        sign = draw.choice(["+", ""])
        lines.append(f"P{row}=({x:{sign}.2f},{y:.2f},{z:.2f},180,0,180)(7,0)")
    return "\n".join(lines) + "\n", rotation, origin


@pytest.mark.parametrize(
    ("name", "robot", "controller", "written", "read", "most"),
    [
        ("dragged.mod", "irb1200-7-0.7", "virtual:irc5", rapid, ROBTARGET, 0.006),
        ("dragged.prg", "rv-4frl", "virtual:cr", melfa, POSITION, 0.008),
    ],
    ids=["rapid", "melfa-basic"],
)
def test_a_target_comes_to_where_it_is_dragged(
    page: Page,
    folder: Path,
    name: str,
    robot: str,
    controller: str,
    written: Callable[[random.Random], tuple[str, np.ndarray, np.ndarray]],
    read: re.Pattern[str],
    most: float,
) -> None:
    draw = random.Random(23)
    text, rotation, origin = written(draw)
    (folder / "assistant.toml").write_text(PROJECT.format(address=controller, robot=robot))
    (folder / name).write_bytes(text.encode())
    scene = page.post("scene/show", path=name).value
    assert len(scene["handles"]) == 6, scene["findings"]
    lines = text.split("\n")
    before = {one[1]: one for one in read.finditer(text)}
    for at in range(DRAGS):
        number = at % len(scene["handles"])
        place = [draw.uniform(380, 470), draw.uniform(10, 160), draw.uniform(330, 430)]
        asked = {"name": scene["name"], "handle": number, "position": place}
        assert page.post("scene/moved", **asked).value["reached"]
        (edit,) = page.post("scene/edit", **asked).value["edits"]
        (line, begin), (last, end) = edit["from"], edit["to"]
        assert line == last
        changed = lines[line][:begin] + edit["text"] + lines[line][end:]
        (found,) = read.finditer(changed)
        same = before[scene["handles"][number]["name"]]
        assert (found[1], found.groups()[-1]) == (same[1], same.groups()[-1])
        assert rotation @ numbers(found[2]) + origin == pytest.approx(place, abs=most)


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


def test_a_text_that_has_changed_since_is_not_edited_blindly(page: Page, cell: Path) -> None:
    scene = shown(page, "seam.mod")
    file = cell / "seam.mod"
    file.write_text(file.read_text().replace("robtarget left", "robtarget other"))
    at = handle(scene, "left")
    refused = page.post("scene/edit", name=scene["name"], handle=at, position=[330.0, -50.0, 250.0])
    assert codes(refused) == ["ST052"]
