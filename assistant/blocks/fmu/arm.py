"""The model of a simulated arm: joints or a pose that are wanted in, where it is out."""

from __future__ import annotations

import numpy as np

from assistant.blocks.code.templates import safe_text, source_identifier
from assistant.blocks.fmu.joints import flag_variables, joint_variables, pose_variables
from assistant.blocks.fmu.model import Model
from assistant.blocks.fmu.variables import Group, Variable
from assistant.robots import Robot
from assistant.robots.timing import drive_of


def arm_model(robot: Robot, *, lag: float = 0.0) -> Model:
    """An arm that goes where it is told, as `ArmMotion` does.

    lag: seconds of the first order by which joints follow, the start of `time_constant`.
    Raises Refused for an arm without a closed form.
    """
    title = safe_text(robot.title)
    return Model(
        identifier=f"{source_identifier(robot.name)}_simulated",
        title=f"{title}, simulated",
        description=f"An arm of {title} that follows joints or poses within its limits",
        template="arm",
        groups=_arm_groups(robot, lag),
        robot=robot,
        follows=frozenset({"STARTS"}),
    )


def _arm_groups(robot: Robot, lag: float) -> tuple[Group, ...]:
    drive, home = drive_of(robot), robot.home
    (position,), (quaternion,) = robot.fk(home)
    low, high = robot.limits.T
    return (
        Group("STARTS", "Real", "parameter",
              joint_variables(robot, "{}_start", "joint at the start", home)),
        Group("SPEED_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_speed_limit", "top speed", drive.speeds, "/s")),
        Group("ACCELERATION_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_acceleration_limit", "acceleration at most",
                              drive.accelerations, "/s2")),
        Group("LOWER_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_lower_limit", "lower limit", low)),
        Group("UPPER_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_upper_limit", "upper limit", high)),
        Group("TIME_CONSTANT", "Real", "parameter",
              [Variable("time_constant", "first order by which joints follow, 0 for none",
                        float(lag), "s")]),
        Group("WANTED_JOINTS", "Real", "input",
              joint_variables(robot, "{}_wanted", "wanted joint", home)),
        Group("WANTED_POSE", "Real", "input",
              pose_variables("{}_wanted", "wanted pose of the flange in the base",
                             np.concatenate([position, quaternion]).tolist())),
        Group("JOINTS", "Real", "output", joint_variables(robot, "{}", "joint")),
        Group("SPEEDS", "Real", "output",
              joint_variables(robot, "{}_speed", "speed of the motor", per="/s")),
        Group("POSE", "Real", "output", pose_variables("{}", "pose of the flange in the base")),
        Group("BRANCH", "Integer", "input",
              [Variable("branch", "of the arm for poses; -1 for the nearest one", -1)]),
        Group("CONFIGURATION", "Integer", "output", _configuration_variables()),
        Group("BY_POSE", "Boolean", "input",
              [Variable("by_pose", "whether the wanted pose counts, not the joints", start=False)]),
        Group("REACHABLE", "Boolean", "output",
              [Variable("reachable", "whether what is wanted is inside all limits")]),
        Group("AT_LIMIT", "Boolean", "output",
              flag_variables(robot, "{}_at_limit", "whether {} stays inside its limit")),
        Group("AT_SPEED", "Boolean", "output",
              flag_variables(robot, "{}_at_speed", "whether {} goes at its top speed")),
    )  # fmt: skip


def _configuration_variables() -> list[Variable]:
    said = {
        "back": "1 for a wrist behind axis 1, a SCARA: elbow left",
        "down": "1 for an elbow below, a SCARA: 1",
        "flip": "1 for a flipped wrist, a SCARA and five axes: 1",
        "quarter_J1": "quarter turn of J1, from 0",
        "quarter_J4": "quarter turn of J4, from 0",
        "quarter_J6": "quarter turn of J6, from 0",
    }
    return [Variable(name, description) for name, description in said.items()]
