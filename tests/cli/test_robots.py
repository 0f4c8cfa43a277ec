"""`robots` and `robots show`: the catalogue, one robot of it, its drawing."""

from __future__ import annotations

import json
import sys
from importlib.resources import files
from pathlib import Path

import pytest

from assistant import robots
from assistant.robots.robot_file import FIELDS, LENGTH_NAMES
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.robots.test_urdf import OFFSET, WRISTED

Capture = pytest.CaptureFixture[str]
PROJECT = Path(__file__).parents[2]
POSITIONING = PROJECT / "samples" / "positioning.csv"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """The file of a robot of the user's own."""
    text = files("assistant.robots").joinpath("catalogue", "irb120-3-0.58.toml").read_text("utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(text.replace('"irb120-3-0.58"', '"mine"'), encoding="utf-8")
    return file


def test_every_robot_has_a_line(capsys: Capture) -> None:
    status, out, err = run(capsys, "robots")
    assert (status, err) == (0, "")
    heading, *lines = out.splitlines()
    assert heading.split() == [
        *("name", "title", "axes", "payload", "reach", "controller", "languages")
    ]
    assert [line.split()[0] for line in lines[:-1]] == list(robots.names())
    line = next(line for line in lines if line.startswith("rv-4frl "))
    assert line.split()[-7:] == [
        *("4", "kg", "648.7", "mm", "CR800", "melfa-basic-6,", "melfa-basic-5")
    ]


def test_the_page_about_robots_shows_the_list_as_it_is(capsys: Capture) -> None:
    page = (PROJECT / "docs" / "robots.md").read_text("utf-8")
    assert f"$ robot-assistant robots\n{run(capsys, 'robots')[1]}```" in page


def test_the_page_about_robots_names_every_field_of_a_file() -> None:
    page = (PROJECT / "docs" / "robots.md").read_text("utf-8")
    for field in (*FIELDS, *(name for names in LENGTH_NAMES.values() for name in names)):
        assert f"`{field}`" in page


def test_a_figure_without_a_source_is_marked(capsys: Capture) -> None:
    out = run(capsys, "robots")[1]
    lines = {line.split()[0]: line for line in out.splitlines()}
    assert "1.5 kg?" in lines["rv-1a"]
    assert "8 kg " in lines["rv-8crl"]
    assert lines["?"] == "? no source at hand confirms it"


def test_the_list_for_programs(capsys: Capture) -> None:
    rows = json.loads(run(capsys, "robots", "--format", "json")[1])
    assert [row["name"] for row in rows] == list(robots.names())
    assert rows[robots.names().index("rv-2aj")] == {
        "name": "rv-2aj",
        "title": "Mitsubishi RV-2AJ",
        "maker": "Mitsubishi",
        "axes": 5,
        "payload_kg": 2.0,
        "reach_mm": 410.0,
        "controller": "CR1",
        "languages": ["melfa-basic-4"],
        "unconfirmed": [],
    }


def test_all_of_a_robot_is_shown(capsys: Capture) -> None:
    def check(name: str) -> None:
        robot = robots.get(name)
        said = json.loads(run(capsys, "robots", "show", name, "--format", "json")[1])
        assert said["name"] == name
        assert said["source"] == robot.source
        assert said["unconfirmed"] == list(robot.unconfirmed)
        assert (said["tcp_speed_mm_s"], said["repeatability_mm"]) == (
            *(robot.tcp_speed, robot.repeatability),
        )
        axes = said["axes"]
        assert [axis["name"] for axis in axes] == list(robot.axes)
        assert [axis["limits"] for axis in axes] == robot.limits.tolist()
        assert [axis["speed"] for axis in axes] == robot.speeds.tolist()
        assert said["home_flange"]["position"] == pytest.approx(robot.fk(robot.home)[0][0])
        assert said["lengths_mm"]

        text = run(capsys, "robots", "show", name)[1]
        assert f"source: {robot.source}" in text
        assert all(field in text for field in robot.unconfirmed)
        rows = [line for line in text.splitlines() if line.endswith(("degrees", " mm"))]
        assert [row.split()[0] for row in rows][-len(robot.axes) :] == list(robot.axes)

    each(robots.names(), check)


def test_the_format_may_stand_before_the_command(capsys: Capture) -> None:
    behind = run(capsys, "robots", "show", "rv-2aj", "--format", "json")
    assert run(capsys, "robots", "--format", "json", "show", "rv-2aj") == behind
    assert run(capsys, "robots", "--format", "json", "show", "rv-2aj", "--format", "text")[
        1
    ].startswith("name ")


def test_what_nobody_tells_is_not_known(capsys: Capture) -> None:
    text = run(capsys, "robots", "show", "IRB140-6-0.81")[1]
    assert "TCP speed       not known\n" in text
    assert "repeatability   not known\n" in text
    text = run(capsys, "robots", "show", "rv-1a")[1]
    assert "TCP speed       2200 mm/s?\n" in text
    assert (
        "\nJ3              60?         155?         135?            -           90  degrees" in text
    )


def test_an_own_robot_by_its_file(own: Path, capsys: Capture) -> None:
    assert json.loads(run(capsys, "robots", "show", own, "--format", "json")[1])["name"] == "mine"
    assert run(capsys, "check", POSITIONING, "--robot", own)[0] == 0
    shorter = own.read_text().replace("a2 = 270", "a2 = 100").replace("d4 = 302", "d4 = 90")
    own.write_text(shorter)
    status, _, err = run(capsys, "check", POSITIONING, "--robot", own)
    assert status == 1
    assert "RB102" in err


def test_compiling_for_an_own_robot(own: Path, tmp_path: Path, capsys: Capture) -> None:
    targets = []
    for robot in (own, "irb120-3-0.58"):
        folder = tmp_path / Path(robot).stem
        status, _, err = run(
            capsys, "compile", POSITIONING, "-l", "rapid", "-r", robot, "-o", folder
        )
        assert status == 0, err
        (module,) = folder.glob("*.mod")
        lines = module.read_text().splitlines()
        targets.append([line for line in lines if "robtarget" in line or line.startswith("    [[")])
    assert targets[0]
    assert targets[0] == targets[1]


URDFS = (
    (WRISTED, {"d1": 399.1, "a1": 0.0, "a2": 350.0, "a3": -42.0, "d4": 351.0, "d6": 82.0}),
    (OFFSET, {}),
)


def test_an_own_robot_out_of_a_urdf(tmp_path: Path, capsys: Capture) -> None:
    file, picture = tmp_path / "own.urdf", tmp_path / "own.png"
    for text, lengths in URDFS:
        file.write_text(text, encoding="utf-8")
        draw = ("--draw", picture) if text == OFFSET else ()
        status, out, err = run(capsys, "robots", "show", file, *draw, "--format", "json")
        assert status == 0
        said = json.loads(out)
        assert (said["name"], said["payload_kg"]) == ("own", None)
        assert said["lengths_mm"] == pytest.approx(lengths)
        # What the file leaves open is told.
        assert err.startswith("RB")
        assert "payload         not known\n" in run(capsys, "robots", "show", file)[1]
    assert picture.read_bytes().startswith(PNG)


def test_no_such_robot(capsys: Capture) -> None:
    for name, code in (("irb9999", "CO002"), ("none.toml", "IN001"), ("none.urdf", "IN001")):
        status, out, err = run(capsys, "robots", "show", name)
        assert (status, out, err.startswith(code)) == (2, "", True), name


def test_a_robot_file_with_a_fault(own: Path, capsys: Capture) -> None:
    own.write_text(own.read_text().replace("payload_kg = 3", "payload_kg = -3"))
    status, out, err = run(capsys, "robots", "show", own)
    assert (status, out) == (1, "")
    assert err.startswith("RB002")
    assert "payload_kg" in err


def test_a_drawing_is_written(tmp_path: Path, capsys: Capture) -> None:
    png, svg = tmp_path / "new" / "arm.png", tmp_path / "svg" / "arm.svg"
    status, out, _ = run(capsys, "robots", "show", "rv-4frl", "--draw", png)
    assert status == 0
    assert out.endswith(f"\ndrawing: {png}\n")
    said = run(capsys, "robots", "show", "rv-4frl", "--draw", svg, "--format", "json")[1]
    assert json.loads(said)["drawing"] == str(svg)
    for file, begins in ((png, PNG), (svg, b"<?xml")):
        assert file.read_bytes().startswith(begins)
        assert list(file.parent.iterdir()) == [file]


def test_without_being_asked_nothing_is_drawn(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(capsys, "robots", "show", "rv-4frl")[0] == 0
    assert not list(tmp_path.iterdir())


def test_a_picture_of_another_kind_is_refused(tmp_path: Path, capsys: Capture) -> None:
    status, out, err = run(capsys, "robots", "show", "rv-4frl", "--draw", tmp_path / "arm.gif")
    assert (status, out) == (2, "")
    assert err.startswith("CL009")
    assert not list(tmp_path.iterdir())


def test_a_picture_that_cannot_be_written(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "arm.png").mkdir()
    status, out, err = run(capsys, "robots", "show", "rv-4frl", "--draw", tmp_path / "arm.png")
    assert (status, out) == (2, "")
    assert err.startswith("CO201")


def test_without_matplotlib_the_extra_is_named(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    status, out, err = run(capsys, "robots", "show", "rv-4frl", "--draw", tmp_path / "arm.png")
    assert (status, out) == (2, "")
    assert err.startswith("CL008")
    assert "[plot]" in err
