"""The samples of each language in the others, and back: what a cell programmer would try first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant import languages
from assistant.base import rotations
from assistant.compiler import Translation, load, translate
from assistant.compiler.checker import Checked, check_files
from assistant.compiler.formatter import format_file
from assistant.program.program import Program

SAMPLES = Path(__file__).parents[2] / "samples"
CELL = SAMPLES / "rapid" / "cell.process.toml"
MELFA_CELL = SAMPLES / "melfa" / "cell.process.toml"
MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")
MOTION = ("palletising", "pick_and_place", "gluing", "drilling")
IRB, MITSUBISHI = "irb1200-7-0.7", "rv-4frl"
NOT_CHECKED = {"RB128"}
"""What is said of moves to places that a parameter or a counter tells."""
POSITION, ANGLE = 0.0051, 0.01
"""Half of the second decimal that MELFA-BASIC prints, and of three angles together."""


def codes(checked: Checked) -> set[str]:
    return {finding.code for finding in checked.findings}


@pytest.mark.parametrize("name", [*MOTION, "pose_exchange"])
def test_a_sample_is_clean_and_laid_out(name: str) -> None:
    file = SAMPLES / "rapid" / f"{name}.mod"
    assert codes(check_files([str(file)], robot=IRB)) <= NOT_CHECKED
    assert not format_file(str(file), None).changed


def test_the_modules_of_a_sample_are_clean() -> None:
    folder = SAMPLES / "rapid" / "station"
    assert codes(check_files([str(folder)], robot=IRB)) <= NOT_CHECKED


@pytest.mark.parametrize("language", MELFA)
def test_the_sample_of_several_modules(language: str) -> None:
    sample = SAMPLES / "rapid" / "station" / "station.pgf"
    there = translate(sample, to=language, robot=MITSUBISHI, process=CELL)
    assert there.ok, there.findings
    assert list(there.files) == ["STATION.prg"]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("language", MELFA)
@pytest.mark.parametrize("name", MOTION)
def test_a_sample_of_rapid_in_melfa_basic_and_back(
    name: str, language: str, tmp_path: Path
) -> None:
    sample = SAMPLES / "rapid" / f"{name}.mod"
    there = translate(sample, to=language, robot=MITSUBISHI, from_robot=IRB, process=CELL)
    assert there.ok, there.findings
    assert there.totals["not"] == 0
    assert {f.code for row in there.rows for f in row.reasons} <= CHANGES
    back = translate(
        kept(there, tmp_path), to="rapid", robot=IRB, language=language, process=MELFA_CELL
    )
    assert back.ok, back.findings
    wanted = load(sample, process=CELL).program
    got = load(kept(back, tmp_path)).program
    same_targets(wanted, got)
    assert got.signals == wanted.signals
    assert {q.name for q in got.procedures} - {"cycle"} == {q.name for q in wanted.procedures}
    for frame in wanted.frames:
        same_poses(wanted.frames[frame].pose, got.frames[frame].pose)
    for tool in wanted.tools:
        same_poses(wanted.tools[tool].tip, got.tools[tool].tip)


CHANGES = {"CO501", "CO508", "MB204", "MB205", "MB206", "MB211", "MB217", "MB223", "MB224"}
CHANGES |= {"MB226", "MB237", "MB263", "MB300"}
"""What is said with a change: joint targets and speeds, zones, loads, messages, parameters,
computed places, analog signals."""


def test_the_server_of_poses_is_reported_statement_by_statement() -> None:
    found = translate(SAMPLES / "rapid" / "pose_exchange.mod", to="melfa-basic-5")
    said = {row.text: row.level for row in found.rows}
    assert said["MoveL pNext,v150,z100,tGripper"] == "supported"
    assert said["MoveJ pStart,v500,fine,tGripper"] == "partial"
    for text in (
        "WaitUntil IsFile(stTarget) AND IsFile(stTurn)\\MaxTime:=240",
        "Rewind ioFile",
        'Write ioFile,""\\Orient:=pNow.rot',
    ):
        assert said[text] == "not", text
    assert said["RemoveFile stFile"] == "partial"  # emptied
    assert not found.files


def test_a_pallet_in_melfa_basic_in_rapid(tmp_path: Path) -> None:
    found = translate(
        SAMPLES / "melfa" / "PALLET.prg",
        to="rapid",
        robot=IRB,
        from_robot=MITSUBISHI,
        process=MELFA_CELL,
    )
    assert found.ok, found.findings
    assert found.totals["not"] == 0
    (data,) = found.files.values()
    for line in ("FOR MRow FROM 0 TO 2 DO", "TEST MCount MOD 5", "WaitDI di_8,1;", "PICK;"):
        assert line in data.decode()
    (tmp_path / "PALLET.mod").write_bytes(data)
    assert codes(check_files([str(tmp_path / "PALLET.mod")])) <= NOT_CHECKED


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("MULTITASK", {'20 XRUN 2,"DATALINK"'}),
        ("DATALINK", {'OPEN "COM2:" AS #2'}),
        ("CONTROLLINK", {"80 INPUT #1,JNTPOS"}),
    ],
)
def test_what_only_a_melfa_controller_does_is_not_said(name: str, said: set[str]) -> None:
    found = translate(SAMPLES / "melfa" / f"{name}.prg", to="rapid", robot=IRB)
    lost = [row.text for row in found.rows if row.level == "not"]
    assert not found.files
    for text in said:
        assert any(text.split(maxsplit=1)[-1] in row for row in lost), lost


def kept(translation: Translation, folder: Path) -> Path:
    """The main file of a translation, in a folder."""
    for name, data in translation.files.items():
        (folder / name).write_bytes(data)
    return folder / next(iter(translation.files))


def same_targets(wanted: Program, got: Program) -> None:
    assert set(got.targets) == set(wanted.targets)
    for name, target in wanted.targets.items():
        same_poses(target.pose, got.targets[name].pose)
        assert got.targets[name].configuration == target.configuration, name
    for name, joints in wanted.joint_targets.items():
        assert np.allclose(joints.joints, got.joint_targets[name].joints, atol=0.05)


def same_poses(one: object, two: object) -> None:
    assert np.abs(np.subtract(one.position, two.position)).max() <= POSITION
    assert rotations.angle_between(one.quaternion, two.quaternion) <= ANGLE


def test_every_language_has_a_sample() -> None:
    suffixes = {path.suffix for path in SAMPLES.rglob("*.*")}
    assert all(set(languages.get(name).suffixes) & suffixes for name in languages.names())
