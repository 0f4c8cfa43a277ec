"""What a robot makes of a program's moves: each rule finds its fault, and only that."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import assistant
from assistant import checks, robots
from assistant.base.diagnostics import Span
from assistant.program.expressions import JointValue, Name, Number, TargetValue
from assistant.program.geometry import JointTarget, Load, Pose, Target, Tool
from assistant.program.motion import (
    FINE,
    UNSTATED,
    Blend,
    Kind,
    Path,
    Speed,
    configuration_of,
)
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow, Motion, Move, MoveJoints, SetOverride, Statement
from tests.examples import drawn

ARM = robots.get("irb1200-7-0.7")
MELFA = robots.get("rv-4frl")
SCARA = robots.get("rh-6frh5520")
DOWN = (0.0, 0.0, 1.0, 0.0)
SLOW = Speed(100.0)


def found(*body: Statement, arm=ARM, cycle: float | None = None, **parts):
    program = Program("p", (Procedure("main", body),), **parts)
    solution = robots.solve_program(program, arm)
    assert not [f for f in solution.findings if f.severity == "error"], solution.findings
    return checks.with_robot(solution, cycle=cycle)


def codes(*body: Statement, **parts) -> list[str]:
    return [finding.code for finding in found(*body, **parts)]


def seam(positions, quaternions=None, *, speed=SLOW, blend=FINE, **columns) -> Follow:
    positions = np.atleast_2d(np.asarray(positions, dtype=float))
    turned = np.tile(DOWN, (len(positions), 1)) if quaternions is None else quaternions
    return Follow(Path.of("seam", positions, turned, speeds=[speed], blends=[blend], **columns))


def tilted(degrees: float, about: str = "y") -> tuple[float, float, float, float]:
    """Tool down, turned about an axis of the base."""
    half = math.radians(degrees) / 2.0
    turn = Pose((0, 0, 0), (math.cos(half), *(math.sin(half) * (axis == about) for axis in "xyz")))
    return (turn @ Pose((0, 0, 0), DOWN)).quaternion


def line(*points, **parts) -> Follow:
    return seam(points, **parts)


# ---------------------------------------------------------------------------- sound programs

SOUND = {
    "a line": line((400, -100, 300), (400, 100, 300)),
    "stops": line((400, 0, 300), (400, 10, 300), (400, 10, 310), speed=Speed(1000.0)),
    "a dense seam": line(*((400, y, 300) for y in range(-100, 101, 2)), blend=Blend(0.9)),
    "an arc": line((400, -50, 300), (450, 0, 300), (400, 50, 300), kinds=[1, 2, 3]),
    "joint moves": line((400, 300, 300), (400, -300, 300), kinds=Kind.JOINT, speed=Speed(9000.0)),
    "external axes": line((400, 0, 300), (400, 9, 300), external=[10, 20, *[math.nan] * 4]),
}


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.parametrize("arm", [ARM, MELFA], ids=lambda arm: arm.name)
def test_sound_moves_have_no_finding(name, arm):
    assert codes(SOUND[name], arm=arm) == []


# -------------------------------------------------------------------------- singularities


def test_a_move_near_the_wrist_singularity_is_told_of_once_for_all_neighbours():
    """The forearm is level at J3 = 0 and the tool held along it but for so many degrees."""
    joints = [[0, 0, 0, 0, five, 0] for five in (20, 10, 2, 1.5, 2.5, 10, 20)]
    (finding,) = found(seam(*ARM.fk(joints), configurations=ARM.configuration(joints)))
    assert (finding.code, finding.severity) == ("CK301", "info")
    assert "1.5 degrees" in finding.message
    assert "(worst at seam_4)" in finding.message
    assert finding.place == "seam: 4 of 7 targets (seam_3 to seam_6)"


def test_what_the_robot_tells_of_the_wrist_is_not_told_twice():
    joints = [[0, 20, 20, 0, 15, 0], [0, 20, 20, 0, -15, 0]]
    stated = ARM.configuration(joints)
    stated[1, 0] = UNSTATED
    path = seam(*ARM.fk(joints), configurations=stated)
    program = Program("p", (Procedure("main", (path,)),))
    solution = robots.solve_program(program, ARM)
    assert [f.code for f in solution.findings] == ["RB115"]
    assert checks.with_robot(solution) == ()


def test_a_wrist_that_goes_through_and_back_between_the_ends():
    """The nearer to axis 1, the steeper the forearm that a tool pointing down is at the end of."""
    ends = [(225.0, -150.0, 240.0), (225.0, 150.0, 240.0)]
    middle, _ = ARM.ik([(225.0, 0.0, 240.0)], [DOWN])
    first, _ = ARM.ik(ends[:1], [DOWN])
    assert (first[0, 0, 4], middle[0, 0, 4] > 0) == (pytest.approx(4.0, abs=3.9), True)
    (finding,) = found(line(*ends, speed=Speed(20.0)))
    assert (finding.code, finding.severity) == ("CK304", "warning")


@pytest.mark.parametrize(
    ("name", "turn", "codes"),
    [
        ("rv-4frl", 180.0, ["CK305"]),
        ("rv-4frl", -179.98, ["CK305"]),
        ("rv-4frl", 179.0, []),
        ("rv-4frl", 0.0, []),
        ("irb1200-7-0.7", 180.0, []),
    ],
)
def test_a_joint_move_to_where_another_turn_begins(name, turn, codes):
    arm = robots.get(name)
    elbow = arm.home[2] + 20.0
    joints = np.array([[0, 20, elbow, 0, 50, at] for at in (0.0, turn)], dtype=float)
    p, q = arm.fk(joints)
    targets = [
        TargetValue(Target(Pose.of(p[at], q[at]), configuration_of(row)))
        for at, row in enumerate(arm.configuration(joints))
    ]
    motion = Motion(SLOW, FINE)
    for kind, expected in (("joint", codes), ("linear", [])):
        body = Move("joint", targets[0], motion), Move(kind, targets[1], motion)
        assert [f.code for f in found(*body, arm=arm) if f.code == "CK305"] == expected


def bent(arm, elbow: float):
    """Joints with the elbow so many degrees from stretched, the wrist well bent."""
    joints = np.array(arm.home)
    tilt = math.degrees(math.atan2(arm.lengths.a3, arm.lengths.d4))
    joints[2] = elbow - tilt - arm.zero[2]
    joints[1], joints[-2] = 40.0, 60.0
    return joints


@pytest.mark.parametrize("name", ["irb1200-7-0.7", "rv-4frl", "rv-2aj", "irb4600-20-2.50"])
@pytest.mark.parametrize(("elbow", "expected"), [(2.0, ["CK302"]), (6.0, [])])
def test_an_elbow_that_comes_near_to_stretched(name, elbow, expected):
    arm = robots.get(name)
    p, q = arm.fk([bent(arm, 30.0), bent(arm, elbow)])
    told = found(seam(p, q, speed=Speed(1.0, 1.0)), arm=arm)
    assert [f.code for f in told] == expected
    if told:
        assert "2.0 degrees" in told[0].message


@pytest.mark.parametrize(("aside", "expected"), [(15.0, ["CK303"]), (60.0, [])])
def test_a_wrist_centre_that_passes_axis_1(aside, expected):
    """Level above the arm, tool upwards: the wrist centre goes past axis 1."""
    up = (1.0, 0.0, 0.0, 0.0)
    ends = [(aside, -200.0, 950.0), (aside, 200.0, 950.0)]
    told = found(seam(ends, [up, up], speed=Speed(5.0)))
    assert [f.code for f in told if f.code == "CK303"] == expected
    assert not told or "15 mm" in told[0].message


def test_a_scara_with_its_arm_stretched():
    p, q = SCARA.fk([[0, 30, 200, 0], [0, 2, 200, 0]])
    assert codes(seam(p, q, speed=Speed(1.0)), arm=SCARA) == ["CK302"]


def test_joint_moves_pass_singularities_unharmed():
    p, q = ARM.fk([[0, 20, 20, 0, 1, 0], [0, 20, 20, 0, -1, 0], [0, 10, 20, 0, 0.5, 0]])
    assert codes(seam(p, q, kinds=Kind.JOINT)) == []


# --------------------------------------------------------------------------- joint speeds


@settings(max_examples=drawn(100))
@given(st.floats(30.0, 150.0), st.floats(1.2, 5.0), st.sampled_from([ARM, MELFA, SCARA]))
def test_a_joint_that_is_too_fast_by_its_part(angle, times, arm):
    """A turn on the spot about axis 6, or axis 4 of a SCARA, at a multiple of its speed."""
    start = np.array(arm.home)
    start[-1] -= angle / 2.0
    end = np.array(start)
    end[-1] += angle
    p, q = arm.fk([start, end])
    limit = arm.speeds[-1]
    assume(angle / limit > 0.12)
    told = found(seam(p, q, speed=Speed(100.0, limit * times)), arm=arm)
    assert [f.code for f in told] == ["CK311"]
    assert told[0].severity == "warning"
    assert told[0].message.startswith(f"{arm.axes[-1]} would have to move at ")
    assert f" {limit * times:.0f} degrees/s, its limit is {limit:g}" in told[0].message
    assert f"; {limit:.3g} degrees/s of reorientation is possible" in told[0].cure
    slower = found(seam(p, q, speed=Speed(100.0, limit * 0.99)), arm=arm)
    assert [f.code for f in slower] == []


@settings(max_examples=drawn(100))
@given(st.floats(250.0, 600.0), st.floats(0.0, 60.0))
def test_the_speed_that_is_possible_is_possible(radius, turn):
    """Along an arc about axis 1 that axis turns evenly: the limit is its speed times the radius."""
    low, high = (math.radians(a) for a in (-80.0 + turn, 80.0 + turn))
    middle = (low + high) / 2.0
    points = [(radius * math.cos(a), radius * math.sin(a), 400.0) for a in (low, middle, high)]
    assume(ARM.ik(points, [DOWN] * 3)[1].any(axis=1).all())
    turned = [Pose((0, 0, 0), tilted(math.degrees(a), "z")).quaternion for a in (low, middle, high)]
    most = math.radians(ARM.speeds[0]) * radius

    def told(speed: float):
        path = seam(points, turned, kinds=[1, 2, 3], speed=Speed(speed, 5000.0), blend=FINE)
        return [f for f in found(path) if f.code == "CK311"]

    assert told(0.95 * most) == []
    (finding,) = told(1.5 * most)
    assert finding.message.startswith("J1 ")
    possible = float(finding.cure.split("; ")[1].split(" mm/s")[0])
    assert possible == pytest.approx(most, rel=0.02)


def test_a_peak_between_the_ends_counts():
    """Past axis 1 at 40 mm its axis turns fastest in the middle of the way."""
    up = (1.0, 0.0, 0.0, 0.0)
    ends = [(40.0, -250.0, 900.0), (40.0, 250.0, 900.0)]
    peak = math.degrees(500.0 / 40.0)
    told = [f for f in found(seam(ends, [up, up], speed=Speed(500.0))) if f.code == "CK311"]
    needed = float(told[0].message.split(" at ")[1].split(" degrees")[0])
    assert needed == pytest.approx(peak, rel=0.1)
    slow = 0.9 * 500.0 * ARM.speeds[0] / peak
    told = found(seam(ends, [up, up], speed=Speed(slow)))
    assert [f.code for f in told if f.code == "CK311" and f.message.startswith("J1")] == []


def test_a_short_move_between_stops_never_gets_that_fast():
    p, q = ARM.fk([[0, 20, 20, 0, 30, 0], [0, 20, 20, 0, 30, 40]])
    turn = Speed(100.0, 2000.0)
    assert codes(seam(p, q, speed=turn)) == []
    many = [ARM.fk([[0, 20, 20, 0, 30, angle]]) for angle in range(-300, 300, 40)]
    p, q = (np.concatenate([pose[i] for pose in many]) for i in (0, 1))
    assert codes(seam(p, q, speed=turn)) == []
    assert codes(seam(p, q, speed=turn, blend=Blend(1.0))) == ["CK311"]


def test_an_override_slows_the_moves_below_it():
    p, q = ARM.fk([[0, 20, 20, 0, 30, -90], [0, 20, 20, 0, 30, 90]])
    path = seam(p, q, speed=Speed(100.0, 1000.0))
    assert codes(path) == ["CK311"]
    assert codes(SetOverride(Number(50)), path) == []
    assert codes(path, SetOverride(Number(50))) == ["CK311"]
    assert codes(SetOverride(Name("percent")), path) == ["CK311"]


def test_the_way_from_a_joint_target_counts():
    joints = JointTarget((0.0, 20.0, 20.0, 0.0, 30.0, -90.0))
    p, q = ARM.fk([[0, 20, 20, 0, 30, 90]])
    end = TargetValue(Target(Pose.of(p[0], q[0])))
    fast = Motion(Speed(100.0, 1000.0), FINE)
    start = MoveJoints(JointValue(joints), fast)
    assert codes(start, Move("linear", end, fast)) == ["CK311"]
    assert codes(Move("linear", end, fast)) == []


# ----------------------------------------------------------------------- reorientations


def test_a_turn_that_takes_longer_than_the_way():
    p, q = ARM.fk([[0, 20, 20, 0, 30, -45], [0, 20, 20, 0, 30, 45]])
    p[1] += (0.0, 20.0, 0.0)
    (finding,) = found(seam(p, q, speed=Speed(100.0, 90.0)))
    assert (finding.code, finding.severity) == ("CK312", "info")
    assert "the TCP moves at 20 mm/s instead of 100" in finding.message
    assert codes(seam(p, q, speed=Speed(15.0, 90.0))) == []
    assert "CK312" not in codes(seam(p, q, speed=Speed(-5.0, -5.0)))
    p[1] = p[0]  # on the spot no speed of the TCP is meant
    assert codes(seam(p, q, speed=Speed(100.0, 90.0))) == []


# ------------------------------------------------------------------------------- corners


@settings(max_examples=drawn(100))
@given(st.floats(5.0, 60.0), st.floats(0.1, 1.5))
def test_corners_against_the_way_to_the_next_target(way, part):
    assume((part < 0.5 or (part - 0.5) * way > 0.3) and abs(part - 1.0) > 0.02)
    points = [(400, -110, 300), (400, 110, 300), (400 + way, 110, 300), (400 + way, -110, 300)]
    blend = Blend(part * way)
    told = found(line(*points, blend=blend))
    expected = [] if part < 0.5 else ["CK321"] if part < 1.0 else ["CK322"]
    assert [f.code for f in told] == expected
    assert all(f"{way:.3g} mm" in f.message and f"{way / 2.0:.3g} mm" in f.message for f in told)
    assert all(f.severity == "info" for f in told)


def test_corners_that_are_left_to_the_controller_are_not_told_of():
    points = [(400 + y % 20, y, 300) for y in range(0, 50, 10)]
    assert codes(line(*points, blend=Blend(math.inf))) == []
    assert codes(line(*points, blend=Name("z_glue"))) == []
    assert codes(line(*points, blend=Name("Z_GLUE")), blends={"z_glue": Blend(8.0)}) == ["CK321"]


def test_the_way_of_an_arc_is_its_length():
    points = [(400, 0, 300), (400, 80, 300), (410, 90, 300), (420, 80, 300), (420, 0, 300)]
    path = line(*points, kinds=[1, 1, 2, 3, 1], blend=Blend(15.0))
    assert codes(path) == []  # half of 31.4 mm, and it goes on straight


def test_large_corners_of_a_dense_path_that_goes_straight_are_meant_as_no_stop():
    points = [(400 + 0.01 * y * y, y, 300) for y in range(-20, 20)]
    assert codes(line(*points, blend=Blend(100.0))) == []
    zigzag = [(400 + 3 * (y % 2), y, 300) for y in range(-20, 20)]
    (finding,) = found(line(*zigzag, blend=Blend(100.0)))
    assert (finding.code, finding.place) == ("CK322", "seam: 38 of 40 targets (seam_2 to seam_39)")


# -------------------------------------------------------------------------------- cycles


@pytest.mark.parametrize(("speed", "expected"), [(200.0, []), (300.0, ["CK323"])])
def test_targets_that_are_passed_faster_than_places_are_commanded(speed, expected):
    points = [(400, y, 300) for y in range(20)]
    assert codes(line(*points, speed=Speed(speed), blend=Blend(0.3))) == expected
    assert codes(line(*points[:9], speed=Speed(speed), blend=Blend(0.3))) == []
    assert codes(line(*points, speed=Speed(speed), blend=FINE)) == []
    assert codes(line(*points, speed=Speed(speed), blend=Blend(0.3)), cycle=0.001) == []


# --------------------------------------------------------------------------------- loads


def with_tool(mass: float | None, *, arm=ARM, held: bool = True, used: bool = True):
    load = None if mass is None else Load(mass, (0, 0, 50))
    motion = Motion(Speed(100.0), FINE, "gripper" if used else "tool0")
    target = TargetValue(Target(Pose((0.7 * arm.reach, 0, 400), DOWN)))
    body = Move("joint", target, motion)
    return codes(body, arm=arm, tools={"gripper": Tool(Pose(), load, held)})


def test_tools_without_weight_and_too_heavy_ones():
    assert with_tool(0.0) == ["CK331"]
    assert with_tool(0.0, arm=MELFA) == []
    assert with_tool(9.0) == ["CK332"]
    assert with_tool(9.0, arm=robots.get("irb1600-10-1.45")) == []
    assert with_tool(0.001) == with_tool(7.0) == with_tool(None) == []
    assert with_tool(0.0, used=False) == []
    assert with_tool(0.0, held=False) == []


# ------------------------------------------------------------------------- external axes


def test_an_external_axis_that_some_targets_leave_out():
    columns = np.full((6, 6), np.nan)
    columns[:, 0] = 10.0
    points = [(400, 10 * y, 300) for y in range(6)]
    assert codes(line(*points, external=columns)) == []
    columns[2:4, 0] = np.nan
    (finding,) = found(line(*points, external=columns))
    assert (finding.code, finding.severity) == ("CK341", "warning")
    assert finding.message.startswith("the value of external axis 1 is missing")
    assert finding.place == "seam: 2 of 6 targets (seam_3, seam_4)"


# ------------------------------------------------- what the solution tells, and tells alone


def test_unknown_tools_and_frames_are_told_of_once():
    target = TargetValue(Target(Pose((400, 0, 300), DOWN)))
    move = Move("linear", target, Motion(Speed(100.0), FINE, "gripper", "table"))
    program = Program("p", (Procedure("main", (move,)),))
    solution = robots.solve_program(program, ARM)
    assert [f.code for f in solution.findings] == ["RB111", "RB111"]
    assert checks.with_robot(solution) == ()


@pytest.mark.parametrize("kinds", [[1, 1], [1, 2, 3]])
def test_stated_branches_that_differ_at_the_ends_are_told_of(kinds):
    joints = np.array(
        [[0, 20, 20, 0, 40, 0], [5, 20, 20, 180, -40, 180], [10, 20, 20, 180, -40, 180]]
    )
    joints = joints[: len(kinds)]
    p, q = ARM.fk(joints)
    path = seam(p, q, kinds=kinds, configurations=ARM.configuration(joints))
    solution = robots.solve_program(Program("p", (Procedure("main", (path,)),)), ARM)
    assert [f.code for f in solution.findings] == ["RB105"]


# ------------------------------------------------------------------------ where they stand


def test_findings_stand_at_the_statement_that_is_worst():
    p, q = ARM.fk([[0, 20, 20, 0, 30, -90], [0, 20, 20, 0, 30, 60], [0, 20, 20, 0, 30, -160]])
    ends = [TargetValue(Target(Pose.of(*pose))) for pose in zip(p, q, strict=True)]
    fast = Motion(Speed(100.0, 800.0), FINE)
    body = [
        Move("linear", end, fast, span=Span(10 * at, 10 * at + 9)) for at, end in enumerate(ends)
    ]
    (finding,) = found(*body)
    assert finding.code == "CK311"
    assert finding.span in (Span(10, 19), Span(20, 29))


def test_apart_statements_have_findings_of_their_own():
    angles = [-90, 90, 80, 70, 60, -120]
    p, q = ARM.fk([[0, 20, 20, 0, 30, angle] for angle in angles])
    ends = [TargetValue(Target(Pose.of(*pose))) for pose in zip(p, q, strict=True)]
    fast = Motion(Speed(100.0, 800.0), FINE)
    told = found(*(Move("linear", end, fast) for end in ends))
    assert {f.code for f in told} == {"CK311"}
    assert sum(f.place.count("move 2 of main") for f in told) == 1
    assert sum(f.place.count("move 6 of main") for f in told) == 1
    assert not any("move 4 of main" in f.place for f in told)


EXTERNAL = """MODULE Table
CONST jointtarget turned:=[[9E9,9E9,9E9,9E9,9E9,9E9],[90,9E9,9E9,9E9,9E9,9E9]];
CONST speeddata turning:=[0,0,0,30];
PROC main()
ActUnit STN1;
{move}
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(
    ("move", "codes"),
    [
        ("MoveExtJ turned,turning,fine;", set()),
        ("MoveExtJ turned,vrot20,fine;", set()),
        ("MoveAbsJ turned,v100,fine,tool0;", {"RB126"}),
        ("MoveAbsJ turned,turning,fine,tool0;", {"RB126", "CK201"}),
    ],
)
def test_external_axes_that_move_alone(move, codes, tmp_path):
    path = tmp_path / "table.mod"
    path.write_text(EXTERNAL.format(move=move))
    for robot in (None, ARM):
        found = {f.code for f in assistant.check(path, robot=robot).findings} - {"RA452"}
        assert found == (codes if robot else codes - {"RB126"})


def test_a_tool_that_is_declared_without_sound_values_is_not_called_undeclared(tmp_path):
    path = tmp_path / "tool.mod"
    path.write_text(
        "MODULE m\nPERS tooldata tA:=[TRUE,[[0,0,9],[0,0,0,0]],[1,[0,0,9],[1,0,0,0],0,0,0]];\n"
        'PERS wobjdata wA:=[FALSE,FALSE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n'
        "CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "PROC main()\nMoveJ p1,v100,fine,tA;\nMoveL p1,v100,fine,tool0\\WObj:=wA;\n"
        "MoveL p1,v100,fine,tB;\nENDPROC\nENDMODULE\n"
    )
    found = assistant.check(path, robot=ARM).findings
    codes = {"RA462", "RA468", "RB125", "RB111"}
    named = {
        (f.code, name) for f in found for name in ("tA", "wA", "tB") if f"`{name}`" in f.message
    }
    assert {one for one in named if one[0] in codes} == {
        ("RA462", "tA"), ("RA468", "wA"), ("RB125", "tA"), ("RB125", "wA"), ("RB111", "tB")
    }  # fmt: skip


def test_a_tool_without_mass_has_one_finding(tmp_path):
    path = tmp_path / "tool.mod"
    path.write_text(
        "MODULE m\nPERS tooldata tA:=[TRUE,[[0,0,9],[1,0,0,0]],[0,[0,0,9],[1,0,0,0],0,0,0]];\n"
        "CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "PROC main()\nMoveJ p1,v100,fine,tA;\nENDPROC\nENDMODULE\n"
    )
    codes = [f.code for f in assistant.check(path, robot=ARM).findings]
    assert (codes.count("RA469"), codes.count("CK331")) == (1, 0)
