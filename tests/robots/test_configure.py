"""Configurations of whole programs, and what a robot cannot do of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Severity
from assistant.program.expressions import (
    Aggregate,
    Apply,
    Index,
    JointValue,
    Name,
    Number,
    TargetValue,
    Truth,
    Unary,
)
from assistant.program.geometry import Configuration, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, UNSTATED, Kind, Path, Speed, configuration_row
from assistant.program.program import Procedure, Program, Variable
from assistant.program.statements import (
    Branch,
    Follow,
    For,
    If,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Statement,
)
from assistant.robots.motion.row_reach import NearestPoseCures
from assistant.robots.motion.run import path_part, run_of_parts
from assistant.robots.motion.run_solution import solve_run

DOWN = (0.0, 0.0, 1.0, 0.0)
ABB = robots.get("irb1200-7-0.7")
MOTION = Motion(Speed(100.0), FINE)


def program(*body: Statement, **parts) -> Program:
    return Program("p", (Procedure("main", body),), **parts)


def down(x: float, y: float, z: float, configuration: Configuration | None = None) -> TargetValue:
    return TargetValue(Target(Pose((x, y, z), DOWN), configuration))


def path_of(positions, quaternions=DOWN, **more) -> Path:
    p = np.asarray(positions, dtype=float)
    q = np.broadcast_to(np.asarray(quaternions, dtype=float), (len(p), 4))
    return Path.of("seam", p, q, speeds=[Speed(100.0)], **more)


def turning(degrees) -> np.ndarray:
    """A tool that points down, turned about its own axis."""
    return rotations.multiply(
        DOWN, rotations.about(np.tile([0, 0, 1.0], (len(degrees), 1)), degrees)
    )


def followed(path: Path, robot=ABB, **parts) -> tuple[Path, np.ndarray, tuple[Diagnostic, ...]]:
    """The configured path, the joints that its configurations give, the findings."""
    out, findings = robots.configure(program(Follow(path), **parts), robot)
    (statement,) = out.procedures[0].body
    assert isinstance(statement, Follow)
    done = statement.path
    joints = robot.joints_of(done.positions, done.quaternions, done.configurations)
    return done, joints, findings


def codes(findings: tuple[Diagnostic, ...]) -> list[str]:
    return [finding.code for finding in findings]


def test_a_path_in_reach_is_configured_without_findings() -> None:
    t = np.linspace(0, 4 * math.pi, 400)
    path = path_of(np.c_[450 + 100 * np.cos(t), 100 * np.sin(t), 300 + 0 * t])
    done, joints, findings = followed(path)
    assert not findings
    assert (done.configurations[:, 0] != UNSTATED).all()
    assert np.abs(np.diff(joints, axis=0)).max() < 10.0
    assert ABB.inside(joints).all()
    assert np.array_equal(done.positions, path.positions)


def test_unreachable_rows_are_named_and_measured() -> None:
    x = np.array([400.0, 450.0, 1200.0, 460.0, 1300.0])
    path = path_of(np.c_[x, 0 * x, 300 + 0 * x])
    done, joints, findings = followed(path)
    assert codes(findings) == ["RB102"]
    (finding,) = findings
    assert finding.severity is Severity.ERROR
    assert "2 of 5" in finding.where()
    assert "seam_3" in finding.where()
    assert "seam_5" in finding.where()
    worst = math.hypot(1300, 300 + 82 - 399.1) - 350 - math.hypot(42, 351)
    assert f"{worst:.1f} mm too far out (seam_5)" in finding.message
    unstated = done.configurations[:, 0] == UNSTATED
    assert unstated.tolist() == [False, False, True, False, True]
    assert np.isfinite(joints[~unstated]).all()


def test_too_near_is_told_from_too_far() -> None:
    robot = robots.get("rv-4frl")
    near = np.array([[0.0, 0.0, robot.lengths.d1 - robot.lengths.d6 + 5.0]])
    _, _, findings = followed(path_of(near), robot)
    assert codes(findings) == ["RB102"]
    assert "too near" in findings[0].message


def test_a_joint_outside_its_limits_is_named() -> None:
    # Only axis 5 beyond its limit brings the flange there: the tool points back along the arm.
    joints = np.array([[0.0, 60.0, -20.0, 0.0, 131.5, 0.0]])
    wide = replace(ABB, limits=ABB.limits * 1.2)
    p, q = wide.fk(joints)
    _, _, findings = followed(path_of(p, q))
    assert codes(findings) == ["RB103"]
    assert "J5 would be at 131.50 degrees, its limit is 130" in findings[0].message


def test_rows_that_are_no_number_are_named() -> None:
    path = path_of([[400, 0, 300.0], [math.nan, 0, 300.0], [410, 0, 300.0]])
    _, _, findings = followed(path)
    assert codes(findings) == ["RB101"]
    assert "seam_2" in findings[0].where()


def test_a_linear_path_that_no_single_branch_follows_is_refused() -> None:
    narrow = ABB.limits.copy()
    narrow[[0, 2, 3]] = [(-100, 100), (-70, 70), (-90, 90)]  # leaves each pose one branch
    robot = replace(ABB, limits=narrow)
    p, q = robot.fk([[0, 20, 10, 20, 80, 0.0], [0, 20, 10, 80, -80, 0.0], [0, 20, 10, 85, -80, 0]])
    _, _, findings = followed(path_of(p, q), robot)
    assert codes(findings) == ["RB105"]
    _, joints, findings = followed(path_of(p, q, kinds=Kind.JOINT), robot)
    assert not findings
    assert robot.inside(joints).all()


def test_tool_and_frame_are_taken_into_account() -> None:
    tool = Tool(Pose((0, 0, 150), tuple(rotations.from_euler([0, 30, 0]))))
    frame = Frame(Pose((400, 50, 100), tuple(rotations.from_euler([90, 0, 0]))), Pose((0, 0, 20)))
    path = path_of([[0, 0, 10.0], [50, 0, 10.0]], tools=("gun",), frames=("table",))
    out, findings = robots.configure(
        program(Follow(path), tools={"gun": tool}, frames={"table": frame}), ABB
    )
    assert not findings
    done = out.procedures[0].body[0].path
    wanted = [frame.pose @ path.pose(row) @ tool.tip.inverse() for row in range(2)]
    joints = ABB.joints_of(
        [pose.position for pose in wanted],
        [pose.quaternion for pose in wanted],
        done.configurations,
    )
    assert np.isfinite(joints).all()


def test_a_work_piece_in_the_gripper_and_a_tool_in_the_room() -> None:
    tool = Tool(Pose((450, 0, 400), tuple(rotations.from_euler([0, 90, 0]))), held=False)
    frame = Frame(object=Pose((0, 0, 40)), held=True)
    target = Pose((0, 10, 0), (1.0, 0.0, 0.0, 0.0))
    path = path_of([target.position], target.quaternion, tools=("gun",), frames=("part",))
    out, findings = robots.configure(
        program(Follow(path), tools={"gun": tool}, frames={"part": frame}), ABB
    )
    assert not findings
    flange = tool.tip @ (frame.pose @ target).inverse()
    joints = ABB.joints_of(
        [flange.position], [flange.quaternion], out.procedures[0].body[0].path.configurations
    )
    there, turned = ABB.fk(joints)
    tip = Pose.of(there[0], turned[0]) @ frame.pose @ target
    assert tip.position == pytest.approx(tool.tip.position)


def test_paths_with_several_tools() -> None:
    tools = {"long": Tool(Pose((0, 0, 200))), "short": Tool(Pose((0, 0, 20)))}
    path = path_of(
        [[450, 0, 100.0], [450, 0, 280.0]], tools=("long", "short"), tool=[0, 1], kinds=Kind.JOINT
    )
    out, findings = robots.configure(program(Follow(path), tools=tools), ABB)
    assert not findings
    wrists = np.array([[450, 0, 300.0], [450, 0, 300.0]])
    rows = out.procedures[0].body[0].path.configurations
    assert np.isfinite(ABB.joints_of(wrists, [DOWN, DOWN], rows)).all()


def test_stated_configurations_stay_and_guide_the_others() -> None:
    t = np.linspace(0, 1, 20)
    rows = np.tile(np.array([UNSTATED, 0, 0, 0, 0, 0], np.int8), (20, 1))
    rows[10] = (0, 0, 1, 0, 2, 2)
    path = path_of(np.c_[400 + 50 * t, 20 + 0 * t, 300 + 0 * t], configurations=rows)
    done, joints, findings = followed(path)
    assert not findings
    assert (done.configurations[:, 2] == 1).all()
    assert np.abs(np.diff(joints, axis=0)).max() < 5.0


def test_a_stated_configuration_that_cannot_be_kept_comes_with_one_that_can() -> None:
    stated = Configuration(back=True)
    out, findings = robots.configure(
        program(Move("joint", down(400, 10, 300, stated), MOTION)), ABB
    )
    assert codes(findings) == ["RB107"]
    assert "front, elbow up, no flip, quadrants 0 0 0" in findings[0].cure
    assert out.procedures[0].body[0].target.target.configuration == stated


def test_a_stated_quadrant_that_is_not_so_is_a_warning() -> None:
    stated = Configuration(quadrants=(1, 0, 0))
    _, findings = robots.configure(program(Move("joint", down(400, 10, 300, stated), MOTION)), ABB)
    assert codes(findings) == ["RB108"]
    assert findings[0].severity is Severity.WARNING


def test_moves_in_order_of_text_and_nested_ones() -> None:
    body = (
        MoveJoints(JointValue(JointTarget((0, 0, 0, 0, 30, 0))), MOTION),
        Move("linear", down(430, 10, 400), MOTION),
        If((Branch(Truth(True), (Move("linear", down(430, 60, 400), MOTION),)),)),
        For(
            "i",
            Number(1),
            Number(3),
            (MoveCircular(down(400, 0, 400), down(380, 30, 400), MOTION),),
        ),
    )
    out, findings = robots.configure(program(*body), ABB)
    assert not findings
    _, first, branch, loop = out.procedures[0].body
    inner = loop.body[0]
    targets = [first.target, branch.branches[0].body[0].target, inner.via, inner.target]
    assert all(t.target.configuration == Configuration() for t in targets)


def test_declared_targets_are_configured_by_the_moves_that_name_them() -> None:
    targets = {
        "Near": Target(Pose((100, 10, 300), DOWN)),
        "far": Target(Pose((3000, 0, 300), DOWN)),
        "spare": Target(Pose((150, 10, 300), DOWN)),
    }
    frames = {"table": Frame(Pose((300, 0, 0)))}
    motion = replace(MOTION, frame="table")
    up = Apply("offset", (Name("near"), Number(0), Number(0), Unary("-", Number(-50))))
    body = (Move("joint", up, motion), Move("linear", Name("near"), motion))
    out, findings = robots.configure(program(*body, targets=targets, frames=frames), ABB)
    assert not findings
    assert out.targets["Near"].configuration == Configuration()
    assert out.targets["spare"].configuration is not None
    assert out.targets["far"].configuration is None  # no move goes there: nothing to report
    _, findings = robots.configure(
        program(*body, Move("joint", Name("far"), motion), targets=targets, frames=frames), ABB
    )
    assert codes(findings) == ["RB102"]
    assert "far" in findings[0].where()


def test_an_offset_out_of_reach_is_found() -> None:
    targets = {"edge": Target(Pose((600, 0, 400), DOWN))}
    far = Apply("offset", (Name("edge"), Number(400), Number(0), Number(0)))
    _, findings = robots.configure(
        program(Move("joint", Name("edge"), MOTION), Move("joint", far, MOTION), targets=targets),
        ABB,
    )
    assert codes(findings) == ["RB102"]
    assert "move 2 of main" in findings[0].where()


def test_the_same_target_twice_has_one_configuration() -> None:
    targets = {"home": Target(Pose((450, 0, 300), tuple(turning(np.array([-120.0]))[0])))}
    q = turning(np.linspace(-120, 240, 40))
    moves = [
        Move("linear", TargetValue(Target(Pose((450, 0, 300), tuple(row.tolist())))), MOTION)
        for row in q
    ]
    body = (Move("joint", Name("home"), MOTION), *moves, Move("joint", Name("home"), MOTION))
    out, findings = robots.configure(program(*body, targets=targets), ABB)
    assert not findings
    chosen = out.targets["home"].configuration
    assert chosen is not None
    last = out.procedures[0].body[-2].target.target.configuration
    assert last.quadrants[2] - chosen.quadrants[2] == 4


def test_a_linear_move_keeps_the_branch_that_it_starts_from() -> None:
    there = ABB.fk([[15, 20, 20, 170, -60, 170.0]])
    target = TargetValue(Target(Pose.of(there[0][0], there[1][0])))
    joints = MoveJoints(JointValue(JointTarget((5, 20, 20, 170, -60, 170))), MOTION)
    out, findings = robots.configure(program(joints, Move("linear", target, MOTION)), ABB)
    assert not findings
    chosen = out.procedures[0].body[1].target.target.configuration
    assert chosen == Configuration(flip=True, quadrants=(0, 1, 1))


@pytest.mark.parametrize(
    ("joints", "code"),
    [((0, 0, 0, 0, 131, 0), "RB109"), ((0, 0, 0), "RB110"), ((0, 0, 0, math.nan, 0, 0), "RB110")],
)
def test_joint_targets_are_checked_once(joints, code) -> None:
    target = JointTarget(joints)
    declared = program(MoveJoints(Name("park"), MOTION), joint_targets={"park": target})
    literal = program(MoveJoints(JointValue(target), MOTION))
    for each in (declared, literal):
        assert codes(robots.configure(each, ABB)[1]) == [code]


def test_unknown_tools_and_moved_frames_are_not_checked() -> None:
    motion = replace(MOTION, tool="gun")
    _, findings = robots.configure(program(Move("joint", down(400, 0, 300), motion)), ABB)
    assert codes(findings) == ["RB111"]
    joints = JointValue(JointTarget((0, 0, 0, 0, 30, 0)))
    to_joints = MoveJoints(joints, replace(motion, frame="table"))
    _, findings = robots.configure(program(to_joints, to_joints), ABB)
    assert [(f.code, f.place) for f in findings] == [
        ("RB111", "2 times: move 1 of main, move 2 of main")
    ] * 2
    assert ("`gun`" in findings[0].message, "`table`" in findings[1].message) == (True, True)
    frames = {"belt": Frame(mechanism="CNV1")}
    motion = replace(MOTION, frame="belt")
    _, findings = robots.configure(
        program(Move("joint", down(4000, 0, 300), motion), frames=frames), ABB
    )
    assert codes(findings) == ["RB112"]
    assert robots.configure(program(MoveJoints(joints, motion), frames=frames), ABB)[1] == ()


def test_what_only_running_tells_is_left_alone_and_reported() -> None:
    procedure = Procedure(
        "main",
        (Move("joint", Name("somewhere"), MOTION), Move("linear", down(400, 0, 300), MOTION)),
        variables={"somewhere": Variable("position")},
    )
    out, findings = robots.configure(Program("p", (procedure,)), ABB)
    assert [one.code for one in findings] == ["RB128"] and "1 of 2 moves" in findings[0].message
    assert out.procedures[0].body[1].target.target.configuration == Configuration()


def test_places_that_only_running_tells_are_near_the_move_before_them() -> None:
    """Each of the places is gone to from `pick`, so no axis needs more than half a turn."""
    pick, *places = (
        Target(Pose((450, 0, 300), tuple(row.tolist())))
        for row in turning(np.array([150.0, 0.0, -150.0, 30.0, -60.0]))
    )
    aggregate = Aggregate(tuple(TargetValue(place) for place in places))
    variables = {"places": Variable("position", aggregate, (4,), storage="constant")}
    at_place = Index(Name("places"), (Name("i"),))
    loop = (Move("joint", Name("pick"), MOTION), Move("joint", at_place, MOTION))
    body = For("i", Number(1), Number(4), loop)
    out, findings = robots.configure(
        program(body, targets={"pick": pick}, variables=variables), ABB
    )
    assert codes(findings) == ["RB128"]
    chosen = [
        out.targets["pick"],
        *(one.target for one in out.variables["places"].initial.items),
    ]
    joints = ABB.joints_of(
        np.array([one.pose.position for one in chosen]),
        np.array([one.pose.quaternion for one in chosen]),
        np.array([configuration_row(one.configuration) for one in chosen]),
    )
    assert np.abs(joints[1:] - joints[0]).max() <= 180.0
    steps = np.abs(joints[1:, 5] - joints[0, 5])
    assert np.allclose(steps, [150.0, 60.0, 120.0, 150.0], atol=1e-6)


def test_five_axes() -> None:
    robot = robots.get("rv-2aj")
    good = path_of([[250, y, 200.0] for y in (-50, 0, 50)])
    done, joints, findings = followed(good, robot)
    assert not findings
    assert (done.configurations[:, 2] == 1).all()
    assert np.isfinite(joints).all()
    tilted = path_of(
        [[250, 0, 200.0], [250, 10, 200.0]],
        rotations.multiply(rotations.from_euler([0, 0, 20.0]), DOWN),
    )
    _, _, findings = followed(tilted, robot)
    assert codes(findings) == ["RB104"]
    joints_six = program(MoveJoints(JointValue(JointTarget((0, 10, 80, 0, 90, 0))), MOTION))
    assert not robots.configure(joints_six, robot)[1]


def test_configuring_twice_changes_nothing() -> None:
    t = np.linspace(0, 2 * math.pi, 50)
    path = path_of(np.c_[450 + 100 * np.cos(t), 100 * np.sin(t), 300 + 0 * t])
    once, findings = robots.configure(
        program(Move("joint", down(400, 0, 350), MOTION), Follow(path)), ABB
    )
    twice, again = robots.configure(once, ABB)
    assert twice == once
    assert not findings
    assert not again
    assert ABB.check(once) == ()


@pytest.mark.parametrize("name", robots.names())
@pytest.mark.parametrize("kind", [Kind.JOINT, Kind.LINEAR])
def test_random_poses_within_the_limits_never_crash_and_joint_paths_are_solved(name, kind) -> None:
    robot = robots.get(name)
    low, high = robot.limits.T
    joints = np.random.default_rng(5).uniform(low, high, (150, len(low)))
    done, found, findings = followed(path_of(*robot.fk(joints), kinds=kind), robot)
    stated = done.configurations[:, 0] != UNSTATED
    assert stated.all()
    assert robot.inside(found).all()
    if kind is Kind.JOINT:
        assert not findings
    else:
        assert "RB105" in codes(findings) or "RB106" in codes(findings)


def test_a_line_between_two_good_targets_that_leaves_the_reach() -> None:
    ends = [[40.0, 450.0, 400.0], [40.0, -450.0, 400.0]]
    _, _, findings = followed(path_of(ends, kinds=Kind.JOINT))
    assert not findings
    _, _, findings = followed(path_of(ends))
    assert codes(findings) == ["RB113"]
    assert "J3" in findings[0].message
    assert "seam_2" in findings[0].where()


def test_quaternions_of_nearly_unit_length_are_no_obstacle() -> None:
    _, _, findings = followed(path_of([[450, 0, 300.0], [450, 10, 300.0]], (0, 0, 1.0005, 0)))
    assert not findings


def test_a_quaternion_without_length_is_no_number() -> None:
    _, _, findings = followed(path_of([[450, 0, 300.0]], (0, 0, 0, 0)))
    assert codes(findings) == ["RB101"]


def test_rows_that_state_another_branch_in_a_linear_move_are_warned_of() -> None:
    rows = np.array([[0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 2, 2]], dtype=np.int8)
    path = path_of([[400, 20, 300.0], [410, 20, 300.0]], configurations=rows)
    done, _, findings = followed(path)
    assert codes(findings) == ["RB105"]
    assert findings[0].severity is Severity.WARNING
    assert np.array_equal(done.configurations, rows)


def test_long_paths_take_little_memory() -> None:
    import tracemalloc

    rows = 200_000
    t = np.linspace(0, 600, rows)
    path = path_of(np.c_[450 + 100 * np.cos(t), 100 * np.sin(t), 300 + 0 * t])
    tracemalloc.start()
    followed_program, findings = robots.configure(program(Follow(path)), ABB)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert not findings
    assert len(followed_program.procedures[0].body[0].path) == len(path)
    assert peak < rows * 400  # bytes a row; a million rows stay far below 2 GB


def test_the_way_to_a_path_is_solved_with_it() -> None:
    # The path needs the lower half of axis 6, so the joint move before it has to go there.
    q = turning(np.linspace(-20, -540, 100))
    positions = np.tile([450, 0, 300.0], (100, 1))
    above = TargetValue(Target(Pose((450, 0, 350), tuple(q[0].tolist()))))
    body = (Move("joint", above, MOTION), Follow(path_of(positions, q)))
    out, findings = robots.configure(program(*body), ABB)
    assert not findings
    approach = out.procedures[0].body[0].target.target.configuration
    assert abs(approach.quadrants[2] - out.procedures[0].body[1].path.configurations[0, 5]) <= 1


def test_a_path_followed_twice_has_one_configuration() -> None:
    path = path_of([[450, 0, 300.0], [450, 20, 300.0]])
    out, findings = robots.configure(
        program(Follow(path), Move("joint", down(400, 0, 400), MOTION), Follow(path)), ABB
    )
    assert not findings
    first, _, second = out.procedures[0].body
    assert first.path == second.path
    assert first.path.configurations[0, 0] != UNSTATED


def test_a_target_has_the_configuration_that_it_has_itself() -> None:
    """Not that of a place beside it, though the arm goes there first."""
    target = Target(Pose((450, 40, 300), DOWN))
    beside = Apply("offset", (Name("part"), Number(0), Number(-200), Number(0)))
    body = (Move("joint", beside, MOTION), Move("joint", Name("part"), MOTION))
    out, findings = robots.configure(program(*body, targets={"part": target}), ABB)
    assert not findings
    assert out.targets["part"].configuration.quadrants[0] == 0


def test_a_branch_that_another_place_gave_is_no_wish_of_the_program() -> None:
    """A change of branch on a line is a warning only where the program states both ends."""
    rows = np.array([[0, 0, 0, 0, 0, 0], [0, 0, 1, 0, 2, 2]], dtype=np.int8)
    path = path_of([[400, 20, 300.0], [410, 20, 300.0]])
    run = run_of_parts([path_part(path, rows, [Tool()], [Frame()])], np.zeros(6), joined=False)
    for theirs, severity in ((True, Severity.WARNING), (False, Severity.ERROR)):
        (finding,) = solve_run(run, ABB, NearestPoseCures(ABB), np.array([theirs, theirs])).findings
        assert (finding.code, finding.severity) == ("RB105", severity)
