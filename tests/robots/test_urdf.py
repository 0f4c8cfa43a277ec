"""Robots from URDF files: the chain, its closed form, and what is told of a wrong file."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import compile, robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused, Unreadable
from assistant.program.expressions import TargetValue
from assistant.program.geometry import Pose, Target
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Motion, Move
from assistant.robots import Robot, robot_file
from assistant.robots.arms import Placed, Serial
from tests.examples import drawn

LIMIT = '<limit lower="-2.5" upper="2.5" velocity="3.0" effort="1"/>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inner: str = LIMIT) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inner}</joint>'


def urdf(*joints: str, extra: str = "") -> str:
    """A robot of the joints, links made of the names that they use."""
    text = "".join(joints)
    links = dict.fromkeys(
        part.split('"')[0]
        for key in ("parent", "child")
        for part in text.split(f'<{key} link="')[1:]
    )
    return f'<robot name="own">{"".join(f"<link name={n!r}/>" for n in links)}{text}{extra}</robot>'


def moved(xyz: str, axis: str, rpy: str = "0 0 0") -> str:
    return f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{LIMIT}'


def jointed(*parts: tuple[str, str, str], tip: str = "") -> str:
    """A chain of turning joints, each with its xyz, axis and rpy."""
    rows = [
        joint(f"j{i}", f"l{i - 1}", f"l{i}", inner=moved(*part)) for i, part in enumerate(parts, 1)
    ]
    return urdf(*rows, tip)


WRISTED = jointed(
    ("0 0 0.3991", "0 0 1", "0 0 0"),
    ("0 0 0", "0 1 0", "0 0 0"),
    ("0 0 0.35", "0 1 0", "0 0 0"),
    ("0 0 0.042", "1 0 0", "0 0 0"),
    ("0.351 0 0", "0 1 0", "0 0 0"),
    ("0.082 0 0", "1 0 0", "0 0 0"),
    tip=joint("tip", "l6", "tool0", "fixed", '<origin rpy="0 1.570796 0"/>'),
)
OFFSET = jointed(  # axes 2, 3 and 4 parallel, and no point where 4, 5 and 6 meet
    ("0 0 0.09", "0 0 1", "0 0 0"),
    ("0 0.13 0", "0 0 1", "1.570796 0 0"),
    ("-0.42 0 0", "0 0 1", "0 0 0"),
    ("-0.39 0 0", "0 0 1", "0 0 0"),
    ("0 0 0.11", "0 0 1", "1.5708 0 0"),
    ("0 0 0.09", "0 0 1", "-1.5707 0 0"),
)


def read(text: str) -> Robot:
    return robot_file.read(text.encode(), "own.urdf")


def random_joints(robot: Robot, n: int) -> np.ndarray:
    low, high = robot.limits.T
    return np.random.default_rng(5).uniform(low, high, (n, len(low)))


def same_poses(left: tuple, right: tuple) -> bool:
    far = np.abs(left[0] - right[0]).max()
    return bool(far < 1e-7 and rotations.angle_between(left[1], right[1]).max() < 1e-5)


def test_an_arm_of_the_catalogue_is_recognised() -> None:
    robot, known = read(WRISTED), robots.get("irb1200-7-0.7")
    assert isinstance(robot.arm, Placed)
    joints = random_joints(known, 200)
    assert robot.fk(joints)[0] == pytest.approx(known.fk(joints)[0], abs=1e-9)
    assert np.abs(robot.fk(joints)[1] - known.fk(joints)[1]).max() < 1e-12
    assert robot.configuration(joints).tolist() == known.configuration(joints).tolist()
    assert robot.limits == pytest.approx(np.tile(np.degrees([-2.5, 2.5]), (6, 1)))
    assert robot.speeds == pytest.approx(np.degrees(3.0))
    assert robot.payload is None and robot.tcp_speed is None


def test_a_command_takes_the_file_where_it_takes_a_name(tmp_path) -> None:
    file = tmp_path / "own.urdf"
    file.write_text(WRISTED, encoding="utf-8")
    pose = Pose((450.0, 120.0, 400.0), (0.0, 0.0, 1.0, 0.0))
    move = Move("joint", TargetValue(Target(pose)), Motion(Speed(100.0), FINE))
    source = Program("part", (Procedure("main", (move,)),))
    done = compile(source, language="rapid", robot=str(file))
    known = compile(source, language="rapid", robot="irb1200-7-0.7")
    assert done.ok
    assert [f.code for f in done.findings] == ["RB008"]
    (text,), (expected,) = done.files.values(), known.files.values()
    assert text.replace(b"own", b"irb1200-7-0.7") == expected


signs = st.sampled_from([1, -1])
lengths = st.integers(50, 900)


@settings(max_examples=drawn(25), deadline=None)
@given(st.data())
def test_any_arm_with_a_spherical_wrist_is_recognised(data) -> None:
    """Joints turned either way and by some zero, on a base and with a flange of any pose."""
    d1, a2, d4 = (data.draw(lengths) for _ in range(3))
    a1, a3, d6 = (data.draw(st.integers(-200, 200)) for _ in range(3))
    ways = [data.draw(signs) for _ in range(4)]
    ways = [*ways[:3], ways[3], data.draw(signs), ways[3]]
    zeros = [data.draw(st.floats(-1.5, 1.5)) for _ in range(4)]
    angles = [data.draw(st.floats(-3, 3)) for _ in range(3)]
    base = [data.draw(st.integers(-500, 500)) / 1000 for _ in range(3)]
    tail = "0.01 0.02 0.03" if data.draw(st.booleans()) else "0 0 0"
    metres = [v / 1000 for v in (a1, d1, a2, a3, d4)]
    rows = [
        joint("b", "world", "l0", "fixed", origin(base, angles)),
        turning(1, "0 0 {}", ways[0], (0, 0, 0), (0, 0, zeros[0])),
        turning(2, "0 {} 0", ways[1], (metres[0], 0, metres[1]), (0, zeros[1], 0)),
        turning(3, "0 {} 0", ways[2], (0, 0, metres[2]), (0, zeros[2], 0)),
        turning(4, "0 0 {}", ways[3], (metres[3], 0, metres[4]), (0, 0, zeros[3])),
        turning(5, "0 {} 0", ways[4], (0, 0, 0), (0, 0, 0)),
        turning(6, "0 0 {}", ways[5], (0, 0, 0), (0, 0, 0)),
        joint("f", "l6", "flange", "fixed", f'<origin xyz="0 0 {d6 / 1000}"/>'),
        joint("t", "flange", "tool0", "fixed", f'<origin xyz="{tail}" rpy="{tail}"/>'),
    ]
    robot = read(urdf(*rows))
    assert isinstance(robot.arm, Placed)
    joints = random_joints(robot, 20)
    poses = robot.fk(joints)
    assert same_poses(poses, robot.arm.chain.fk(np.radians(joints)))
    found, valid = robot.ik(*poses)
    away = np.where(valid, np.abs(found - joints[:, None]).max(axis=2), np.inf).min(axis=1)
    assert away.max() < 1e-4
    back = robot.joints_of(*poses, robot.configuration(joints))
    assert back == pytest.approx(joints, abs=1e-4)
    assert robot.chain(joints)[:, -1] == pytest.approx(poses[0])


def origin(xyz, rpy) -> str:
    words = [" ".join(repr(float(v)) for v in values) for values in (xyz, rpy)]
    return f'<origin xyz="{words[0]}" rpy="{words[1]}"/>'


def turning(number: int, axis: str, way: int, xyz, rpy) -> str:
    inner = f'{origin(xyz, rpy)}<axis xyz="{axis.format(way)}"/>{LIMIT}'
    return joint(f"j{number}", f"l{number - 1}", f"l{number}", inner=inner)


def test_forward_kinematics_of_roboticstoolbox_agree() -> None:
    for text in (WRISTED, OFFSET):
        robot = read(text)
        other, joints = robot.to_rtb(), random_joints(robot, 20)
        there = np.stack([pose.A for pose in map(other.fkine, np.radians(joints))])
        p, q = robot.fk(joints)
        assert p / 1000.0 == pytest.approx(there[:, :3, 3], abs=1e-12)
        assert np.abs(rotations.to_matrix(q) - there[:, :3, :3]).max() < 1e-9
        assert other.qlim == pytest.approx(np.radians(robot.limits.T))


def test_an_arm_without_a_closed_form_is_a_chain() -> None:
    robot = read(OFFSET)
    assert isinstance(robot.arm, Serial)
    (finding,) = robot.findings
    assert finding.code == "RB008" and finding.severity == "info"
    for part in ("`l6`", "solved numerically", "1.5708"):
        assert part in finding.message


def test_poses_along_a_chain_by_hand() -> None:
    """A column that slides up 0.2 m, and an arm of 0.5 m that turns about it."""
    slide = '<axis xyz="0 0 2"/><limit lower="0" upper="0.4" velocity="0.25"/>'
    turn = '<origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>' + LIMIT
    robot = read(
        urdf(
            joint("up", "base", "column", "prismatic", slide),
            joint("turn", "column", "arm", "revolute", turn),
            joint("end", "arm", "flange", "fixed", '<origin xyz="0.5 0 0"/>'),
        )
    )
    assert robot.units == ("mm", "degrees")
    assert robot.limits[0] == pytest.approx([0, 400])
    assert robot.speeds[0] == pytest.approx(250)
    p, q = robot.fk([[200, 0], [50, 90]])
    assert p == pytest.approx(np.array([[500, 0, 300], [0, 500, 150]]))
    assert q[1] == pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])


def test_the_flange_is_the_link_of_that_name_else_the_longest_chain() -> None:
    arm = [joint(f"j{i}", f"l{i - 1}", f"l{i}", inner=moved("0 0 0.1", "0 1 0")) for i in (1, 2, 3)]
    aside = joint("eye", "l1", "camera", "fixed", '<origin xyz="9 0 0"/>')
    assert read(urdf(*arm, aside)).arm.joints[-1].pose.position[2] == pytest.approx(100)
    assert len(read(urdf(*arm, aside)).axes) == 3
    hand = joint("hand", "l3", "finger", inner=moved("0 0 0.1", "1 0 0"))
    named = joint("end", "l3", "arm_tool0", "fixed", '<origin xyz="0 0 0.05"/>')
    assert len(read(urdf(*arm, hand)).axes) == 4
    robot = read(urdf(*arm, hand, named))
    assert len(robot.axes) == 3
    assert robot.fk([[0, 0, 0]])[0][0] == pytest.approx([0, 0, 350])


@pytest.mark.slow
def test_a_file_of_very_many_links_is_read() -> None:
    held = [joint(f"f{i}", f"m{i}", f"m{i + 1}", "fixed", "") for i in range(20000)]
    side = [joint(f"s{i}", "m0", f"t{i}", "fixed", "") for i in range(5000)]
    robot = read(urdf(joint("j", "base", "m0"), *held, *side))
    assert robot.arm.axes == ("J1",)
    assert "`m20000`" in robot.findings[0].message


def test_a_name_that_no_program_carries_is_only_the_title(tmp_path) -> None:
    text = WRISTED.replace('name="own"', 'name="My &#10; Arm: ü/2"')
    assert (read(text).name, read(text).title) == ("My-Arm-2", "My Arm: ü/2")
    file = tmp_path / "arm.urdf"
    file.write_text(text, encoding="utf-8")
    program = tmp_path / "way.pseudo"
    program.write_text(
        "program way\n\ntarget a [400, 0, 400] [0, 0, 1, 0]\n\n"
        "procedure main\n  move joint a speed 100 mm/s blend fine\nend\n",
        encoding="utf-8",
    )
    compiled = compile(str(program), language="rapid", robot=str(file))
    assert "robot: My-Arm-2" in next(iter(compiled.files.values())).decode()


def test_an_axis_without_end_gets_turns() -> None:
    endless = '<axis xyz="0 0 1"/><limit velocity="1"/>'
    robot = read(urdf(joint("spin", "a", "b", "continuous", endless)))
    assert robot.limits[0] == pytest.approx([-360, 360])
    assert "spin" in robot.findings[0].message


ARM = '<axis xyz="0 0 1"/>' + LIMIT


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (urdf(joint("j", "a", "b", "hinge")), "RB007", "`hinge` is none of"),
        (urdf(joint("j", "a", "b", "")), "RB007", "has no type"),
        (urdf(joint("", "a", "b")), "RB007", "has no name"),
        (urdf(joint("j", "a", "b", inner=ARM.replace("0 0 1", "0 0 0"))), "RB007", "length 0"),
        (urdf(joint("j", "a", "b", inner=ARM.replace("0 0 1", "0 1"))), "RB007", "three numbers"),
        (urdf(joint("j", "a", "b", inner=ARM.replace("0 0 1", "0 0 nan"))), "RB007", "three"),
        (urdf(joint("j", "a", "b", inner=moved("1e300 0 0", "0 0 1"))), "RB007", "up to 1e+06"),
        (urdf(*(joint(f"j{i}", f"l{i}", f"l{i + 1}") for i in range(40))), "RB007", "40 axes"),
        (urdf(joint("j", "a", "b", inner=ARM.replace('"2.5"', '"x"'))), "RB007", "upper `x`"),
        (urdf(joint("j", "a", "b", inner=ARM.replace('"2.5"', '"-3"'))), "RB007", "not below"),
        (urdf(joint("j", "a", "b", inner="")), "RB007", "has no <limit> lower and upper"),
        (urdf(joint("j", "a", "b", inner=ARM.replace("3.0", "0"))), "RB007", "velocity above 0"),
        (urdf(joint("j", "a", "b", "floating", "")), "RB007", "no joint that moves"),
        (urdf(joint("j", "a", "b"), joint("k", "b", "c", "planar", "")), "RB007", "is planar"),
        (
            urdf(joint("j", "a", "b"), joint("k", "b", "c", inner=ARM + '<mimic joint="j"/>')),
            "RB007",
            "follows another joint",
        ),
        (urdf(joint("j", "a", "b"), joint("k", "c", "b")), "RB007", "as does joint `j`"),
        (urdf(joint("j", "a", "b"), joint("j", "b", "c")), "RB007", "stands there twice"),
        (urdf(joint("j", "a", "b"), joint("k", "c", "d")), "RB007", "2 links that no joint"),
        (urdf(joint("j", "a", "b"), joint("k", "b", "a")), "RB007", "it is a circle"),
        (
            urdf(joint("i", "o", "p"), joint("j", "a", "b"), joint("k", "b", "a")),
            "RB007",
            "hangs on itself",
        ),
        (urdf(joint("j", "a", "b")).replace("<link name='b'/>", ""), "RB007", "is not there"),
        (urdf(), "RB007", "has 0 links"),
        ("<robot name='x'>", "RB004", "no element found"),
        ("<sdf/>", "RB004", "its root is <sdf>"),
        ("<robot><link name='${prefix}a'/></robot>", "RB006", "${prefix}a"),
        ("<robot xmlns:xacro='x'><xacro:include filename='y'/></robot>", "RB006", "xacro:include"),
        ("<!DOCTYPE robot [<!ENTITY a 'b'>]><robot>&a;</robot>", "RB005", "document type"),
        ("<robot>" + "<a>" * 200, "RB004", "too deep"),
        ('<?xml version="1.0" encoding="utf-7"?><robot/>', "RB004", "multi-byte"),
        ('<?xml version="1.0" encoding="none"?><robot/>', "RB004", "unknown encoding"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(text: str, code: str, words: str) -> None:
    with pytest.raises(Refused) as refused:
        read(text)
    finding = refused.value.findings[0]
    assert finding.code == code
    assert words in finding.message
    assert finding.path == "own.urdf" and finding.line == 1


def test_a_line_is_named() -> None:
    text = urdf(joint("j", "a", "b"), "\n\n  " + joint("k", "b", "c", "screw"))
    with pytest.raises(Refused) as refused:
        read(text)
    (finding,) = refused.value.findings
    assert (finding.line, finding.column) == (3, 3)
    assert "joint `k`" in finding.message


def test_a_file_in_utf_16_cannot_hide_a_document_type() -> None:
    with pytest.raises(Unreadable):
        robot_file.read("<!DOCTYPE robot><robot/>".encode("utf-16"), "own.urdf")


def test_a_toml_beside_it_says_the_rest(tmp_path) -> None:
    (tmp_path / "arm.urdf").write_text(OFFSET.replace('velocity="3.0"', ""), encoding="utf-8")
    speeds = "\n".join(f"J{i} = {{ speed = {100 + i} }}" for i in range(1, 6))
    file = tmp_path / "arm.toml"
    file.write_text(
        'urdf = "arm.urdf"\ntitle = "Own arm"\nlanguages = ["rapid"]\npayload_kg = 5\n'
        f"[axes_deg]\n{speeds}\nJ6 = {{ limits = [10, 20], speed = 7, home = 15 }}\n"
    )
    robot = robots.load(file)
    assert (robot.name, robot.title, robot.payload) == ("own", "Own arm", 5)
    assert robot.languages == ("rapid",)
    assert robot.speeds.tolist() == [101, 102, 103, 104, 105, 7]
    assert robot.limits[5].tolist() == [10, 20] and robot.home[5] == 15
    assert robot.limits[0] == pytest.approx(np.degrees([-2.5, 2.5]))
    assert robot.findings == ()


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("payload_kg = 0", "payload_kg"),
        ('arm = "scara"', "arm"),
        ("lengths_mm = { d1 = 3 }", "lengths_mm"),
        ("axes_deg = { J7 = { limits = [0, 1], speed = 1 } }", "axes_deg"),
        ("axes_deg = { J6 = { limits = [1, 0] } }", "axes_deg.J6.limits"),
        ("axes_deg = { J6 = { limits = [10, 20] } }", "axes_deg.J6.home"),
        ("axes_deg = { J6 = 3 }", "axes_deg.J6"),
        ("axes_mm = 3", "axes_mm"),
    ],
)
def test_a_toml_that_contradicts_it(tmp_path, text: str, field: str) -> None:
    (tmp_path / "arm.urdf").write_text(OFFSET, encoding="utf-8")
    file = tmp_path / "arm.toml"
    file.write_text(f'urdf = "arm.urdf"\n{text}\n')
    with pytest.raises(Refused) as refused:
        robots.load(file)
    assert field in {finding.place for finding in refused.value.findings}


def test_a_urdf_that_is_not_there(tmp_path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text('urdf = "none.urdf"')
    with pytest.raises(Unreadable) as refused:
        robots.load(file)
    assert "none.urdf" in refused.value.findings[0].message
