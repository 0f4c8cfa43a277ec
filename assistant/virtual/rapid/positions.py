"""Functions of positions: the arm's position, offsets, orientations, poses and frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.robots.configurations import from_confdata, to_confdata
from assistant.virtual.kernel.kernel import Standing
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import whole
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.motion import flange_of
from assistant.virtual.rapid.records import (
    confdata,
    extjoint_of,
    joints_of,
    jointtarget,
    moved_target,
    number,
    orient,
    pos,
    pose,
    pose_of,
    quaternion_of,
    record,
    robtarget,
    tool0,
    truth,
    vector_of,
    wobj0,
)
from assistant.virtual.rapid.values import Array, Record, copied


def _current_target(given: Given) -> Pose:
    """The position in the tool and work object that are named, else in those of the latest move.

    CRobT without them reads in the active tool and work object: tool0 and wobj0 before a motion, as
    in a controller that was just started.
    """
    tool = given.optional_record("tool", "tooldata") or given.machine.arm.tool or tool0()
    frame = given.optional_record("wobj", "wobjdata")
    if frame is None:
        frame = given.machine.arm.frame or wobj0()
    standing = _arm_standing(given)
    return given.machine.arm.reading(tool, frame, None if standing is None else standing[0])


def _arm_standing(given: Given) -> Standing | None:
    """Return the arm's present position, also during a motion; None if it only follows from the
    motions.
    """
    machine, motion = given.machine, given.machine.task.kernel.motion
    if machine.robot is None:
        return None
    standing = motion.where()
    # During a motion the result depends on the clock: a wait that reads it has to ask again.
    if not motion.stands():
        machine.hangs_on.add("time")
    return standing


def present_target(given: Given) -> Record:
    """CRobT: in the tool and work object of its options."""
    arm, machine, standing = given.machine.arm, given.machine, _arm_standing(given)
    joints = arm.joints if standing is None else standing[1]
    configuration = arm.configuration
    if joints is not None and (configuration is None or standing is not None):
        configuration = _stated_configuration(machine, joints)
    return robtarget(_current_target(given), configuration, arm.external)


def _current_joints(given: Given) -> Record:
    """Return the present joints; after a motion to a position, those of its configuration."""
    arm, machine, standing = given.machine.arm, given.machine, _arm_standing(given)
    joints = arm.joints if standing is None else standing[1][:6]
    # ConfJ\Off or ConfL\Off lets the arm end in another configuration than the target's.
    if joints is None and arm.watches_joints and arm.watches_lines and arm.flange is not None:
        joints = _solved_joints(machine, arm.flange, arm.configuration)
    if joints is None:
        raise NotSimulated("joints that are read behind a motion to a position")
    return jointtarget(joints, arm.external)


def _target_of_joints(given: Given) -> Record:
    target, tool = given.record(0, "jointtarget"), given.record(1, "tooldata")
    frame = given.optional_record("wobj", "wobjdata") or wobj0()
    arm, joints = given.machine.arm, joints_of(target)
    flange = flange_of(given.machine, joints)
    if flange is None:
        raise NotSimulated("CalcRobT without a robot")
    there = arm.reading(tool, frame, flange)
    axes = extjoint_of(target.parts["extax"], [-offset for offset in arm.offsets])
    return robtarget(there, _stated_configuration(given.machine, joints), axes)


def _joints_of_target(given: Given) -> Record:
    """CalcJointT: with the displacement and the offset that are active."""
    target, tool = given.record(0, "robtarget"), given.record(1, "tooldata")
    frame = given.optional_record("wobj", "wobjdata") or wobj0()
    arm, machine = given.machine.arm, given.machine
    if machine.robot is None:
        raise NotSimulated("CalcJointT without a robot")
    flange = arm.flange_at(pose_of(target), tool, frame)
    joints = _solved_joints(machine, flange, record(target.parts["robconf"], "confdata"))
    if joints is None:
        # Solve without the configuration, to tell an arm that is too short from a limit of a joint.
        _, excess = machine.robot.solve(*_joint_rows(flange))
        reached = bool((excess <= 0.0).any())
        raise Fault("a position that the robot does not reach", _UNREACHED_ERROR[reached])
    return jointtarget(joints, extjoint_of(target.parts["extax"], arm.offsets))


_UNREACHED_ERROR: Final = {False: "ERR_OUTSIDE_REACH", True: "ERR_ROBLIMIT"}
"""By whether the arm is long enough (manual, CalcJointT)."""


def _joint_rows(flange: Pose) -> tuple[Floats, Floats]:
    return np.array([flange.position]), np.array([flange.quaternion])


def _solved_joints(
    machine: Machine, flange: Pose, configuration: Record | None
) -> tuple[float, ...] | None:
    """Return the six joints at a flange pose, None if this configuration has none."""
    robot = machine.robot
    if robot is None or configuration is None or not robot.arm.named or len(robot.axes) > 6:
        return None
    stated = [[int(number(part)) for part in configuration.parts.values()]]
    found = robot.joints_of(*_joint_rows(flange), from_confdata(stated))[0]
    if bool(np.isnan(found).any()):
        return None
    # RAPID has six joints always; an arm with fewer leaves the others at 0.
    joints = [0.0] * 6
    for place, joint in zip(robot.places, found, strict=True):
        joints[place] = float(joint)
    return tuple(joints)


def _stated_configuration(machine: Machine, joints: tuple[float, ...]) -> Record | None:
    """Return the configuration as confdata, None if the robot's arm has none."""
    robot = machine.robot
    if robot is None or not robot.arm.named:
        return None
    own = np.array([robot.own_joints(joints)])
    one, four, six, x = (float(part) for part in to_confdata(robot.configuration(own))[0])
    return confdata(one, four, six, x)


def _active_tool(given: Given) -> Record:
    return given.machine.arm.tool or tool0()


def _active_frame(given: Given) -> Record:
    return given.machine.arm.frame or wobj0()


def _own_task_row(read: Callable[[Given], Record]) -> Callable[[Given], Record]:
    """Reads of the arm of the task that an option names: only its own is known here."""

    def of_task(given: Given) -> Record:
        task, reference = given.optional("taskname"), given.options.get("taskref")
        if isinstance(reference, s.NameRef):
            # Each task has data of the type taskid whose name is the task's with `Id`.
            task = reference.name.lower().removesuffix("id")
        if task is not None and str(task).lower() != given.machine.task.name.lower():
            if any(str(task).lower() == one.name.lower() for one in given.machine.controller.tasks):
                raise NotSimulated("the arm of another task")
            raise Fault(f"there is no task `{task}`", "ERR_TASKNAME")
        return read(given)

    return of_task


_TASK_OPTIONS: Final = "taskname taskref"
ARM_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("CRobT", 0, _own_task_row(present_target), f"tool wobj {_TASK_OPTIONS}"),
        table_row("CPos", 0, lambda given: pos(_current_target(given).position), "tool wobj"),
        table_row("CJointT", 0, _own_task_row(_current_joints), _TASK_OPTIONS),
        table_row("CTool", 0, _own_task_row(_active_tool), _TASK_OPTIONS),
        table_row("CWObj", 0, _own_task_row(_active_frame), _TASK_OPTIONS),
        table_row("CalcRobT", 2, _target_of_joints, "wobj"),
        table_row("CalcJointT", 2, _joints_of_target, "wobj usecurwobjpos"),
    )
)


_ANGLE_SWITCHES: Final = ("z", "y", "x")
_MOST_REPAIRED: Final = 0.1
"""Largest distance of the sum of squares from 1 for NOrient (manual, NOrient)."""


def _offset_target(given: Given) -> Record:
    """Along the axes of the target's frame; the rest of the target stays as it is."""
    target = copied(given.record(0, "robtarget"))
    assert isinstance(target, Record)
    x, y, z = (a + given.number(i) for i, a in enumerate(vector_of(target.parts["trans"]), 1))
    target.parts["trans"] = pos((x, y, z))
    return target


def _relative_target(given: Given) -> Record:
    """Along the axes of the tool, then turned about its x, its new y and its new z."""
    target = given.record(0, "robtarget")
    shift = (given.number(1), given.number(2), given.number(3))
    angles = [given.optional_number(option) or 0.0 for option in ("rx", "ry", "rz")]
    turn = rotations.from_euler(angles, "XYZ")
    return moved_target(target, pose_of(target) @ Pose.of(np.array(shift), turn))


def _multiplied_poses(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")) @ pose_of(given.record(1, "pose")))


def _inverse_pose(given: Given) -> Record:
    return pose(pose_of(given.record(0, "pose")).inverse())


def _transformed_vector(given: Given) -> Record:
    at = pose_of(given.record(0, "pose")) @ Pose(vector_of(given.record(1, "pos")))
    return pos(at.position)


def _orientation_of_angles(given: Given) -> Record:
    angles = [given.number(i) for i in range(3)]
    w, x, y, z = (float(part) for part in rotations.from_euler(angles, "ZYX"))
    return orient((w, x, y, z))


def _euler_angle(given: Given) -> float:
    wanted = [i for i, letter in enumerate(_ANGLE_SWITCHES) if given.has(letter)]
    if len(wanted) != 1:
        raise Fault("EulerZYX takes one of its switches")
    angles = rotations.to_euler(quaternion_of(given.record(0, "orient")), "ZYX")
    return float(angles[wanted[0]])


def _normalised_orientation(given: Given) -> Record:
    parts = [number(part) for part in given.record(0, "orient").parts.values()]
    length = math.hypot(*parts)
    if not abs(length * length - 1.0) <= _MOST_REPAIRED:
        raise Fault("an orientation that is too far from a unit quaternion", UNSURE)
    w, x, y, z = (part / length for part in parts)
    return orient((w, x, y, z))


def _distance(given: Given) -> float:
    return math.dist(vector_of(given.record(0, "pos")), vector_of(given.record(1, "pos")))


def _magnitude(given: Given) -> float:
    return math.hypot(*vector_of(given.record(0, "pos")))


def _dot_product(given: Given) -> float:
    return float(np.dot(vector_of(given.record(0, "pos")), vector_of(given.record(1, "pos"))))


def _cross_product(given: Given) -> Record:
    one, two = (vector_of(given.record(i, "pos")) for i in (0, 1))
    x, y, z = (float(part) for part in np.cross(one, two))
    return pos((x, y, z))


POSE_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Offs", 4, _offset_target),
        table_row("RelTool", 4, _relative_target, "rx ry rz"),
        table_row("PoseMult", 2, _multiplied_poses),
        table_row("PoseInv", 1, _inverse_pose),
        table_row("PoseVect", 2, _transformed_vector),
        table_row("OrientZYX", 3, _orientation_of_angles),
        table_row("EulerZYX", 1, _euler_angle, "x y z"),
        table_row("NOrient", 1, _normalised_orientation),
        table_row("Distance", 2, _distance),
        table_row("VectMagn", 1, _magnitude),
        table_row("DotProd", 2, _dot_product),
        table_row("CrossProd", 2, _cross_product),
    )
)


MIRROR: Final = np.array([1.0, 1.0, -1.0])
"""The xy plane of the frame of the mirror."""


def _mirrored_target(given: Given) -> Record:
    r"""MirPos: the tool's x and z axis are mirrored, with \MirY its y and z axis.

    The third follows from them, so that the axes are a right-handed system again.
    """
    target, plane = given.record(0, "robtarget"), _mirror_place(given.record(1, "wobjdata"))
    frame = given.optional_record("wobj", "wobjdata")
    into = plane.inverse() @ (Pose() if frame is None else _mirror_place(frame))
    seen = into @ pose_of(target)
    # Mirrored axes are left-handed; the third axis follows from the other two below.
    axes = rotations.to_matrix(seen.quaternion) * MIRROR[:, None]
    if given.has("miry"):
        axes[:, 0] = np.cross(axes[:, 1], axes[:, 2])
    else:
        axes[:, 1] = np.cross(axes[:, 2], axes[:, 0])
    there = Pose.of(np.multiply(seen.position, MIRROR), rotations.from_matrix(axes))
    return moved_target(target, into.inverse() @ there)


def _mirror_place(frame: Record) -> Pose:
    """Return the pose of a work object in the world, or of one on the robot in the wrist."""
    if not truth(frame.parts["ufprog"]):
        raise NotSimulated("a work object that a mechanical unit moves")
    return pose_of(frame.parts["uframe"]) @ pose_of(frame.parts["oframe"])


def _defined_frame(given: Given) -> Record:
    origin = whole(given.optional_number("origin") or 1.0, "the origin of a frame")
    return pose(_frame_through(_frame_points(given, range(3)), origin))


def _displaced_frame(given: Given) -> Record:
    """DefDFrame: what takes three positions to three others."""
    old, new = (_frame_through(_frame_points(given, range(i, i + 3)), 1) for i in (0, 3))
    return pose(new @ old.inverse())


def _frame_points(given: Given, indices: range) -> Floats:
    return np.array([vector_of(given.record(i, "robtarget").parts["trans"]) for i in indices])


def _frame_through(points: Floats, origin: int) -> Pose:
    """A frame whose x axis goes from the first to the second point, the third on the side of +y.

    origin: 1 or 2 for that point, 3 for where the y axis then goes through the third point.
    """
    first, second, third = points
    x = second - first
    z = np.cross(x, third - first)
    # The length is twice the area of the triangle: nearly none means that the points span no plane.
    if not np.linalg.norm(z) > 1e-6:
        raise Fault("a frame of positions on one line", "ERR_FRAME")
    x /= np.linalg.norm(x)
    z /= np.linalg.norm(z)
    places = {1: first, 2: second, 3: first + np.dot(third - first, x) * x}
    if origin not in places:
        raise Fault(f"a frame with the origin {origin}", UNSURE)
    axes = np.column_stack((x, np.cross(z, x), z))
    return Pose.of(places[origin], rotations.canonical(rotations.from_matrix(axes)))


def _fitted_frame(given: Given) -> Record:
    """DefAccFrame: the frame that takes positions to others with the least squares of distances."""
    count = whole(given.number(2), "the number of positions")
    old, new = (_listed_points(given, i, count) for i in (0, 1))
    middle, other = old.mean(axis=0), new.mean(axis=0)
    # Kabsch: the turn with the least squares follows from the singular vectors of the covariance.
    u, _, v = np.linalg.svd((old - middle).T @ (new - other))
    # The sign keeps the turn from becoming a mirror image when points are in one plane or noisy.
    turn = v.T @ np.diag((1.0, 1.0, np.sign(np.linalg.det(v.T @ u.T)))) @ u.T
    shift = other - turn @ middle
    apart = np.linalg.norm(old @ turn.T + shift - new, axis=1)
    given.place(3).set(float(apart.max()))
    given.place(4).set(float(apart.mean()))
    return pose(Pose.of(shift, rotations.canonical(rotations.from_matrix(turn))))


def _listed_points(given: Given, index: int, count: int) -> Floats:
    targets = given.place(index).get()
    assert isinstance(targets, Array)
    if not 3 <= count <= min(10, len(targets.items)):
        raise Fault(f"a frame of {count} positions, which is for 3 to 10", UNSURE)
    found = [record(item, "robtarget").parts["trans"] for item in targets.items[:count]]
    return np.array([vector_of(one) for one in found])


def _object_target(given: Given) -> Record:
    """ORobT: a position without the displacement and the offset that are active."""
    arm, target = given.machine.arm, given.record(0, "robtarget")
    if not given.has("inpdisp"):
        target = moved_target(target, arm.displacement @ pose_of(target))
    else:
        target = moved_target(target, pose_of(target))
    if not given.has("ineoffs"):
        target.parts["extax"] = extjoint_of(target.parts["extax"], arm.offsets)
    return target


FRAME_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("MirPos", 2, _mirrored_target, "wobj miry"),
        table_row("DefFrame", 3, _defined_frame, "origin"),
        table_row("DefDFrame", 6, _displaced_frame),
        table_row("DefAccFrame", 5, _fitted_frame),
        table_row("ORobT", 1, _object_target, "inpdisp ineoffs"),
    )
)
