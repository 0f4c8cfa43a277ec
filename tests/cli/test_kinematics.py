"""`kinematics`: the source of an arm in a folder."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.test_commands import run
from tests.robots.test_urdf import OFFSET, WRISTED

Capture = pytest.CaptureFixture[str]


def test_the_source_of_an_arm_is_written(capsys: Capture, tmp_path: Path) -> None:
    folder = tmp_path / "made"
    words = ("kinematics", "rv-4frl", "--language", "python", "-o", str(folder))
    status, out, err = run(capsys, *words)
    names = ["rv_4frl.py", "rv_4frl_check.py", "rv_4frl_vectors.csv"]
    assert (status, err) == (0, "")
    assert out.splitlines() == [f"wrote {folder / name}" for name in names]
    done = subprocess.run([sys.executable, str(folder / names[1])], capture_output=True)
    assert done.returncode == 0


def test_c_is_what_is_written_if_nothing_is_said(capsys: Capture, tmp_path: Path) -> None:
    status, out, _ = run(capsys, "kinematics", "rv-2aj", "-o", str(tmp_path), "--format", "json")
    assert status == 0
    answer = json.loads(out)
    assert answer["robot"] == "rv-2aj"
    assert [Path(name).suffix for name in answer["written"]] == [".h", ".c", ".c", ".csv"]


def test_an_arm_without_a_closed_form_is_refused(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "own.urdf"
    file.write_text(OFFSET, encoding="utf-8")
    status, _, err = run(capsys, "kinematics", str(file), "-o", str(tmp_path / "made"))
    assert status == 1 and "BL301" in err
    assert not (tmp_path / "made").exists()


def test_a_robot_that_is_not_there(capsys: Capture, tmp_path: Path) -> None:
    status, _, err = run(capsys, "kinematics", "rv-3x", "-o", str(tmp_path / "made"))
    assert status == 2 and "CO002" in err


def test_an_arm_that_is_never_away_from_singularities_is_refused(
    capsys: Capture, tmp_path: Path
) -> None:
    """An upper arm of 0.4 mm: no joints can be drawn that test its source."""
    file = tmp_path / "own.urdf"
    file.write_text(WRISTED.replace("0 0 0.35", "0 0 0.0004"), encoding="utf-8")
    status, _, err = run(capsys, "kinematics", str(file), "-o", str(tmp_path / "made"))
    assert status == 1 and "BL302" in err
    assert not (tmp_path / "made").exists()
