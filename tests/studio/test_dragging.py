"""Targets that are dragged, read back by regular expressions and turned by matrices alone."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
import pytest

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
