"""Arrays as programs: what is emitted is held against the numbers that were given."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from roboticstoolbox import jtraj
from spatialmath import SE3

import assistant
from assistant.base.diagnostics import Refused, Severity
from assistant.program.geometry import Pose, Tool
from assistant.program.motion import FINE, Blend, Kind, Speed
from assistant.program.statements import Follow, Move

IRB, RV, FIVE = "irb1200-7-0.7", "rv-4frl", "rv-2aj"
START, END = np.radians([0, 0, 0, 0, 30, 0]), np.radians([40, 20, 10, 5, 60, 30])
WAY = jtraj(START, END, 40)


def text_of(program, **options):
    compiled = assistant.compile(program, **options)
    assert compiled.ok, compiled.findings
    (data,) = compiled.files.values()
    return data.decode()


def test_a_trajectory_of_the_toolbox_is_joint_moves_in_rapid():
    program = assistant.from_joints(WAY, unit="rad", robot=IRB, speed=80, name="swing")
    text = text_of(program, language="rapid")
    moves = re.findall(r"MoveAbsJ \[\[([^]]*)\],\[[^]]*\]\],(\w+),(\w+),tool0", text)
    said = np.array([[float(v) for v in joints.split(",")] for joints, _, _ in moves])
    assert np.abs(said - np.degrees(WAY.q)).max() < 1e-5
    assert {speed for _, speed, _ in moves} == {"v80"}
    zones = [zone for _, _, zone in moves]
    assert zones[0] == zones[-1] == "fine" and "fine" not in zones[1:-1]


@pytest.mark.parametrize(
    ("robot", "columns", "language"),
    [(RV, [0, 1, 2, 3, 4, 5], "melfa-basic-5"), (FIVE, [0, 1, 2, 4, 5], "melfa-basic-4")],
)
def test_a_trajectory_of_the_toolbox_is_joint_moves_in_melfa_basic(robot, columns, language):
    q = WAY.q[:, columns]
    program = assistant.from_joints(q, unit="rad", robot=robot, percent=20, name="swing")
    text = text_of(program, language=language)
    said = {
        int(number): [float(value) for value in values.split(",")]
        for number, values in re.findall(r"^J(\d+)=\(([^)]*)\)", text, re.M)
    }
    order = [int(number) for number in re.findall(r"M(?:ov|OV) J(\d+)", text)]
    emitted = np.array([said[number] for number in order])[:, columns]
    assert np.abs(emitted - np.degrees(q)).max() <= 0.005 + 1e-9, "two decimals"
    assert re.search(r"J(?:Ovrd|OVRD) 20\b", text)


def test_degrees_and_radians_are_the_same_program():
    radians = assistant.from_joints(WAY.q, unit="rad", robot=IRB)
    degrees = assistant.from_joints(np.degrees(WAY.q).tolist(), unit="deg", robot=IRB)
    assert text_of(radians, language="rapid") == text_of(degrees, language="rapid")
    (one,) = assistant.from_joints(END, unit="rad", robot=IRB).statements()
    assert one.target.target.joints == pytest.approx(np.degrees(END))


def test_the_arm_comes_where_the_joints_say():
    """The kinematics of the toolbox, by parameters of its own arm, share no code with ours."""
    program = assistant.from_joints(WAY, unit="rad", robot=IRB, speed=200)
    done = assistant.simulate(program)
    samples = done.simulation.samples
    assert np.abs(samples.joints[-1] - np.degrees(END)).max() < 0.5, "the last sample, not the end"
    arm = assistant.robots.get(IRB).to_rtb()
    tips = np.array([arm.fkine(np.radians(row)).t for row in samples.joints[::20]])
    assert np.abs(samples.position[::20] - tips * 1000).max() < 0.05, "corners within the tolerance"


def test_a_blend_keeps_the_tip_near_its_way():
    straight = np.linspace([0, 0, 0, 0, 30, 0], [40, 0, 0, 0, 30, 0], 9)
    bent = np.vstack([straight, np.linspace([40, 0, 0, 0, 30, 0], [40, 30, 0, 0, 30, 0], 5)[1:]])
    program = assistant.from_joints(bent, unit="deg", robot=IRB)
    blends = [move.motion.blend for move in program.statements()]
    radii = [blend.radius for blend in blends[1:-1]]
    assert blends[0] == blends[-1] == FINE and all(radii)
    assert min(radii) == radii[7] < 0.1, "where the way turns"
    stops = assistant.from_joints(bent, unit="deg", robot=IRB, blend="fine")
    assert {move.motion.blend for move in stops.statements()} == {FINE}
    wide = assistant.from_joints(bent, unit="deg", robot=IRB, blend=5)
    first, *between, last = (move.motion.blend for move in wide.statements())
    assert set(between) == {Blend(5.0)} and first == last == FINE


WRONG_JOINTS = [
    ("TB433", {"unit": "grad"}),
    ("TB432", {"joints": WAY.q[:, :4]}),
    ("TB432", {"joints": np.zeros((0, 6))}),
    ("TB432", {"joints": np.zeros((2, 3, 6))}),
    ("TB431", {"joints": "J1"}),
    ("TB431", {"joints": 3.0}),
    ("TB431", {"joints": [[1, 2], [3]]}),
    ("TB201", {"joints": [[0, 0, 0, 0, math.nan, 0]]}),
    ("TB434", {"robot": None}),
    ("CO002", {"robot": "irb99"}),
    ("TB301", {"tool": "torch"}),
    ("TB436", {"tool": (1, 2)}),
    ("TB201", {"tool": (1, 2, math.inf)}),
    ("TB305", {"speed": 0}),
    ("TB305", {"speed": math.nan}),
    ("TB435", {"percent": 120}),
    ("TB306", {"blend": -1}),
]


@pytest.mark.parametrize(("code", "wrong"), WRONG_JOINTS)
def test_wrong_joints_are_refused(code, wrong):
    given = {"joints": WAY, "unit": "rad", "robot": IRB, **wrong}
    with pytest.raises(assistant.Refused) as caught:
        assistant.from_joints(given.pop("joints"), **given)
    (finding,) = caught.value.findings
    assert (finding.code, finding.severity) == (code, Severity.ERROR)
    assert finding.cure and finding.cure in str(caught.value)


def test_joints_beyond_their_limits_are_not_written(tmp_path):
    program = assistant.from_joints([[0, 0, 0, 0, 500, 0]], unit="deg", robot=IRB)
    compiled = assistant.compile(program, language="rapid")
    with pytest.raises(assistant.Refused, match=r"RB109.*J5"):
        compiled.write(tmp_path / "out")
    assert not (tmp_path / "out").exists() and not compiled.ok


def test_degrees_taken_as_radians_are_one_finding_that_names_the_unit():
    program = assistant.from_joints(np.degrees(WAY.q), unit="rad", robot=IRB)
    (finding,) = [f for f in assistant.check(program).findings if f.code.startswith("RB1")]
    assert finding.code == "RB129" and "40 joint targets" in finding.message
    assert "J5 at 3437.75 degrees" in finding.message and 'unit="deg"' in finding.cure
    beyond = np.vstack([np.degrees(WAY.q), np.full((9, 6), 40000.0)])
    program = assistant.from_joints(beyond, unit="deg", robot=IRB)
    (finding,) = [f for f in assistant.check(program).findings if f.code.startswith("RB1")]
    assert finding.code == "RB129" and "unit" not in finding.cure


def test_few_joints_beyond_their_limits_are_reported_one_by_one():
    rows = [[0, 0, 0, 0, 30, 0], [0, 0, 0, 0, 500, 500], [0, 0, 0, 0, -500, 0]]
    found = assistant.check(assistant.from_joints(rows, unit="deg", robot=IRB)).findings
    assert [f.code for f in found].count("RB109") == 3


def test_metres_taken_as_millimetres_are_named_as_a_cause():
    near = [[0.4, y, 0.5, 0, 1, 0, 0] for y in (-0.1, 0.1)]
    for poses, named in ((near, True), (np.multiply(near, [100.0] * 3 + [1.0] * 4), False)):
        found = assistant.check(assistant.from_poses(poses, unit="mm", robot=IRB)).findings
        (finding,) = [f for f in found if f.code == "CO340"]
        assert ("if the positions are metres" in finding.cure) is named


LINE = [SE3(0.3, y, 0.3) * SE3.Rx(180, "deg") for y in (-0.1, 0.0, 0.1)]


def paths_of(program):
    return [s.path for s in program.statements() if isinstance(s, Follow)]


def test_poses_have_the_form_of_a_table(tmp_path):
    gun = Tool(Pose((0, 0, 50)))
    program = assistant.from_poses(LINE, unit="m", name="lid", tool=gun, robot=IRB)
    text = text_of(program, language="rapid")
    assert "! tool lid_tool, frame wobj0" in text or "! tool lid_tool, frame base" in text
    assert re.search(r"PROC follow_lid\(\)\s+! lid: 3 points, 200 mm", text)


def test_poses_take_speed_blend_tool_and_frame():
    program = assistant.from_poses(
        LINE,
        unit="m",
        name="seam",
        speed=25,
        blend=2,
        tool=(0, 0, 120),
        frame=(10, 20, 30),
        robot=IRB,
    )
    text = text_of(program, language="rapid")
    assert "[TRUE,[[0,0,120],[1,0,0,0]]" in text
    assert re.search(
        r"PERS wobjdata seam_frame:=\[FALSE,TRUE,\"\",\[\[10,20,30\],\[1,0,0,0\]\]", text
    )
    move = re.search(r"Move[LJ] .*", text)[0]
    assert "seam_tool" in move and "\\WObj:=seam_frame" in move
    (path,) = paths_of(program)
    assert [path.blends[i] for i in path.blend] == [FINE, Blend(2.0), FINE]
    speeds = [path.speeds[i].tcp for i in path.speed]
    assert speeds == [200.0, 25.0, 25.0], "the way to the first pose is no part of the seam"
    assert np.abs(path.positions - [[300, -100, 300], [300, 0, 300], [300, 100, 300]]).max() < 1e-9


def test_tools_and_frames_are_taken_in_every_form():
    tip = SE3(0.0, 0.0, 0.12) * SE3.Ry(90, "deg")
    wanted = Pose.of_matrix(tip.R, 1000.0 * tip.t)
    poses = [Pose.of_matrix(one.R, 1000.0 * one.t) for one in LINE]
    first = assistant.from_poses(LINE, unit="m", tool=tip, frame=tip.A)
    again = assistant.from_poses(poses, tool=wanted, frame=wanted)
    for program in (first, again):
        assert program.tools["path_tool"].tip.matrix == pytest.approx(wanted.matrix)
        assert program.frames["path_frame"].pose.matrix == pytest.approx(wanted.matrix)
    assert [one.positions.tolist() for one in paths_of(first)] == [
        one.positions.tolist() for one in paths_of(again)
    ]
    swing = assistant.from_joints(WAY, unit="rad", robot=IRB, tool=tip)
    assert swing.tools["path_tool"].tip.matrix == pytest.approx(wanted.matrix)


@pytest.mark.parametrize(
    ("code", "given"),
    [
        ("TB438", {"unit": "m", "tool": (0, 0, 0.12)}),
        ("TB438", {"unit": "m", "frame": (0.4, 0, 0.1)}),
        ("TB436", {"unit": "m", "tool": np.zeros((2, 3))}),
        ("TB445", {}),
        ("TB445", {"poses": [Pose()], "tool": SE3()}),
        ("TB413", {"unit": "cm"}),
    ],
)
def test_a_unit_that_may_be_another_is_asked_for(code, given):
    given = {"poses": LINE, **given}
    with pytest.raises(assistant.Refused) as caught:
        assistant.from_poses(given.pop("poses"), **given)
    assert caught.value.findings[0].code == code


def test_tools_by_value_by_name_and_from_a_process_file(tmp_path):
    file = tmp_path / "cell.process.toml"
    file.write_text("[motion]\nspeed = 40\n[tools.tool]\ntip = [0, 0, 50]\n", encoding="utf-8")
    named = assistant.from_poses(LINE, unit="m", tool="TOOL", process=file)
    assert named.tools["tool"].tip.position == (0, 0, 50)
    tool = Tool(Pose((0.0, 0.0, 9.0)))
    both = assistant.from_poses(LINE, unit="m", tool=tool, process=file, blend="fine")
    (path,) = paths_of(both)
    assert both.tools == {path.tools[0]: tool}, "the heading lists only what is used"
    assert path.speeds[0].tcp == 40.0 and set(path.blends) == {FINE}
    with pytest.raises(assistant.Refused, match=r"TB301.*did you mean|TB301.*declare"):
        assistant.from_poses(LINE, unit="m", tool="tol")


def test_a_tool_by_value_brings_its_load():
    tool = assistant.Tool(Pose((0, 0, 120)), assistant.Load(1.5, (0, 0, 60)), free_turn=True)
    program = assistant.from_poses(LINE, unit="m", tool=tool, robot=IRB)
    text = text_of(program, language="rapid")
    assert "[TRUE,[[0,0,120],[1,0,0,0]],[1.5,[0,0,60],[1,0,0,0],0,0,0]]" in text
    assert text_of(program, language="rapid") == text_of(
        assistant.from_poses(LINE, unit="m", tool=replace(tool, tip=(0, 0, 120)), robot=IRB),
        language="rapid",
    )


@pytest.mark.parametrize(
    ("values", "code"),
    [
        ({"tip": "flange"}, "TB436"),
        ({"load": 2.0}, "TB439"),
        ({"load": assistant.Load("2")}, "TB442"),
        ({"load": assistant.Load(-2.0)}, "TB448"),
        ({"load": assistant.Load(2.0, (0.0, 60.0))}, "TB439"),
        ({"load": assistant.Load(2.0, (0.0, float("nan"), 0.0))}, "TB442"),
        ({"load": assistant.Load(2.0, (0, 0, 60), (0, 0, 0, 0))}, "TB439"),
        ({"load": assistant.Load(2.0, (0, 0, 60), inertia=(0, -0.1, 0))}, "TB448"),
    ],
)
def test_a_tool_that_is_wrong_is_refused(values, code):
    tool = replace(assistant.Tool(), **values)
    with pytest.raises(assistant.Refused) as caught:
        assistant.from_poses(LINE, unit="m", tool=tool, robot=IRB)
    assert caught.value.findings[0].code == code


def test_what_should_be_looked_at_is_a_warning_of_python():
    rows = [[300, 0, 300, 1.001, 0, 0, 0], [300, 50, 300, 1.001, 0, 0, 0]]
    with pytest.warns(UserWarning, match="TB2"):
        assistant.from_poses(rows, unit="mm")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assistant.from_poses(LINE, unit="m")


@pytest.mark.parametrize("where", ["from_poses", "compile", "percent"])
def test_the_first_move_gets_the_percentage_that_is_stated(tmp_path, where):
    process = tmp_path / "lab.process.toml"
    process.write_text("joint_percent = 13\n")
    way = [Pose((300 + x, 0, 400), (0, 0, 1, 0)) for x in (0, 10, 20)]
    stated = {"from_poses": {"process": process}, "percent": {"percent": 13}}.get(where, {})
    program = assistant.from_poses(way, speed=80, robot=RV, **stated)
    options = {"process": process} if where == "compile" else {}
    text = text_of(program, language="melfa-basic-5", **options)
    assert re.findall(r"JOvrd (\d+)", text) == ["13"] and re.findall(r"Spd (\d+)", text) == ["80"]


def test_that_of_a_process_file_is_nothing_to_an_arm_that_takes_mm_s(tmp_path):
    process = tmp_path / "lab.process.toml"
    process.write_text("joint_percent = 13\n")
    way = [Pose((400 + x, 0, 400), (0, 0, 1, 0)) for x in (0, 10)]
    program = assistant.from_poses(way, speed=80, robot=IRB, process=process)
    done = assistant.compile(program, language="rapid", process=process)
    assert done.ok and not done.findings


def test_a_process_file_states_the_tool_of_a_program_anew(tmp_path):
    process = tmp_path / "lab.process.toml"
    process.write_text("[tools.path_tool]\ntip = [0, 0, 77]\nmass = 1\ncentre = [0, 0, 40]\n")
    way = [Pose((300 + x, 0, 400), (0, 0, 1, 0)) for x in (0, 10)]
    program = assistant.from_poses(way, robot=IRB, tool=[0, 0, 50])
    assert "[[0,0,77]" in text_of(program, language="rapid", process=process)


def test_the_percentage_of_poses_is_one(tmp_path):
    with pytest.raises(assistant.Refused, match="TB435"):
        assistant.from_poses([Pose((300, 0, 400), (0, 0, 1, 0))], percent=0)


def test_lines_lead_to_the_first_pose_and_away_from_the_last_one() -> None:
    poses = np.zeros((5, 7))
    poses[:, 0], poses[:, 1], poses[:, 2], poses[:, 4] = 500, range(0, 50, 10), 300, 1
    made = assistant.from_poses(
        poses, unit="mm", name="bead", speed=20, travel=90, approach=40, retract=60
    )
    main, bead = made.procedures
    first, _, last = main.body
    assert isinstance(first, Move) and isinstance(last, Move)
    assert (first.kind, first.motion.speed, first.motion.blend) == ("joint", Speed(90.0), FINE)
    assert (last.kind, last.motion.speed, last.motion.blend) == ("linear", Speed(90.0), FINE)
    (path,) = (one.path for one in bead.body if isinstance(one, Follow))
    assert set(path.kinds.tolist()) == {Kind.LINEAR} and path.speeds[path.speed[0]] == Speed(20.0)
    # The tool points down, against its own z axis.
    assert made.targets["bead_approach"].pose.position == pytest.approx((500, 0, 340))
    assert made.targets["bead_retract"].pose.position == pytest.approx((500, 40, 360))


@pytest.mark.parametrize("key", ["approach", "retract"])
def test_lengths_of_ways_are_not_negative(key: str) -> None:
    with pytest.raises(Refused, match="must not be negative"):
        assistant.from_poses([Pose((500.0, 0.0, 300.0))] * 2, unit="mm", **{key: -1.0})
