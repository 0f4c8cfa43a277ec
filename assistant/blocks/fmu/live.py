"""The model of a live controller: joints out to it and back from it, in each of its cycles."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused
from assistant.blocks.code.templates import (
    number_literal,
    number_literals,
    safe_text,
    source_identifier,
)
from assistant.blocks.fmu import rules
from assistant.blocks.fmu.joints import flag_variables, joint_variables, pose_variables
from assistant.blocks.fmu.model import Model
from assistant.blocks.fmu.variables import Group, Variable
from assistant.controllers.cyclic import Settings
from assistant.controllers.mitsubishi.external_control import CYCLES, PORT
from assistant.robots import Robot
from assistant.robots.timing import drive_of

LOCAL_HOST: Final = "127.0.0.1"
"""Where a virtual controller is, which is what is meant if nothing else is named."""
USUAL_SPEED_SHARE, USUAL_RISE_SHARE = 0.5, 0.2
"""Parts of the arm's own speeds and accelerations that are used if nothing is said."""


def live_model(robot: Robot, *, cycle: float | None = None) -> Model:
    """A controller that is led cycle by cycle. cycle: seconds, None for those of the controller.

    Raises Refused for an arm without a closed form, one of another maker, and a cycle that is none.
    """
    if not robot.controller.startswith("CR"):
        raise Refused(rules.NO_LIVE_CONTROLLER(title=robot.title, controller=robot.controller))
    usual = CYCLES.get(robot.controller, CYCLES["CR750"])
    seconds = usual if cycle is None else cycle
    if not 0.001 <= seconds <= 0.1:
        raise Refused(rules.BAD_CYCLE(value=seconds), exit_status=2)
    title, drive = safe_text(robot.title), drive_of(robot)
    return Model(
        identifier=f"{source_identifier(robot.name)}_live",
        title=f"{title}, live",
        description=f"A controller of {title} in real-time external control, joints each cycle",
        template="live",
        groups=_live_groups(robot),
        robot=robot,
        told={
            "cycle": number_literal(seconds),
            "tables": [
                ("TOP_SPEEDS", number_literals(drive.speeds)),
                ("TOP_RISES", number_literals(drive.accelerations)),
                ("AT_PLACE", robot.places),
            ],
        },
        step=seconds,
        any_step=False,
        copies=False,
        libraries=("ws2_32",),
    )


def _live_groups(robot: Robot) -> tuple[Group, ...]:
    drive, usual = drive_of(robot), Settings()
    low, high = robot.limits.T
    return (
        Group("SPEED_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_speed_limit", "top speed", USUAL_SPEED_SHARE * drive.speeds, "/s")),
        Group("ACCELERATION_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_acceleration_limit", "acceleration at most",
                              USUAL_RISE_SHARE * drive.accelerations, "/s2")),
        Group("LOWER_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_lower_limit", "lower limit", low)),
        Group("UPPER_LIMITS", "Real", "parameter",
              joint_variables(robot, "{}_upper_limit", "upper limit", high)),
        Group("TIMEOUT", "Real", "parameter",
              [Variable("timeout", "without an answer until it is given up", usual.timeout, "s")]),
        Group("APPROACH", "Real", "parameter",
              [Variable("approach", "how far, in degrees or mm, the first goal may be",
                        usual.approach)]),
        Group("LAG", "Real", "parameter",
              [Variable("lag", "that the arm may be behind, at its speed limits", usual.lag, "s")]),
        Group("SLACK", "Real", "parameter",
              [Variable("slack", "degrees or mm that it may be off beside that", usual.slack)]),
        Group("WANTED_JOINTS", "Real", "input",
              joint_variables(robot, "{}_wanted", "wanted joint", robot.home)),
        Group("JOINTS", "Real", "output", joint_variables(robot, "{}", "measured joint")),
        Group("COMMANDS", "Real", "output",
              joint_variables(robot, "{}_command", "commanded joint")),
        Group("POSE", "Real", "output",
              pose_variables("{}", "measured pose of the flange in the base")),
        Group("LONGEST_DELAY", "Real", "output",
              [Variable("longest_delay", "from an answer to the next packet", None, "s")]),
        Group("PORT", "Integer", "parameter", [Variable("port", "of the controller, UDP", PORT)]),
        Group("CYCLES", "Integer", "output", [Variable("cycles", "packets that were answered")]),
        Group("LATE_STEPS", "Integer", "output",
              [Variable("late_steps", "packets later than half a cycle behind an answer")]),
        Group("LOST", "Integer", "output", [Variable("lost", "packets that were not answered")]),
        Group("GARBLED", "Integer", "output", [Variable("garbled", "answers without sense")]),
        Group("SHORT_PACKETS", "Boolean", "parameter",
              [Variable("short_packets", "of 64 bytes, for the CRn-500 series", start=False)]),
        Group("ENABLE", "Boolean", "input",
              [Variable("enable", "whether the arm goes to what is wanted; else it comes to rest",
                        start=False)]),
        Group("CONFIRMED", "Boolean", "output",
              [Variable("confirmed", "whether motion was confirmed at the start")]),
        Group("VIRTUAL", "Boolean", "output",
              [Variable("virtual", "whether the controller is on this machine")]),
        Group("MOVING", "Boolean", "output",
              [Variable("enabled", "whether the arm goes to what is wanted")]),
        Group("REFUSED", "Boolean", "output",
              [Variable("refused", "whether what is wanted is too far away to begin")]),
        Group("AT_LIMIT", "Boolean", "output",
              flag_variables(robot, "{}_at_limit", "whether {} stays inside its limit")),
        Group("CONTROLLER", "String", "parameter",
              [Variable("controller", "name or address; a real one is named here", LOCAL_HOST)]),
        Group("CONFIRM", "String", "parameter",
              [Variable("confirm", "the same as controller: the arm may move", "")]),
    )  # fmt: skip
