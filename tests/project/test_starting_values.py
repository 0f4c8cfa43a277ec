"""`init` asks for what a project needs on a terminal, takes it as options, and builds at once."""

from __future__ import annotations

import io
import tomllib
from importlib.resources import files
from pathlib import Path

import ezdxf
import numpy as np
import pytest

import assistant
from assistant.cli import main
from assistant.project import build, project_of
from tests.project.conftest import Home
from tests.project.test_starting_drawings import draw


class Terminal(io.StringIO):
    """A user who types these lines."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def drawing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return draw(tmp_path_factory.mktemp("mail") / "part.dxf")


def run(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> str:
    with pytest.raises(SystemExit) as ended:
        main(["init", *words])
    out, err = capsys.readouterr()
    assert (ended.value.code or 0) == status, out + err
    return out + err


def stated(home: Home) -> tuple[dict, dict]:
    """The project file and the process file."""
    project = tomllib.loads((home.folder / "assistant.toml").read_text("utf-8"))
    process = (home.folder / "drawings" / "part.process.toml").read_text("utf-8")
    return project, tomllib.loads(process)


def typed(monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    monkeypatch.setattr("sys.stdin", Terminal("".join(f"{line}\n" for line in lines)))


def test_enter_takes_what_fits_and_the_project_builds(
    home: Home, drawing: Path, capsys, monkeypatch
) -> None:
    typed(monkeypatch, "", "", "", "")
    said = run(capsys, str(drawing))
    project, process = stated(home)
    assert project["controllers"]["cell1"]["robot"] == "irb1200-7-0.7"
    # It is marked as assumed, as nobody measured it.
    assert "PR307" in said
    assert f"`position` {process['frames']['work']['position']}" in said
    text = (home.folder / "drawings/part.process.toml").read_text("utf-8")
    assert text.count("assumed, measure it!") == 2
    assert build(project_of(), jobs=1).ok


def test_answers_are_taken_and_wrong_ones_asked_again(
    home: Home, drawing: Path, capsys, monkeypatch
) -> None:
    answers = ("mm", "rv-4f", "rv-4frl", "melfa-basic-5", "0,0", "1,2,130", "300,-50,120,90")
    typed(monkeypatch, *answers)
    said = run(capsys, str(drawing))
    assert "CO002" in said
    assert "CT366" in said
    assert "PR307" not in said
    project, process = stated(home)
    assert project["controllers"]["cell1"] == {"address": "virtual:cr", "robot": "rv-4frl"}
    assert project["programs"]["part"]["language"] == "melfa-basic-5"
    assert process["unit"] == "mm"
    assert process["tools"]["tool"]["tip"] == [1, 2, 130]
    frame = {"position": [300, -50, 120], "euler_zyx": [90, 0, 0]}
    assert process["frames"]["work"] == frame
    assert build(project_of(), jobs=1).ok


def test_an_input_that_ends_writes_nothing(home: Home, drawing: Path, capsys, monkeypatch) -> None:
    typed(monkeypatch, "")
    assert "CL055" in run(capsys, str(drawing), status=2)
    assert not (home.folder / "assistant.toml").exists()


@pytest.mark.parametrize(
    "options",
    (
        ("--yes",),
        pytest.param(("--robot", "rv-7frl"), marks=pytest.mark.slow),
        pytest.param(("--place", "400,0,200"), marks=pytest.mark.slow),
        pytest.param(("--tip", "0,0,90"), marks=pytest.mark.slow),
    ),
)
def test_options_ask_nothing_and_the_project_builds(
    home: Home, drawing: Path, capsys, monkeypatch, options
) -> None:
    typed(monkeypatch)
    run(capsys, str(drawing), *options)
    assert build(project_of(), jobs=1).ok


@pytest.mark.parametrize("robot", ["irb1200-7-0.7", "rv-4frl"])
@pytest.mark.parametrize("place", ["400,-50,150", "400,-50,150,90"])
def test_the_last_axis_works_about_its_middle(
    home: Home, drawing: Path, capsys, robot, place
) -> None:
    """The tool may be turned about itself: no move begins or ends with half a turn of it."""
    run(capsys, str(drawing), "--yes", "--robot", robot, "--place", place)
    done = assistant.simulate(home.folder / "drawings" / "part.dxf", robot=robot)
    assert np.abs(done.simulation.samples.joints[:, [3, 5]]).max() < 60.0


def test_an_arm_of_five_axes_works_a_drawing_in_front_of_it(
    home: Home, drawing: Path, capsys
) -> None:
    run(capsys, str(drawing), "--yes", "--robot", "rv-2aj")
    assert stated(home)[1]["tools"]["tool"]["euler_zyx"] == [0, 0, 0]
    done = build(project_of(), jobs=1)
    assert done.ok, done.findings


def test_a_script_without_options_leaves_the_blanks(home: Home, drawing: Path, capsys) -> None:
    said = run(capsys, str(drawing))
    assert "fill in `tip`" in said
    assert stated(home)[1]["tools"]["tool"]["tip"] == []


@pytest.mark.slow
def test_a_robot_that_reaches_the_work_is_chosen(home: Home, tmp_path_factory, capsys) -> None:
    drawing = draw(tmp_path_factory.mktemp("mail") / "part.dxf")
    said = run(capsys, str(drawing), "--yes", "--unit", "ft")
    project, _ = stated(home)
    assert project["controllers"]["cell1"]["robot"] != "irb1200-7-0.7"
    assert "PR308" not in said
    # It fits the usual arm if its numbers are millimetres.
    assert "PR314" in said
    assert "state --unit mm" in said
    assert build(project_of(), jobs=1).ok


def test_work_beyond_all_robots_is_said(home: Home, drawing: Path, capsys) -> None:
    said = run(capsys, str(drawing), "--yes", "--unit", "m")
    assert "PR308" in said
    # Its numbers fit if they are millimetres.
    assert "state --unit mm" in said


def test_work_beyond_the_largest_arm_is_said_to_be(home: Home, tmp_path: Path, capsys) -> None:
    drawing = ezdxf.new(units=4)
    drawing.modelspace().add_lwpolyline([(0, 0), (30_000, 0), (30_000, 20_000)])
    drawing.saveas(tmp_path / "hall.dxf")
    said = run(capsys, str(tmp_path / "hall.dxf"), "--yes")
    assert "no arm of the catalogue reaches farther" in said
    assert "--unit" not in said


def test_a_drawing_without_lines_is_said_to_hold_none(home: Home, tmp_path: Path, capsys) -> None:
    drawing = ezdxf.new(units=4)
    drawing.modelspace().add_text("see the other file")
    drawing.modelspace().add_3dface([(0, 0), (9, 0), (9, 9)])
    drawing.saveas(tmp_path / "empty.dxf")
    said = run(capsys, str(tmp_path / "empty.dxf"), "--yes")
    assert "PR313" in said
    assert "1 TEXT" in said
    assert "1 3DFACE" in said


def test_a_block_that_the_file_lacks_is_left_out_and_the_rest_builds(
    home: Home, drawing: Path, capsys
) -> None:
    document = ezdxf.readfile(drawing)
    document.modelspace().add_blockref("LOGO (2)", (10, 10))
    document.saveas(drawing)
    said = run(capsys, str(drawing), "--yes")
    assert "PR312" in said
    assert "`LOGO (2)`" in said
    assert "DX206" not in said
    assert {"block": "LOGO (2)"} in stated(home)[1]["leave_out"]
    assert build(project_of(), jobs=1).ok
    # An existing process file is not changed, so that the error stays.
    (home.folder / "drawings/part.process.toml").write_text('unit = "mm"\n', "utf-8")
    assert "DX206" in run(capsys, str(drawing))


def test_a_missing_block_whose_name_stands_for_others_stays_an_error(
    home: Home, drawing: Path, capsys
) -> None:
    document = ezdxf.readfile(drawing)
    document.modelspace().add_blockref("*U7", (10, 10))
    document.saveas(drawing)
    said = run(capsys, str(drawing), "--yes")
    assert "DX206" in said
    assert "PR312" not in said
    assert {"block": "*U7"} not in stated(home)[1]["leave_out"]


def test_what_does_not_fit_is_refused(home: Home, drawing: Path, capsys) -> None:
    one = ("--robot", "rv-4frl", "--language", "rapid")
    assert "PR309" in run(capsys, str(drawing), *one, status=2)
    (home.folder.parent / "own.toml").write_text("", "utf-8")
    assert "PR311" in run(capsys, str(drawing), "--robot", "../own.toml", status=2)
    assert "CL052" in run(capsys, "--tip", "0,0,1", status=2)
    run(capsys)
    assert "PR310" in run(capsys, str(drawing), "--robot", "rv-4frl", status=2)


def test_a_drawing_joins_a_project_whose_robot_file_lies_elsewhere(
    home: Home, drawing: Path, capsys
) -> None:
    robot = files("assistant.robots").joinpath("catalogue", "irb1200-7-0.7.toml")
    (home.folder.parent / "own.toml").write_bytes(robot.read_bytes())
    text = '[controllers.cell1]\naddress = "virtual:irc5"\nrobot = "../own.toml"\n'
    home.put("assistant.toml", text)
    run(capsys, str(drawing), "--yes")
    assert stated(home)[1]["frames"]["work"]["position"]
