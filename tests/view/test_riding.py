"""Bodies that the arm takes and lets go, as a page moves them; zones, lines of a drawing, texts."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

from assistant import robots
from tests.cell.test_holding import CELL, PICK
from tests.cli.test_commands import run
from tests.view.cases import data_of, numbers

Capture = pytest.CaptureFixture[str]
PROJECT = Path(__file__).parent.parent.parent


def shown(folder: Path, capsys: Capture, program: str, cell: str = "") -> dict[str, Any]:
    files = folder / "one.pseudo", folder / "cell.toml", folder / "one.html"
    files[0].write_text(program, encoding="utf-8")
    files[1].write_text(cell, encoding="utf-8")
    words = ("--cell", files[1]) if cell else ("-r", "irb1200-7-0.7")
    run(capsys, "view", files[0], *words, "--html", files[2])
    return data_of(files[2].read_text(encoding="utf-8"))


def body(data: dict[str, Any], name: str) -> dict[str, Any]:
    (found,) = (one for one in data["bodies"] if one["name"] == name)
    return dict(found)


def test_a_body_rides_on_the_flange_and_stays_where_it_is_let_go(
    tmp_path: Path, capsys: Capture
) -> None:
    pytest.importorskip("coal")
    on_it = '[bodies.label]\nbox = [5, 5, 5]\nposition = [0, 0, 60]\nparent = "part"\n'
    data = shown(tmp_path, capsys, PICK, CELL + on_it)
    first, taken, left = body(data, "part")["rides"]
    assert (first["time"], first["carrier"]) == (0.0, 0)
    assert first["pose"][:3] == [400.0, -150.0, 288.0]
    # The flange is at 400 mm and looks down; the part's middle is 112 mm before it.
    assert taken["carrier"] == 1 + len(robots.get("irb1200-7-0.7").axes) + 1
    assert taken["pose"][2] == pytest.approx(112.0, abs=1e-3)
    assert left["carrier"] == 0
    assert left["pose"][:3] == pytest.approx([400.0, 150.0, 288.0], abs=1e-3)
    # When it is taken, the flange stands where `at` is, and where `down` is when it is let go.
    motion = data["motion"]
    times, places = numbers(motion["times"]), numbers(motion["places"]).reshape(-1, 3)
    for ride, place in ((taken, (400.0, -150.0, 400.0)), (left, (400.0, 150.0, 400.0))):
        at = [np.interp(ride["time"], times, column) for column in places.T]
        assert at == pytest.approx(place, abs=1.0)  # between samples
    riding = body(data, "label")["rides"]
    assert [one["time"] for one in riding] == [0.0, taken["time"], left["time"]]
    assert riding[2]["pose"][:3] == pytest.approx([400.0, 150.0, 348.0], abs=1e-3)


def test_a_body_is_nowhere_once_nobody_knows_where_it_is(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("coal")
    if_asked = "  if ready = 1\n    set grip = 1\n  end\n"
    program = PICK.replace("  set grip = 1\n", if_asked).replace(
        "signal grip", "signal ready digital input 1\nsignal grip"
    )
    rides = body(shown(tmp_path, capsys, program, CELL), "part")["rides"]
    assert [one["carrier"] for one in rides] == [0, None]


def zones_of(data: dict[str, Any]) -> list[list[float]]:
    return [list(one) for one in numbers(data["zones"]).reshape(-1, 4)]


def test_zones_reach_no_farther_than_the_middle_of_a_move(tmp_path: Path, capsys: Capture) -> None:
    rows = [("a", 0.0, "20 mm"), ("b", 30.0, "20 mm"), ("c", 230.0, "20 mm"), ("d", 330.0, "fine")]
    names = [f"target {name} [400, {y - 150:g}, 400] [0, 0, 1, 0]" for name, y, _ in rows]
    moves = [f"  move linear {name} speed 100 mm/s blend {blend}" for name, _, blend in rows]
    text = ["program zones", *names, "procedure main", "  move joint a speed 9 mm/s blend fine"]
    data = shown(tmp_path, capsys, "\n".join([*text, *moves[1:], "end"]) + "\n")
    found = zones_of(data)
    assert found == pytest.approx(
        np.array([[400.0, -120.0, 400.0, 15.0], [400.0, 80.0, 400.0, 20.0]])
    )


def test_the_room_to_the_limits_is_that_of_the_nearest_axis(
    tmp_path: Path, capsys: Capture
) -> None:
    program = (
        "program limits\njoints there [85, 0, 0, 0, 30, 0]\nprocedure main\n"
        "  move absolute there speed 100 mm/s blend fine\nend\n"
    )
    motion = shown(tmp_path, capsys, program)["motion"]
    robot = robots.get("irb1200-7-0.7")
    low, high = robot.limits[0]
    assert low == -high
    nearest = np.frombuffer(base64.b64decode(motion["nearest"]), "<u4")
    room = numbers(motion["room"])
    last = np.array([85.0, 0.0, 0.0, 0.0, 30.0, 0.0])
    left = np.minimum(last - robot.limits[:, 0], robot.limits[:, 1] - last)
    share = 2.0 * left / np.ptp(robot.limits, axis=1)
    assert room[-1] == pytest.approx(share.min(), abs=1e-3)
    assert nearest[-1] == share.argmin()
    assert motion["names"] == list(robot.axes)


def test_lines_of_a_drawing_lie_under_the_path(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "plate.html"
    run(capsys, "view", PROJECT / "samples" / "plate.dxf", "-r", "rv-2aj", "--html", out)
    data = data_of(out.read_text(encoding="utf-8"))
    lines = [(one["layer"], numbers(one["points"]).reshape(-1, 3)) for one in data["drawn"]]
    assert {layer for layer, _ in lines} == {"GLUE", "CUT"}
    places = numbers(data["motion"]["places"]).reshape(-1, 3)
    for _, points in lines:
        apart = np.linalg.norm(points[:, None] - places[None], axis=2).min(axis=1)
        assert apart.max() < 3.0  # between samples of the motion, and across corners
    assert data["texts"] == []


def test_lines_that_nothing_follows_are_pale(tmp_path: Path, capsys: Capture) -> None:
    document = ezdxf.new(units=4)
    space = document.modelspace()
    for layer, x, y in (("CUT", 300, 0), ("CUT", 330, 0), ("HELP", 300, 30), ("CENTER", 330, 30)):
        space.add_circle((x, y), 8, dxfattribs={"layer": layer})
    document.saveas(tmp_path / "part.dxf")
    (tmp_path / "part.process.toml").write_text(
        'leave_out = ["HELP", {layer = "CUT", at = [338, 0]}]\n'
        "[tools.t]\ntip = [0, 0, 100]\n[frames.f]\nposition = [0, 0, 200]\n"
        '[motion]\ntool = "t"\nframe = "f"\nspeed = 50\n[layers.CUT]\nspeed = 40\n',
        "utf-8",
    )
    out = tmp_path / "part.html"
    run(capsys, "view", tmp_path / "part.dxf", "-r", "irb1200-7-0.7", "--html", out)
    drawn = data_of(out.read_text(encoding="utf-8"))["drawn"]
    first = [round(numbers(one["points"]).reshape(-1, 3)[0, 0]) for one in drawn]
    assert [
        (one["layer"], x, one.get("left", False)) for one, x in zip(drawn, first, strict=True)
    ] == [
        *(("CUT", 308, False), ("CUT", 338, True)),
        *(("HELP", 308, True), ("CENTER", 338, True)),
    ]


def test_each_move_of_a_run_has_its_line(tmp_path: Path, capsys: Capture) -> None:
    target = "[[{0},0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    run_of = [f"    MoveL {target.format(400 + i)},v100,fine,tool0;" for i in range(40)]
    lines = ["MODULE m", "  ! <!-- </script> \u202e", "  PROC main()", *run_of, "  ENDPROC"]
    file, out = tmp_path / "m.mod", tmp_path / "m.html"
    file.write_text("\n".join([*lines, "ENDMODULE"]) + "\n", encoding="utf-8")
    run(capsys, "view", file, "-r", "irb1200-7-0.7", "--html", out)
    data = data_of(out.read_text(encoding="utf-8"))
    (text,) = data["texts"]
    assert text["first"] == 1
    assert text["lines"][:4] == [
        "MODULE m",
        "  ! <!-- </script> \ufffd",
        "  PROC main()",
        run_of[0],
    ]
    played = data["played"]
    found = np.frombuffer(base64.b64decode(played["lines"]), "<u4").tolist()
    assert found == list(range(4, 44))
    times = numbers(played["times"])
    assert (np.diff(times) > 0.0).all()
    assert math.isclose(times[0], 0.0)
    assert [one["text"] for one in data["moves"]] == [one.strip(" ;") for one in run_of]
    assert [one["line"] for one in data["moves"]] == list(range(4, 44))


def test_of_a_program_of_weeks_its_beginning_is_played(tmp_path: Path, capsys: Capture) -> None:
    program = (
        "program long\ntarget a [400, -100, 400] [0, 0, 1, 0]\n"
        "target b [400, 100, 400] [0, 0, 1, 0]\nprocedure main\n"
        "  move joint a speed 200 mm/s blend fine\n  for i from 1 to 1000000\n"
        "    move linear b speed 200 mm/s blend fine\n    wait 1 s\n"
        "    move linear a speed 200 mm/s blend fine\n  end\nend\n"
    )
    data = shown(tmp_path, capsys, program)
    times = numbers(data["motion"]["times"])
    assert data["motion"]["whole"] > 3e6
    assert np.diff(times).max() < 0.101
    assert 1000.0 < times[-1] < 3000.0
    begins = numbers(data["played"]["times"])
    assert times[-1] - 5.0 < begins[-1] <= times[-1]
