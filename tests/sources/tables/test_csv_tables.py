"""Tables: rows with names become targets and moves, rows without become one path."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from assistant import sources
from assistant.base import rotations
from assistant.base.diagnostics import Severity
from assistant.program.expressions import JointValue, Name, Number
from assistant.program.geometry import Configuration, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Signal
from assistant.program.statements import (
    Comment,
    Follow,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    SetSignal,
    Wait,
)
from assistant.sources.process import NO_PROCESS, Defaults, Process
from assistant.sources.tables import csv_tables
from tests.examples import drawn
from tests.tables import every_row

POSE = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"
CELL = Process(
    defaults=Defaults(speed=Speed(80.0, rotation=90.0), blend=Blend(2.0), tool="Torch"),
    tools={"Torch": Tool(Pose((0.0, 0.0, 120.0))), "gripper": Tool()},
    signals={"glue": Signal("digital", "output", 8), "ready": Signal("digital", "input", 1)},
)


def read(text: str | bytes, process: Process = NO_PROCESS) -> sources.Reading:
    data = text.encode() if isinstance(text, str) else text
    return csv_tables.read_table(data, "part.csv", "part", process)


def path_of(text: str | bytes, process: Process = NO_PROCESS) -> Path:
    (statement,) = read(text, process).program.procedures[0].body
    assert isinstance(statement, Follow)
    return statement.path


def body_of(text: str, process: Process = NO_PROCESS) -> tuple[object, ...]:
    return read(text, process).program.procedures[0].body


def test_named_rows_become_targets_and_moves() -> None:
    reading = read(
        "name,x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,speed_mm_s,blend_mm,tool,frame,motion\n"
        "pick,1,2.5,-3,0,1,0,0,250,fine,,,joint\n"
        "place,4,5,6,1,0,0,0,,10,GRIPPER,base,\n",
        CELL,
    )
    program = reading.program
    assert reading.findings == ()
    assert program.name == "part"
    assert program.targets == {
        "pick": Target(Pose((1.0, 2.5, -3.0), (0.0, 1.0, 0.0, 0.0))),
        "place": Target(Pose((4.0, 5.0, 6.0))),
    }
    assert program.tools == dict(CELL.tools)
    assert program.procedures[0].body == (
        Move("joint", Name("pick"), Motion(Speed(250.0, rotation=90.0), FINE, "Torch")),
        Move("linear", Name("place"), Motion(Speed(80.0, rotation=90.0), Blend(10.0), "gripper")),
    )


def test_rows_without_names_become_one_path_in_columns() -> None:
    path = path_of(
        POSE + ",speed_mm_s,rotation_deg_s,blend_mm,tool,motion\n"
        "1,2,3,1,0,0,0,100,,0,gripper,joint\n"
        "4,5,6,0,1,0,0,50,30,5,,linear\n"
        "7,8,9,0,0,1,0,100,,0,gripper,linear\n",
        CELL,
    )
    assert path.name == "part"
    assert path.kinds.tolist() == [Kind.JOINT, Kind.LINEAR, Kind.LINEAR]
    assert path.positions.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert path.quaternions.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]
    assert [path.speeds[i] for i in path.speed] == [
        Speed(100.0, rotation=90.0), Speed(50.0, rotation=30.0), Speed(100.0, rotation=90.0)
    ]  # fmt: skip
    assert len(path.speeds) == 2
    assert [path.blends[i] for i in path.blend] == [FINE, Blend(5.0), FINE]
    assert [path.tools[i] for i in path.tool] == ["gripper", "Torch", "gripper"]


def test_one_row_without_a_name_is_a_move_not_a_path() -> None:
    program = read(POSE + "\n1,2,3,1,0,0,0\n").program
    assert program.targets == {"part_1": Target(Pose((1.0, 2.0, 3.0)))}
    assert program.procedures[0].body == (
        Move("joint", Name("part_1"), NO_PROCESS.defaults.motion),
    )


def test_joint_targets_external_axes_and_a_missing_joint() -> None:
    program = read("name,j1_deg,j2_rad,j3_mm,j5_deg,e1_mm,e2_m\nhome,10,1,30,-5,100,\n").program
    assert program.joint_targets == {
        "home": JointTarget(
            (10.0, math.degrees(1.0), 30.0, math.nan, -5.0), (100.0, *[math.nan] * 5)
        )
    }
    assert body_of("j1_deg,j2_deg\n1,2\n") == (
        MoveJoints(JointValue(JointTarget((1.0, 2.0))), NO_PROCESS.defaults.motion),
    )


def test_a_table_may_mix_poses_and_joints_in_named_rows() -> None:
    program = read("name," + POSE + ",j1_deg,j2_deg\nhome,,,,,,,,1,2\np,1,2,3,1,0,0,0,,\n").program
    assert set(program.joint_targets) == {"home"}
    assert set(program.targets) == {"p"}
    home, p = program.procedures[0].body
    assert isinstance(home, MoveJoints)
    assert isinstance(p, Move)


def test_arm_branches() -> None:
    header = "name," + POSE + ",back,down,flip,quadrant1,quadrant4,quadrant6\n"
    program = read(header + "a,1,2,3,1,0,0,0,1,0,1,-1,0,2\nb,1,2,3,1,0,0,0,,,,,,\n").program
    assert program.targets["a"].configuration == Configuration(True, False, True, (-1, 0, 2))
    assert program.targets["b"].configuration is None


def test_arcs_of_named_rows_and_of_paths() -> None:
    rows = "{0}1,0,0,1,0,0,0,{1}\n"
    text = "".join(
        rows.format(f"p{i},", kind) for i, kind in enumerate(("linear", "via", "end", "via", "end"))
    )
    body = body_of("name," + POSE + ",motion\n" + text)
    assert [type(s) for s in body] == [Move, MoveCircular, MoveCircular]
    assert body[2] == MoveCircular(Name("p3"), Name("p4"), NO_PROCESS.defaults.motion)
    unnamed = "".join(rows.format("", kind) for kind in ("linear", "via", "end"))
    assert path_of(POSE + ",motion\n" + unnamed).kinds.tolist() == [1, 2, 3]


def test_signals_waits_and_comments_of_named_rows() -> None:
    body = body_of(
        "name," + POSE + ',comment,wait_s,set_glue\np,1,2,3,1,0,0,0,"now\nglue; ""x"" ",0.5,1\n',
        CELL,
    )
    assert body == (
        Comment('now glue; "x"'),
        Move("joint", Name("p"), replace(CELL.defaults.motion, blend=FINE)),
        SetSignal("glue", Number(1)),
        Wait(Number(0.5)),
    )


@every_row("delimiter", [",", ";", "\t"])
@every_row("newline", ["\n", "\r\n", "\r"])
@every_row("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_delimiters_line_ends_and_encodings(delimiter: str, newline: str, encoding: str) -> None:
    lines = ["# küche", "", "name," + POSE, "a,1,2,3,1,0,0,0", "", ' "b" , 4,5 ,6,1,0,"0",0', ""]
    text = newline.join(lines).replace(",", delimiter)
    program = read(text.encode(encoding)).program
    assert [t.pose.position for t in program.targets.values()] == [(1, 2, 3), (4, 5, 6)]
    assert program.comments == ("küche",)
    assert list(program.targets) == ["a", "b"]


def test_names_from_outside_are_data() -> None:
    reading = read(
        "name," + POSE + "\n"
        '"a;b\nENDPROC",1,2,3,1,0,0,0\n'
        "=cmd|' /C calc'!A0,1,2,3,1,0,0,0\n"
        "a_b ENDPROC,1,2,3,1,0,0,0\n"
    )
    assert list(reading.program.targets) == ["a_b_ENDPROC", "cmd_C_calc_A0", "a_b_ENDPROC_2"]
    assert [f.code for f in reading.findings] == ["NM001", "NM001", "NM002"]
    assert [f.line for f in reading.findings] == [2, 4, 5]


def test_left_out_columns_and_empty_rows_are_reported() -> None:
    reading = read(POSE + ",_time\n1,2,3,1,0,0,0,12:30\n,,,,,,,\n1,2,3,1,0,0,0,x\n")
    assert [(f.code, f.severity) for f in reading.findings] == [
        ("TB118", Severity.INFO), ("TB136", Severity.INFO)
    ]  # fmt: skip


def test_quaternions_nearly_of_unit_length_are_repaired_with_one_warning() -> None:
    reading = read(POSE + "\n" + "1,2,3,1.0005,0,0,0\n" * 3 + "1,2,3,1.0000001,0,0,0\n")
    (finding,) = reading.findings
    assert (finding.code, finding.severity) == ("TB204", Severity.WARNING)
    assert "3 quaternions" in finding.message
    (follow,) = reading.program.procedures[0].body
    assert isinstance(follow, Follow)
    assert np.abs(np.linalg.norm(follow.path.quaternions, axis=1) - 1).max() < 1e-15


def test_many_rows_do_not_become_python_objects() -> None:
    n = 50_000
    rng = np.random.default_rng(7)
    quaternions = rotations.canonical(rng.normal(size=(n, 4)))
    table = np.column_stack([rng.uniform(-500, 500, (n, 3)), quaternions, rng.integers(50, 90, n)])
    lines = [",".join(f"{v:.9f}" for v in row) + ",Torch" for row in table]
    head = POSE + ",speed_mm_s,tool"
    data = "\n".join([head, *lines]).encode()
    path_of("\n".join([head, *lines[:100]]), CELL)  # what is imported late is not counted
    before = sys.getallocatedblocks()
    path = path_of(data, CELL)
    assert sys.getallocatedblocks() - before < 2000
    assert np.abs(path.positions - table[:, :3]).max() < 1e-8
    assert rotations.angle_between(path.quaternions, quaternions).max() < 1e-6
    assert [path.speeds[i].tcp for i in path.speed[:50]] == table[:50, 7].tolist()


CONVENTIONS = {
    "quaternion": None,
    "euler_zyx": ("ZYX", ("z", "y", "x")),
    "euler_xyz": ("XYZ", ("x", "y", "z")),
    "euler_zyz": ("ZYZ", ("z1", "y", "z2")),
    "fixed_xyz": ("ZYX", ("z", "y", "x")),
    "fixed_zyx": ("XYZ", ("x", "y", "z")),
}


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


@st.composite
def tables_of_poses(draw: st.DrawFn) -> tuple[str, np.ndarray, np.ndarray]:
    n = draw(st.integers(1, 12))
    positions = draw(arrays.arrays(np.float64, (n, 3), elements=numbers(-900, 900)))
    raw = draw(arrays.arrays(np.float64, (n, 4), elements=numbers(-1, 1)))
    raw[np.linalg.norm(raw, axis=1) < 1e-3] = (1, 0, 0, 0)
    quaternions = rotations.canonical(raw)
    unit, per_unit = draw(st.sampled_from([("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("in", 25.4)]))
    columns = {f"{axis}_{unit}": positions[:, i] / per_unit for i, axis in enumerate("xyz")}
    convention = draw(st.sampled_from([*CONVENTIONS, "rotvec"]))
    angle = draw(st.sampled_from(["deg", "rad"]))
    to_angle = np.asarray if angle == "deg" else np.radians
    if convention == "quaternion":
        columns |= {f"q_{axis}": quaternions[:, i] for i, axis in enumerate("wxyz")}
    elif convention == "rotvec":
        half = np.arctan2(np.linalg.norm(quaternions[:, 1:], axis=1), quaternions[:, 0])
        scale = np.degrees(2 * half) / np.where(np.sin(half) == 0, 1.0, np.sin(half))
        vectors = to_angle(quaternions[:, 1:] * scale[:, None])
        columns |= {f"rotvec_{axis}_{angle}": vectors[:, i] for i, axis in enumerate("xyz")}
    else:
        order, letters = CONVENTIONS[convention]
        angles = to_angle(rotations.to_euler(quaternions, order))
        columns |= {f"{convention}_{a}_{angle}": angles[:, i] for i, a in enumerate(letters)}
    names = draw(st.permutations(list(columns)))
    delimiter = draw(st.sampled_from([",", ";", "\t", ", "]))
    newline = draw(st.sampled_from(["\n", "\r\n"]))
    form = draw(st.sampled_from(["{!r}", "{:.17e}", '"{!r}"', "+{!r}"]))
    rows = [
        delimiter.join(form.format(float(columns[n][i])).replace("+-", "-") for n in names)
        for i in range(n)
    ]
    return newline.join([delimiter.join(names), *rows]), positions, quaternions


@given(tables_of_poses())
@settings(deadline=None, max_examples=drawn(150))
def test_written_poses_are_read_back(case: tuple[str, np.ndarray, np.ndarray]) -> None:
    text, positions, quaternions = case
    program = read(text).program
    if len(positions) == 1:
        pose = program.targets["part_1"].pose
        found, turned = np.array([pose.position]), np.array([pose.quaternion])
    else:
        path = path_of(text)
        found, turned = path.positions, path.quaternions
    assert np.abs(found - positions).max() < 1e-9
    assert rotations.angle_between(turned, quaternions).max() < 1e-5  # Euler angles near the pole


def test_a_file_is_read_with_the_process_file_beside_it(tmp_path: FilePath) -> None:
    (tmp_path / "my part.csv").write_text(POSE + ",tool\n" + "1,2,3,1,0,0,0,torch\n" * 2)
    (tmp_path / "my part.process.toml").write_text("[tools.torch]\ntip = [0, 0, 100]\n")
    reading = sources.read(tmp_path / "my part.csv")
    assert reading.program.name == "my_part"
    assert reading.program.tools["torch"].tip == Pose((0.0, 0.0, 100.0))
    assert [(f.code, f.severity) for f in reading.findings] == [("NM001", Severity.INFO)]
