"""`simulate`: times on the screen, motion in files, all of them or none."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.cli.tables import each
from tests.cli.test_commands import run

Capture = pytest.CaptureFixture[str]
PROJECT = Path(__file__).parents[2]
PNG = b"\x89PNG\r\n\x1a\n"
TEXT = """program cell for irb1200-7-0.7

signal ready digital input

target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]

procedure main
  move joint a speed 500 mm/s blend fine
  for i from 1 to 3
    call forth
  end
  wait for ready = 1
end

procedure forth
  move linear b speed 100 mm/s blend fine
  wait 0.5 s
  move linear a speed 200 mm/s blend fine
end
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    file = tmp_path / "cell.pseudo"
    file.write_text(TEXT, encoding="utf-8")
    return file


def test_times_of_procedures_and_what_is_not_known(capsys: Capture, source: Path) -> None:
    status, out, err = run(capsys, "simulate", source, "--acceleration", 1000)
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == f"{source} on ABB IRB 1200-7/0.7"
    times = {words[0]: words[1] for line in lines[3:5] for words in [line.split()]}
    # 2 s and 1 s of cruise, 0.1 s and 0.2 s of speeding up and slowing down, the wait
    assert times["forth"] == "3.80"
    assert float(times["main"]) > 3 * 3.8
    assert any(
        line.startswith("forth move 1") and line.endswith("2.10  speed") for line in lines
    ), out
    assert "  main: the wait for ready = 1" in lines


def test_the_page_shows_what_the_command_says(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(PROJECT)
    page = (PROJECT / "docs" / "simulating.md").read_text("utf-8")
    command, shown = page.split("$ robot-assistant ", 2)[1].split("...", 1)[0].split("\n", 1)
    status, out, _ = run(capsys, *command.split())
    assert status == 0
    assert len(shown.splitlines()) > 10 and out.startswith(shown)


def test_the_answer_for_programs(capsys: Capture, source: Path) -> None:
    status, out, _ = run(capsys, "simulate", source, "--format", "json", "--acceleration", 1000)
    answer = json.loads(out)
    assert status == 0
    assert (answer["robot"], answer["written"], answer["findings"]) == ("irb1200-7-0.7", [], [])
    assert answer["procedures"][1]["name"] == "forth"
    assert answer["procedures"][1]["most"] == pytest.approx(3.8, abs=1e-4)
    moves = [(m["procedure"], m["number"], m["to"]) for m in answer["moves"]]
    assert moves == [("main", 1, "a"), ("forth", 1, "b"), ("forth", 2, "a")]
    assert answer["unknown"] == [
        {"procedure": "main", "what": "the wait for ready = 1", "times": 1}
    ]


def test_a_folder_takes_all_files(capsys: Capture, source: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    status, out, _ = run(capsys, "simulate", source, "-o", folder, "--period", 0.02)
    assert status == 0
    names = sorted(path.name for path in folder.iterdir())
    assert names == [
        *("cell.motion.csv", "cell.motion.npz", "cell.motion.png", "cell.motion.svg"),
        "cell.moves.csv",
    ]
    assert [line for line in out.splitlines() if line.startswith("wrote ")]
    rows = list(csv.DictReader(io.StringIO((folder / "cell.motion.csv").read_text("utf-8"))))
    with np.load(folder / "cell.motion.npz") as table:
        assert len(rows) == len(table["t"]) > 400
        assert float(rows[300]["j2_deg"]) == pytest.approx(table["joints"][300, 1], abs=1e-3)
        assert float(rows[300]["x_mm"]) == pytest.approx(table["position"][300, 0], abs=1e-3)
        assert table["axes"].tolist() == ["J1", "J2", "J3", "J4", "J5", "J6"]
        assert (np.abs(table["joint_velocity"]) <= table["speeds"] + 1e-6).all()
        assert table["move_seconds"].shape == (3,)
    assert (folder / "cell.motion.png").read_bytes().startswith(PNG)
    ElementTree.fromstring((folder / "cell.motion.svg").read_bytes())
    moves = list(csv.DictReader(io.StringIO((folder / "cell.moves.csv").read_text("utf-8"))))
    assert [(m["procedure"], m["move"], m["bound_by"]) for m in moves][1:] == [
        ("forth", "1", "speed"),
        ("forth", "2", "speed"),
    ]


def test_single_files_by_their_end(capsys: Capture, source: Path, tmp_path: Path) -> None:
    one, two = tmp_path / "a.csv", tmp_path / "b" / "c.svg"
    run(capsys, "simulate", source, "-o", one, "-o", two, "--period", 0.1)
    times = [float(line.split(",")[0]) for line in one.read_text("utf-8").splitlines()[1:]]
    assert times[:3] == [0.0, 0.1, 0.2]
    assert two.read_bytes().startswith(b"<?xml")


WRONG = (
    (("-o", "motion.pdf"), "CL011"),
    (("--period", 0), "RB302"),
    (("--acceleration", -5), "RB302"),
    (("-o", "x.csv", "--period", 1e-9), "RB301"),
    (("-r", "irb0"), "CO002"),
)


def test_what_cannot_be_asked_for(
    capsys: Capture, source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def check(arguments: tuple[object, ...], code: str) -> None:
        status, _, err = run(capsys, "simulate", source, *arguments)
        assert status == 2
        assert err.startswith(code), err
        assert [path.name for path in tmp_path.iterdir()] == ["cell.pseudo"]

    each(WRONG, check)


def test_a_program_for_no_robot_needs_one(capsys: Capture, source: Path) -> None:
    source.write_text(TEXT.replace(" for irb1200-7-0.7", ""), encoding="utf-8")
    status, _, err = run(capsys, "simulate", source)
    assert (status, err[:5]) == (2, "CL010")
    assert run(capsys, "simulate", source, "-r", "irb1200-5-0.9")[0] == 0


def test_what_the_robot_cannot_do_is_not_simulated(
    capsys: Capture, source: Path, tmp_path: Path
) -> None:
    source.write_text(TEXT.replace("[400, 100, 400]", "[1400, 100, 400]"), encoding="utf-8")
    status, out, err = run(capsys, "simulate", source, "-o", tmp_path / "out")
    assert status == 1
    assert err.startswith("RB102 error") and "cannot run it" in out
    assert not (tmp_path / "out").exists()
    answer = json.loads(run(capsys, "simulate", source, "--format", "json")[1])
    assert answer["findings"][0]["code"] == "RB102"


def test_a_target_for_another_arm_gets_its_branch_anew(capsys: Capture, source: Path) -> None:
    stated = TEXT.replace(
        "[400, 100, 400] [0, 0, 1, 0]", "[400, 100, 400] [0, 0, 1, 0] back up flip 0 0 0"
    )
    source.write_text(stated, encoding="utf-8")
    status, _, err = run(capsys, "simulate", source, "-r", "irb120-3-0.58")
    assert (status, err) == (0, "")


def test_without_matplotlib_nothing_is_written(
    capsys: Capture, source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("matplotlib.figure", "matplotlib.backends.backend_agg"):
        monkeypatch.setitem(sys.modules, module, None)
    status, _, err = run(capsys, "simulate", source, "-o", tmp_path / "out")
    assert (status, err[:5]) == (2, "CL008")
    assert not (tmp_path / "out").exists()
    assert run(capsys, "simulate", source, "-o", tmp_path / "out.csv")[0] == 0


def test_the_source_is_never_written_over(capsys: Capture, tmp_path: Path) -> None:
    table = tmp_path / "way.csv"
    text = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n400,0,400,0,0,1,0\n400,50,400,0,0,1,0\n"
    table.write_text(text, encoding="utf-8")
    process = PROJECT / "samples" / "positioning.process.toml"
    asked = ("simulate", table, "-r", "irb1200-7-0.7", "-p", process, "-o")
    status, _, err = run(capsys, *asked, table)
    assert (status, err[:5]) == (2, "CL007"), err
    assert table.read_text("utf-8") == text
    assert run(capsys, *asked, tmp_path / "way.motion.csv")[0] == 0
    assert table.read_text("utf-8") == text
