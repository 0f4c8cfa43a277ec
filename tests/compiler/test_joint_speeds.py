"""Joint moves between percents and mm/s: by distances and axis speeds, never the faster ones."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.compiler import Translation, load, translate
from assistant.program.geometry import JointTarget
from assistant.program.rewriting import records
from assistant.robots.retargeting import joints_on_other_arm
from assistant.robots.timing import simulate

ABB, MITSUBISHI = robots.get("irb1200-7-0.7"), robots.get("rv-4frl")
PLACES = np.array(
    [
        [0.0, -20.0, 100.0, 0.0, 90.0, 10.0],
        [40.0, -5.0, 95.0, 10.0, 80.0, 0.0],
        [-30.0, 10.0, 90.0, 0.0, 70.0, 60.0],
        [-30.0, 10.0, 90.0, 0.0, 70.0, -60.0],
        [10.0, -25.0, 110.0, 5.0, 85.0, 20.0],
    ]
)
"""Joints of the RV-4FRL; the last axis alone turns between two of them."""


def written(folder: Path, head: str, tail: str = "") -> Path:
    """Moves round the places, the first of them to start from, then some other lines."""
    lines = ["Tool P_NTool", "Base P_NBase", "JOvrd 100", "Mov J1", head]
    lines += [f"Mov J{k}" for k in (2, 3, 4, 5, 1)] + [tail] * bool(tail) + ["End"]
    data = [f"J{k}=({','.join(f'{v:+.2f}' for v in row)})" for k, row in enumerate(PLACES, 1)]
    (folder / "WAY.mb6").write_text("\n".join([*lines, *data, ""]), encoding="ascii")
    return folder / "WAY.mb6"


def rapid(source: Path, **options: object) -> Translation:
    given = {"robot": ABB, "from_robot": MITSUBISHI, "language": "melfa-basic-6", **options}
    return translate(source, to="rapid", **given)


def kept(found: Translation, folder: Path) -> Path:
    assert found.ok, found.findings
    ((name, data),) = found.files.items()
    (folder / name).write_bytes(data)
    return folder / name


def speeds(file: Path) -> list[tuple[float, float]]:
    """mm/s and degrees/s of each move to joints, by the text alone."""
    text = file.read_text("ascii")
    declared = {
        name: (float(tcp), float(turn))
        for name, tcp, turn in re.findall(r"speeddata (\w+):=\[([\d.]+),([\d.]+),", text)
    }
    names = re.findall(r"MoveAbsJ \w+,(\w+),", text)
    usual = {"vmax": (np.inf, 500.0)}
    return [declared.get(n) or usual.get(n) or (float(n[1:]), 500.0) for n in names]


def least(joints: np.ndarray, arm: robots.Robot, stated: list[tuple[float, float]]) -> np.ndarray:
    """Seconds of the moves between joints, by distance, turn and axes alone."""
    p, q = arm.fk(joints)
    far = np.linalg.norm(np.diff(p, axis=0), axis=1)
    cosine = np.abs(np.einsum("ij,ij->i", q[1:], q[:-1])).clip(0.0, 1.0)
    turn = 2.0 * np.degrees(np.arccos(cosine))
    tcp, rotation = np.array(stated).T
    axes = (np.abs(np.diff(joints, axis=0)) / arm.speeds).max(axis=1)
    return np.maximum(np.maximum(far / tcp, turn / rotation), axes)


UNUSED = "[9E9,9E9,9E9,9E9,9E9,9E9]"
ROUND = [0, 1, 2, 3, 4, 0]


@pytest.mark.parametrize("override", [1, 5, 10, 30, 70, 100])
def test_a_percentage_becomes_a_speed_that_is_not_faster(override: int, tmp_path: Path) -> None:
    found = rapid(written(tmp_path, f"JOvrd {override}"))
    file = kept(found, tmp_path)
    way = PLACES[ROUND]
    wanted = (np.abs(np.diff(way, axis=0)) / MITSUBISHI.speeds).max(axis=1) / (override / 100.0)
    there = joints_on_other_arm(way, MITSUBISHI, ABB)
    took = least(there, ABB, speeds(file)[1:])
    assert (took >= wanted - 1e-9).all()
    if override <= 10:  # accelerating takes little of it, so it is not much slower either
        assert (took <= 1.3 * wanted).all()
    levels = {row.text: row.level for row in found.rows}
    assert levels[f"JOvrd {override}"] == "partial"


def test_the_override_is_a_factor_on_both_sides(tmp_path: Path) -> None:
    """`simulate` of both at several overrides: the output never takes the shorter time."""
    process = tmp_path / "cell.toml"
    process.write_text("joint_speed = 60\n", encoding="ascii")  # of the first move
    for override in (100, 40, 10):
        source = written(tmp_path, f"Ovrd {override}\nJOvrd 25")
        file = kept(rapid(source, process=process), tmp_path)
        took = []
        for path, arm in ((source, MITSUBISHI), (file, ABB)):
            language = "melfa-basic-6" if path is source else None
            program = load(path, robot=arm, language=language).program
            done = simulate(robots.solve_program(program, arm))
            took.append(done.moves.seconds[1:])
        assert len(took[0]) == len(took[1]) == 5
        assert all(new >= old - 1e-6 for old, new in zip(*took, strict=True))


@pytest.mark.parametrize("stated", [20, 60, 150])
def test_no_move_with_a_percentage_exceeds_the_speed_that_is_stated(
    stated: int, tmp_path: Path
) -> None:
    """And none the speed that the arms give."""
    source, cell = written(tmp_path, "JOvrd 10"), tmp_path / "cell.toml"
    by_arms = np.array(speeds(kept(rapid(source), tmp_path))[1:])
    cell.write_text(f"[speeds.joint_speed]\nspeed = {stated}\n", encoding="ascii")
    found = rapid(source, cell=cell)
    limited = np.array(speeds(kept(found, tmp_path))[1:])
    assert (limited[:, 0] <= stated).all() and (limited <= by_arms + 1e-9).all()
    lower = by_arms[:, 0] > stated
    assert np.allclose(limited[~lower], by_arms[~lower])
    told = [one for row in found.rows for one in row.reasons if one.code == "CO512"]
    assert len(told) == lower.sum() and all("joint_speed" in one.cure for one in told)


@pytest.mark.parametrize(
    ("top", "table", "process", "least", "told"),
    [(80, 40, None, 40, 1), (40, 80, None, 40, 1), (None, 50, 30, 30, 1), (None, 30, 50, 30, 0)],
)
def test_the_lowest_of_several_stated_speeds_counts(
    tmp_path: Path, top: int | None, table: int, process: int | None, least: int, told: int
) -> None:
    cell, other = tmp_path / "cell.toml", tmp_path / "other.toml"
    head = f"joint_speed = {top}\n" if top else ""
    cell.write_text(f"{head}[speeds.joint_speed]\nspeed = {table}\n", encoding="ascii")
    other.write_text(f"joint_speed = {process or 90}\n", encoding="ascii")
    found = rapid(written(tmp_path, "JOvrd 100"), cell=cell, process=other)
    assert max(tcp for tcp, _ in speeds(kept(found, tmp_path))) == least
    assert sum(one.code == "CO079" for one in found.whole) == told


def test_there_and_back_stays_near(tmp_path: Path) -> None:
    file = kept(rapid(written(tmp_path, "JOvrd 30")), tmp_path)
    back = translate(file, to="melfa-basic-6", robot=MITSUBISHI, from_robot=ABB)
    assert back.ok, back.findings
    (data,) = back.files.values()
    given = [float(v) for v in re.findall(r"JOvrd (\d+)", data.decode())]
    assert 15 <= min(given[1:]) <= max(given[1:]) <= 30


def test_a_speed_becomes_a_percentage_that_is_not_faster(tmp_path: Path) -> None:
    joints = joints_on_other_arm(PLACES, MITSUBISHI, ABB)
    lines = [
        f"CONST jointtarget j{k}:=[[{','.join(f'{v:.6f}' for v in row)}],{UNUSED}];"
        for k, row in enumerate(joints, 1)
    ]
    given = [150.0, 80.0, 400.0, 1000.0]
    moves = [f"MoveAbsJ j{k},v{v:g},fine,tool0;" for k, v in zip((2, 3, 4, 5), given, strict=True)]
    text = ["MODULE way", *lines, "PROC main()", "MoveAbsJ j1,v50,fine,tool0;", *moves]
    source = tmp_path / "way.mod"
    source.write_text("\n".join([*text, "ENDPROC", "ENDMODULE", ""]), encoding="ascii")
    found = translate(source, to="melfa-basic-5", robot=MITSUBISHI, from_robot=ABB)
    file = kept(found, tmp_path)
    percents, now = [], 100.0
    for line in file.read_text("ascii").splitlines():
        if match := re.search(r"JOvrd (\d+)", line):
            now = float(match[1])
        if re.search(r"\bMov J", line):
            percents.append(now)
    taken = {t.joints for t in records(found.compiled.program) if isinstance(t, JointTarget)}
    assert len(taken) == len(PLACES)
    wanted = least(joints, ABB, [(v, 500.0) for v in given])
    axes = (np.abs(np.diff(PLACES, axis=0)) / MITSUBISHI.speeds).max(axis=1)
    took = axes / (np.array(percents[1:]) / 100.0)
    slow = np.array(percents[1:]) > 1
    assert (took[slow] >= wanted[slow] - 1e-3).all()
    assert slow.sum() >= 3


def test_without_both_arms_or_a_start_it_is_not_said(tmp_path: Path) -> None:
    """But with the speed that the process file states."""
    poses = "P1=(+350.00,+20.00,+250.00,+180.00,+0.00,+180.00)(7,0)\n"
    source = tmp_path / "ONE.mb6"
    source.write_text(f"Tool P_NTool\nBase P_NBase\nJOvrd 10\nSpd 1000\nMov P1\nEnd\n{poses}")
    process = tmp_path / "cell.toml"
    process.write_text("joint_speed = 60\n", encoding="ascii")
    for arms in ({}, {"robot": None, "from_robot": None}):
        lost = rapid(source, **arms)
        assert not lost.files
        assert {r.text: r.level for r in lost.rows}["Mov P1"] == "not"
        assert any("joint_speed" in f.cure for r in lost.rows for f in r.reasons)
        found = rapid(source, process=process, **arms)
        (data,) = found.files.values()
        assert b"speed_60" in data or b"v60" in data
        assert {r.text: r.level for r in found.rows}["Mov P1"] == "partial"


def test_the_speed_of_lines_is_none_of_joint_moves(tmp_path: Path) -> None:
    slow, fast = (
        speeds(kept(rapid(written(tmp_path, f"Spd {v}\nJOvrd 10")), tmp_path)) for v in (20, 2000)
    )
    assert slow == fast


def test_it_is_asked_for_where_the_arms_do_not_tell_every_speed(tmp_path: Path) -> None:
    """Where the first move begins is not known, with whatever arms."""
    source, cell = written(tmp_path, "JOvrd 30"), tmp_path / "cell.toml"
    text = source.read_text("ascii").replace("JOvrd 100", "JOvrd 30")
    source.write_text(text, encoding="ascii")
    asked = rapid(source, cell=cell)
    assert [(one.name, one.kind) for one in asked.wanting] == [("joint_speed", "speed")]
    assert "WAY.mb6:4" in asked.wanting[0].uses
    assert asked.totals["not"] == 0 and not asked.ok
    cell.write_text("[speeds.joint_speed]\nspeed = 90\n", encoding="ascii")
    assert rapid(source, cell=cell).ok
