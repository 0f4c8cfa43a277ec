"""Tables: rows with names become targets and moves, rows without become one path."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from assistant import sources
from assistant.program import rotations
from assistant.program.diagnostics import Refused, Severity
from assistant.program.expressions import JointValue, Name, Number
from assistant.program.geometry import Configuration, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.path import Kind, Path
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
from assistant.sources import tables
from assistant.sources.process import NO_PROCESS, Defaults, Process

POSE = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"
CELL = Process(
    defaults=Defaults(speed=Speed(80.0, rotation=90.0), blend=Blend(2.0), tool="Torch"),
    tools={"Torch": Tool(Pose((0.0, 0.0, 120.0))), "gripper": Tool()},
    signals={"glue": Signal("digital", "output", 8), "ready": Signal("digital", "input", 1)},
)


def read(text: str | bytes, process: Process = NO_PROCESS) -> sources.Reading:
    data = text.encode() if isinstance(text, str) else text
    return tables.read_table(data, "part.csv", "part", process)


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
        "name," + POSE + ',comment,set_glue,wait_s\np,1,2,3,1,0,0,0,"now\nglue; ""x"" ",1,0.5\n',
        CELL,
    )
    assert body == (
        Comment('now glue; "x"'),
        Move("joint", Name("p"), CELL.defaults.motion),
        SetSignal("glue", Number(1)),
        Wait(Number(0.5)),
    )


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
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
    assert [f.code for f in reading.findings] == ["NM001"] * 3
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


SIGNALS = Process(
    signals={
        "glue": Signal("digital", "output", 8),
        "force": Signal("analog", "output", 3),
    }
)
BAD = {
    "decimal comma": (POSE.replace(",", ";") + "\n1,5;2;3;1;0;0;0\n", "TB121", 2, "`1,5`"),
    "quoted comma": (POSE + '\n"1,5",2,3,1,0,0,0\n', "TB121", 2, "decimal comma"),
    "bare comma": (POSE + "\n1,5,2,3,1,0,0,0\n", "TB115", 2, "8 cells"),
    "nan": (POSE + "\n1,2,3,1,0,0,0\n1,nan,3,1,0,0,0\n", "TB122", 3, "`nan`"),
    "inf": (POSE + "\n1,-Infinity,3,1,0,0,0\n", "TB122", 2, "Infinity"),
    "overflow": (POSE + "\n1,1e999,3,1,0,0,0\n", "TB201", 2, "inf"),
    "formula": (POSE + "\n=A1+2,2,3,1,0,0,0\n", "TB123", 2, "formula"),
    "unit": (POSE + "\n1 mm,2,3,1,0,0,0\n", "TB124", 2, "`1 mm`"),
    "word": (POSE + "\n1,2,three,1,0,0,0\n", "TB125", 2, "`three`"),
    "two numbers": (POSE + "\n1,2,3 4,1,0,0,0\n", "TB125", 2, "`3 4`"),
    "two points": (POSE + "\n1,2,1.2.3,1,0,0,0\n", "TB125", 2, "`1.2.3`"),
    "underscore": (POSE + "\n1,2,1_000,1,0,0,0\n", "TB125", 2, "`1_000`"),
    "bracket": (POSE + "\n1,2,(5),1,0,0,0\n", "TB125", 2, "`(5)`"),
    "empty cell": (POSE + "\n1,2,,1,0,0,0\n", "TB126", 2, "empty"),
    "no target": ("name," + POSE + "\np,,,,,,,\n", "TB131", 2, "neither"),
    "ragged": (POSE + "\n1,2,3,1,0,0,0\n1,2,3\n", "TB114", 3, "3 cells"),
    "header only": (POSE + "\n", "TB113", 1, "no row"),
    "blank": ("\n \n", "TB112", None, "blank"),
    "binary": (b"\x89PNG\0\0", "TB111", None, "zero bytes"),
    "no header": ("1,2,3,1,0,0,0\n1,2,3,1,0,0,0\n", "TB106", 1, "names no columns"),
    "missing z": (POSE.replace("z_mm,", "") + "\n1,2,1,0,0,0\n", "TB104", 1, "`z_mm`"),
    "missing part": (POSE.replace(",q_z", "") + "\n1,2,3,1,0,0\n", "TB104", 1, "`q_z`"),
    "no orientation": ("x_mm,y_mm,z_mm\n1,2,3\n", "TB104", 1, "orientation"),
    "unknown column": (POSE + ",sped_mm_s\n1,2,3,1,0,0,0,9\n", "TB101", 1, "`sped_mm_s`"),
    "no unit": ("x,y_mm,z_mm,q_w,q_x,q_y,q_z\n1,2,3,1,0,0,0\n", "TB102", 1, "unit"),
    "no convention": ("x_mm,y_mm,z_mm,rx,ry,rz\n1,2,3,1,0,0\n", "TB102", 1, "convention"),
    "twice": (POSE + ",x_m\n1,2,3,1,0,0,0,1\n", "TB103", 1, "`x_m`"),
    "two orientations": (
        POSE + ",rotvec_x_deg,rotvec_y_deg,rotvec_z_deg\n1,2,3,1,0,0,0,1,1,1\n",
        "TB107", 1, "twice",
    ),
    "nameless column": (POSE + ",\n1,2,3,1,0,0,0,\n", "TB105", 1, "column 8"),
    "wait of a waypoint": (POSE + ",wait_s\n1,2,3,1,0,0,0,1\n", "TB108", 1, "`wait_s`"),
    "long quaternion": (POSE + "\n1,2,3,1.002,0,0,0\n", "TB203", 2, "1.002"),
    "zero quaternion": (POSE + "\n1,2,3,0,0,0,0\n", "TB203", 2, "0 long"),
    "a kilometre": (POSE + "\n1,2,1.1e6,1,0,0,0\n", "TB202", 2, "1.1e+06"),
    "metres of kilometres": (
        "x_m,y_m,z_m,q_w,q_x,q_y,q_z\n1,2,1.1e3,1,0,0,0\n", "TB202", 2, "1.1e+06",
    ),
    "unknown tool": (POSE + ",tool\n1,2,3,1,0,0,0,tolo\n", "TB301", 2, "`tolo`"),
    "unknown frame": (POSE + ",frame\n1,2,3,1,0,0,0,desk\n", "TB302", 2, "`desk`"),
    "unknown motion": (POSE + ",motion\n1,2,3,1,0,0,0,straight\n", "TB304", 2, "straight"),
    "no speed": (POSE + ",speed_mm_s\n1,2,3,1,0,0,0,0\n", "TB305", 2, "is 0"),
    "more than all": (POSE + ",joint_percent\n1,2,3,1,0,0,0,101\n", "TB202", 2, "101"),
    "negative blend": (POSE + ",blend_mm\n1,2,3,1,0,0,0,-1\n", "TB306", 2, "-1"),
    "blend of no number": (
        POSE + ",blend_mm\n1,2,3,1,0,0,0,fine\n1,2,3,1,0,0,0,z10\n", "TB125", 3, "`z10`",
    ),
    "via at the start": (
        POSE + ",motion\n1,2,3,1,0,0,0,via\n1,2,3,1,0,0,0,end\n", "TB308", 2, "start from",
    ),
    "via alone": (
        POSE + ",motion\n1,2,3,1,0,0,0,linear\n1,2,3,1,0,0,0,via\n", "TB308", 3, "no `end`",
    ),
    "end alone": (POSE + ",motion\n1,2,3,1,0,0,0,end\n", "TB308", 2, "no `via`"),
    "wait at via": (
        "name," + POSE + ",motion,wait_s\na,1,2,3,1,0,0,0,linear,\n"
        "b,1,2,3,1,0,0,0,via,1\nc,1,2,3,1,0,0,0,end,1\n",
        "TB311", 3, "`wait_s`",
    ),
    "half a branch": (
        POSE + ",back,down,flip,quadrant1,quadrant4,quadrant6\n1,2,3,1,0,0,0,1,,,,,\n",
        "TB134", 2, "arm branch",
    ),
    "joints by a line": ("name,j1_deg,motion\np,1,linear\n", "TB135", 2, "linear"),
    "both": (POSE + ",j1_deg\n1,2,3,1,0,0,0,5\n", "TB132", 2, "pose and joints"),
    "mixed": (POSE + ",j1_deg\n1,2,3,1,0,0,0,\n,,,,,,,5\n", "TB133", 3, "mix"),
    "same name": (
        "name," + POSE + "\np,1,2,3,1,0,0,0\nP,1,2,3,1,0,0,0\n", "TB309", 3, "line 2",
    ),
    "no name": ("name," + POSE + "\n,1,2,3,1,0,0,0\n", "TB310", 2, "no name"),
    "undeclared signal": (
        "name," + POSE + ",set_spray\np,1,2,3,1,0,0,0,1\n", "TB303", 1, "`spray`",
    ),
    "half a digital signal": (
        "name," + POSE + ",set_glue\np,1,2,3,1,0,0,0,\nq,1,2,3,1,0,0,0,0.5\n",
        "TB312", 3, "`glue`",
    ),
    "endless signal": (
        "name," + POSE + ",set_force\nq,1,2,3,1,0,0,0,1e999\n", "TB201", 2, "`set_force`",
    ),
    "stray quote": ('name,' + POSE + '\n5" pipe,1,2,3,1,0,0,0\n', "TB116", 2, "quotation"),
    "stray quote before a blank": (
        'name,' + POSE + '\nx" ,1,2,3,1,0,0,"0"\n', "TB116", 2, "quotation",
    ),
    "text after a quote": ('name,' + POSE + '\n"a"b,1,2,3,1,0,0,0\n', "TB116", 2, "quotation"),
    "unclosed quote": ('name,' + POSE + '\n"pipe,1,2,3,1,0,0,0\n', "TB117", 2, "never closed"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_with_its_place_and_a_cure(case: str) -> None:
    text, code, line, words = BAD[case]
    with pytest.raises(Refused) as refused:
        read(text, SIGNALS)
    found = [f for f in refused.value.findings if f.code == code]
    assert found, refused.value.findings
    finding = found[0]
    assert finding.path == "part.csv"
    assert finding.line == line
    assert words in finding.message
    assert finding.cure
    assert "\n" not in finding.message


def test_every_wrong_column_of_a_table_is_reported_at_once() -> None:
    with pytest.raises(Refused) as refused:
        read(POSE + "\na,b,3,1,0,0,0\n")
    assert [f.place for f in refused.value.findings] == ["column `x_mm`", "column `y_mm`"]
    with pytest.raises(Refused) as refused:
        read(POSE + ",tool,motion\n2e6,0,3,1.1,0,0,0,drill,fly\n")
    assert {f.code for f in refused.value.findings} == {"TB202", "TB203", "TB301", "TB304"}


def test_the_line_of_a_bad_cell_counts_line_feeds_in_quoted_cells() -> None:
    with pytest.raises(Refused) as refused:
        read("name," + POSE + '\n"a\n\nb",1,2,3,1,0,0,0\nc,1,x,3,1,0,0,0\n')
    assert refused.value.findings[0].line == 5


def test_the_bad_cell_in_many_rows_is_found() -> None:
    rows = ["1,2,3,1,0,0,0"] * 70_000
    rows[65_123] = "1,2,3,1,0,0,0.0.0"
    with pytest.raises(Refused) as refused:
        read("\n".join([POSE, *rows]))
    (finding,) = refused.value.findings
    assert (finding.line, finding.place) == (65_125, "column `q_z`")


def test_too_many_different_speeds_are_refused() -> None:
    rows = [f"1,2,3,1,0,0,0,{100 + i * 0.01}" for i in range(1001)]
    with pytest.raises(Refused) as refused:
        read("\n".join([POSE + ",speed_mm_s", *rows]))
    assert refused.value.findings[0].code == "TB307"


def test_an_undeclared_default_tool_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        read(POSE + "\n1,2,3,1,0,0,0\n", Process(defaults=Defaults(tool="torch")))
    assert refused.value.findings[0].code == "TB301"


def test_many_rows_do_not_become_python_objects() -> None:
    n = 50_000
    rng = np.random.default_rng(7)
    quaternions = rotations.canonical(rng.normal(size=(n, 4)))
    table = np.column_stack([rng.uniform(-500, 500, (n, 3)), quaternions, rng.integers(50, 90, n)])
    lines = [",".join(f"{v:.9f}" for v in row) + ",Torch" for row in table]
    data = "\n".join([POSE + ",speed_mm_s,tool", *lines]).encode()
    read("\n".join([POSE, "1,2,3,1,0,0,0"]), CELL)  # what is imported late is not counted
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
@settings(deadline=None, max_examples=150)
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


GOOD = ("name," + POSE + ",speed_mm_s,blend_mm,motion,comment\n").encode() + (
    b'pick,1,2.5,-3,0,1,0,0,250,fine,joint,"a, b"\nplace,4,5,6,1,0,0,0,,10,linear,\n'
)


@given(
    st.lists(
        st.tuples(st.integers(0, len(GOOD)), st.integers(0, 3), st.binary(max_size=3)), max_size=4
    )
)
@settings(deadline=None, max_examples=300)
def test_damaged_tables_are_read_or_refused_never_crash(
    edits: list[tuple[int, int, bytes]],
) -> None:
    data = GOOD
    for at, gone, put in edits:
        data = data[:at] + put + data[at + gone :]
    try:
        program = read(data).program
    except Refused as refused:
        assert refused.findings
        assert all(f.path == "part.csv" and f.code for f in refused.findings)
    else:
        assert all(np.isfinite(t.pose.position).all() for t in program.targets.values())


@given(st.binary(max_size=60))
@settings(deadline=None, max_examples=200)
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    try:
        read(data)
    except Refused as refused:
        assert all(f.path == "part.csv" for f in refused.findings)


@given(name=st.text(min_size=1, max_size=30))
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_name_survives_as_an_identifier(name: str) -> None:
    cell = '"' + name.replace('"', '""') + '"'
    try:
        program = read(f"name,{POSE}\n{cell},1,2,3,1,0,0,0\n".encode("utf-8", "replace")).program
    except Refused as refused:
        assert {f.code for f in refused.findings} <= {"TB310", "TB111"}
    else:
        (target,) = program.targets
        assert target.isascii()
        assert target.replace("_", "").isalnum()
        assert target[0].isalpha()


def test_a_file_is_read_with_the_process_file_beside_it(tmp_path: FilePath) -> None:
    (tmp_path / "my part.csv").write_text(POSE + ",tool\n" + "1,2,3,1,0,0,0,torch\n" * 2)
    (tmp_path / "my part.process.toml").write_text("[tools.torch]\ntip = [0, 0, 100]\n")
    reading = sources.read(tmp_path / "my part.csv")
    assert reading.program.name == "my_part"
    assert reading.program.tools["torch"].tip == Pose((0.0, 0.0, 100.0))
    assert [(f.code, f.severity) for f in reading.findings] == [("NM001", Severity.INFO)]


@pytest.mark.parametrize("kind", ["missing", "empty", "folder"])
def test_what_cannot_be_read_at_all(kind: str, tmp_path: FilePath) -> None:
    path = tmp_path / "part.csv"
    if kind == "empty":
        path.touch()
    elif kind == "folder":
        path.mkdir()
    with pytest.raises(Refused) as refused:
        sources.read(path)
    assert refused.value.exit_status == 2


def test_a_value_that_is_no_number_is_told_of_at_its_own_signal() -> None:
    text = "name," + POSE + ",set_glue,set_flow\np,1,2,3,1,0,0,0,1,1e999\n"
    analog = Signal("analog", "output", 2)
    cell = replace(CELL, signals={**CELL.signals, "flow": analog})
    with pytest.raises(Refused) as refused:
        read(text, cell)
    (found,) = refused.value.findings
    assert found.place == "column `set_flow`"
