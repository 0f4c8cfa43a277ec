"""Warnings on rows: outputs behind corners, joint moves out of narrow places."""

from pathlib import Path

import pytest

import assistant

PROCESS = """
[signals.grip]
number = 4
direction = "output"
"""
ROWS = """name,x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,blend_mm,set_grip,wait_s
a,500,0,400,0,1,0,0,{first},,
b,500,100,400,0,1,0,0,{blend},{value},{wait}
c,500,200,400,0,1,0,0,20,,
d,500,300,400,0,1,0,0,{last},{value},
e,500,400,400,0,1,0,0,fine,,
"""


def told(source: Path) -> list[tuple[int | None, str]]:
    found = assistant.compile(source, language="rapid").findings
    return [(f.line, f.message) for f in found if f.code == "TB316"]


def table(folder: Path, **cells: object) -> Path:
    usual = {"first": "fine", "blend": "fine", "value": 1, "wait": "", "last": "fine"}
    (folder / "a.process.toml").write_text(PROCESS)
    source = folder / "a.csv"
    source.write_text(ROWS.format(**usual | cells))
    return source


@pytest.mark.parametrize(
    ("cells", "line", "names"),
    [
        ({"blend": 20}, 3, "`b`"),
        ({"blend": 20, "wait": 1.5}, 3, "`b`"),
        ({"last": 0.5}, 5, "`d`"),
        ({"blend": 20, "last": 20}, 3, "`b, d`"),
    ],
)
def test_a_row_with_a_corner_and_outputs_is_told_of(cells, line, names, tmp_path: Path) -> None:
    ((at, message),) = told(table(tmp_path, **cells))
    assert at == line and f" {names}, " in message


@pytest.mark.parametrize("cells", [{}, {"blend": 0}, {"blend": 20, "value": ""}, {"wait": 2}])
def test_stops_and_rows_without_outputs_are_not(cells, tmp_path: Path) -> None:
    assert told(table(tmp_path, **cells)) == []


TASK = """
moves = ["a", {{to = "b", set = {{grip = 1}}, blend = "fine"}}, "a", {{to = "b"{more}}}, "a"]

[motion]
blend = {blend}
{targets}"""
TARGETS = """
[[targets]]
name = "{name}"
position = [500, {y}, 400]
euler_zyx = [0, 0, 180]
"""


@pytest.mark.parametrize(
    ("more", "blend", "lines"),
    [
        ("", "10", []),
        (", set = {grip = 0}", "10", [2]),
        (", set = {grip = 0}", '"fine"', []),
        (', set = {grip = 0}, blend = "fine"', "10", []),
        (", set = {grip = 0}, blend = 5", '"fine"', [2]),
    ],
)
def test_moves_of_a_task(more: str, blend: str, lines: list[int], tmp_path: Path) -> None:
    (tmp_path / "a.process.toml").write_text(PROCESS)
    targets = "".join(TARGETS.format(name=name, y=y) for name, y in (("a", 0), ("b", 100)))
    source = tmp_path / "a.toml"
    source.write_text(TASK.format(more=more, blend=blend, targets=targets))
    assert [line for line, _ in told(source)] == lines


def left_by_joints(source: Path) -> list[tuple[int | None, str]]:
    found = assistant.compile(source, language="rapid").findings
    return [(f.line, f.message) for f in found if f.code == "TB317"]


IN_AND_OUT = """name,x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,motion
above,500,0,400,0,1,0,0,joint
at,500,0,{z},0,1,0,0,{into}
up,500,{y},400,0,1,0,0,{out}
end,500,200,400,0,1,0,0,joint
"""


@pytest.mark.parametrize(
    ("cells", "lines"),
    [
        ({}, [4]),
        ({"out": "linear"}, []),
        ({"into": "joint"}, []),
        ({"y": 1}, []),  # to somewhere else: that may be meant
    ],
)
def test_a_line_in_and_a_joint_move_out(
    cells: dict[str, object], lines: list[int], tmp_path: Path
) -> None:
    source = tmp_path / "a.csv"
    usual = {"z": 300, "into": "linear", "y": 0, "out": "joint"}
    source.write_text(IN_AND_OUT.format(**usual | cells))
    assert [line for line, _ in left_by_joints(source)] == lines


def test_a_line_in_and_a_joint_move_out_of_a_task(tmp_path: Path) -> None:
    targets = "".join(TARGETS.format(name=name, y=y) for name, y in (("a", 0), ("b", 100)))
    source = tmp_path / "a.toml"
    head = 'moves = [{to = "a", kind = "joint"}, "b", {to = "a", kind = "%s"}]\n'
    source.write_text(head % "joint" + targets)
    ((line, message),) = left_by_joints(source)
    assert line == 1 and "`b`" in message
    source.write_text(head % "linear" + targets)
    assert left_by_joints(source) == []
