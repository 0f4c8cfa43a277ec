"""Recordings of joints: which rows count, and what is no recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.cell.exploration.recordings import Recorded, read_recording

ROBOT = robots.get("rv-2aj")
HEADER = "_seconds,_mode,_j1_deg,_j2_deg,_j3_deg,_j5_deg,_j6_deg,_j7_deg,_di_touch\n"


def log(tmp_path: Path, rows: list[str], header: str = HEADER) -> Path:
    file = tmp_path / "log.csv"
    file.write_text(header + "\n".join(rows) + "\n", encoding="utf-8")
    return file


def line(seconds: float, touch: object = 0, first: object = None) -> str:
    """A row at J1 of as many degrees as there are seconds."""
    return f"{seconds:.3f},auto,{seconds if first is None else first},0,90,10,20,,{touch}"


def firsts(found: Recorded) -> list[list[float]]:
    """J1 of the rows of each run."""
    return [run[:, 0].tolist() for run in found.runs]


def test_all_rows_count_where_no_contact_is_named(tmp_path: Path) -> None:
    found = read_recording(log(tmp_path, [line(k / 4.0, int(k == 3)) for k in range(6)]), ROBOT)
    assert firsts(found) == [[0.0, 0.25, 0.5, 0.75, 1.0, 1.25]]
    assert found.contacts == 0 and found.findings == ()
    assert found.runs[0][2].tolist() == [0.5, 0.0, 90.0, 10.0, 20.0]


def test_half_a_second_before_a_contact_and_before_the_end_counts_for_nothing(
    tmp_path: Path,
) -> None:
    rows = [
        line(k / 4.0, int(6 <= k < 8)) for k in range(15)
    ]  # in contact from 1.5 s to before 2 s
    found = read_recording(log(tmp_path, rows), ROBOT, "di_touch")
    assert firsts(found) == [[0.0, 0.25, 0.5, 0.75, 1.0], [2.0, 2.25, 2.5, 2.75, 3.0]]
    assert found.contacts == 1


def test_what_is_not_told_of_a_contact_is_one(tmp_path: Path) -> None:
    rows = [line(0.0), line(1.0, touch=""), line(2.0), line(3.0)]
    found = read_recording(log(tmp_path, rows), ROBOT, "di_touch")
    assert firsts(found) == [[0.0], [2.0]] and found.contacts == 1


def test_rows_without_joints_part_the_runs_and_are_told_of(tmp_path: Path) -> None:
    rows = [line(0.0), line(1.0, first=""), line(2.0), line(3.0)]
    found = read_recording(log(tmp_path, rows), ROBOT)
    assert firsts(found) == [[0.0], [2.0, 3.0]]
    (finding,) = found.findings
    assert (finding.code, finding.line) == ("CK482", 3)


@pytest.mark.parametrize(
    ("rows", "header", "contact", "code"),
    [
        ([line(0.0)], HEADER.replace("_j5_deg", "_other"), None, "CK480"),
        ([line(0.0)], HEADER, "di_other", "CK481"),
        ([line(0.0)], HEADER.replace("_seconds", "_when"), "di_touch", "CK481"),
        ([line(0.0, first=250)], HEADER, None, "CK483"),
        ([line(1.0), line(0.5)], HEADER, "di_touch", "CK484"),
        ([line(0.0, first="east")], HEADER, None, "TB125"),
    ],
)
def test_what_is_no_recording_of_the_arm_is_told(
    tmp_path: Path, rows: list[str], header: str, contact: str | None, code: str
) -> None:
    with pytest.raises(Refused) as refused:
        read_recording(log(tmp_path, rows, header), ROBOT, contact)
    assert [finding.code for finding in refused.value.findings] == [code]
    assert refused.value.findings[0].path == str(tmp_path / "log.csv")


def test_a_motion_over_time_is_a_recording(tmp_path: Path) -> None:
    axes = ["j1_deg", "j2_deg", "j3_deg", "j5_deg", "j6_deg"]
    header = ",".join(["t_s", *axes, *(f"{axis}_s" for axis in axes)]) + "\n"
    rows = ["0,1,2,3,4,5,9,9,9,9,9", "0.01,2,2,3,4,5,9,9,9,9,9"]
    found = read_recording(log(tmp_path, rows, header), ROBOT)
    assert np.concatenate(found.runs).tolist() == [[1, 2, 3, 4, 5], [2, 2, 3, 4, 5]]


def test_joints_are_read_from_the_log_of_servoing(tmp_path: Path) -> None:
    names = ("seconds", *(f"{what}.J{n}" for what in ("joints", "told") for n in (1, 2, 3, 5, 6)))
    rows = [",".join(["0.1", "1", "2", "90", "4", "5", *"99999"])] * 2
    found = read_recording(log(tmp_path, rows, ",".join(names) + "\n"), ROBOT)
    assert found.runs[0].tolist() == [[1.0, 2.0, 90.0, 4.0, 5.0]] * 2
