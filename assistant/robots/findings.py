"""Findings of the robot room."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

TURNED: Final = info(
    "RB119",
    "its turn about its axis is free: {count} targets are turned by up to {most:.1f} degrees from "
    "how they were drawn",
    "remove the free turn if the tool must keep its drawn orientation",
)
NO_TURN: Final = warning(
    "RB120",
    "no turn of the tool about its axis leads {robot} to it in one arm branch and within limits; "
    "the turns stay as they were drawn",
    "move the work piece or the robot, tilt the tool, or go on from here after a joint move",
)
NO_TURN_CLEAR: Final = warning(
    "RB121",
    "no turn of the tool about its axis leads {robot} to it without touching something; "
    "the turns stay as they were drawn",
    "move the work piece or what is in the way, or tilt the tool",
)
TURN_KEPT: Final = warning(
    "RB122",
    "the turns that were found for free tools do not hold between their targets; all stay as they "
    "were drawn",
    "give the paths more targets",
)
NOT_TURNED: Final = info(
    "RB123",
    "the arm of {robot} has no branches that a configuration could name: the turns of free tools "
    "stay as they were drawn",
    "turn the tool in the source, or take a robot of the catalogue",
)
NO_ARM: Final = info(
    "RB124",
    "no robot is named, so the turns of free tools stay as they were drawn",
    "name the robot that runs the program: --robot",
)
NO_NUMBER: Final = error(
    "RB101", "the pose is no number", "look for the value where it was computed or read"
)
OUT_OF_REACH: Final = error(
    "RB102", "out of reach of {robot}; at worst the wrist is {worst} mm {side} ({where})", "{cure}"
)
OUTSIDE_LIMITS: Final = error(
    "RB103",
    "outside the joint limits of {robot} in every arm branch; "
    "at worst {axis} would be at {value:.2f} {unit}, its limit is {limit:g} ({where})",
    "{turn}, or move the work piece{nearest}",
)
AT_LIMIT: Final = warning(
    "RB127",
    "{axis} is {over:.2g} {unit} beyond its limit, which is less than the printed decimals tell "
    "({where}): the controller may refuse the target or stop there",
    "teach the target again a little inside the limit",
)
NOT_IN_PLANE: Final = error(
    "RB104",
    "the tool axis leaves the plane of the five-axis arm, "
    "at worst by {worst:.3f} degrees ({where})",
    "tilt the tool towards or away from axis 1 only, or take a robot with six axes{nearest}",
)
TILTED: Final = error(
    "RB116",
    "the tool axis is not upright, at worst by {worst:.3f} degrees ({where}); "
    "{robot} turns its tool about the vertical only",
    "state orientations about Z only, or a tool that is turned by the tilt (180 degrees about X "
    "for targets whose Z axis points down)",
)
UNSOLVED: Final = error(
    "RB117",
    "the solver finds no joints of {robot} that lead to the pose; at worst what comes nearest is "
    "{worst:.2g} mm or degrees away ({where})",
    "move the work piece, turn the tool, or take another robot{nearest}",
)
UNNAMED: Final = info(
    "RB118",
    "the arm of {robot} has no branches that a configuration could name: targets keep what they "
    "state, and what states none stays open",
    "try the program at low speed: which branch the controller takes is not known",
)
BRANCH_CHANGE: Final = error(
    "RB105",
    "a linear or circular move cannot change the arm branch of {robot}, but {branch}, as "
    "before, {reason} ({where})",
    "make it a joint move, or turn the tool so that one branch holds for the whole path",
)
WOUND_UP: Final = error(
    "RB106",
    "{axis} would have to be wound back during a linear or circular move, as its limits are"
    " {low:g} and {high:g}",
    "make it a joint move{more}",
)
ON_THE_WAY: Final = error(
    "RB113",
    "on the {way} to it {robot} {reason} ({where})",
    "go there by a joint move, or by way of another target",
)
NOT_CLOSED: Final = error(
    "RB114",
    "the joints that were computed for {robot} do not lead back to the pose ({where})",
    "move the target a little: the arm is at a singularity there",
)
THROUGH_WRIST: Final = warning(
    "RB115",
    "a linear or circular move takes {robot} through its wrist singularity (axis 5 at 0), where "
    "the controller may stop",
    "move the work piece, tilt the tool a little, or make it a joint move",
)
NOT_AS_STATED: Final = error(
    "RB107", "{robot} cannot take the stated configuration {stated} ({where})", "{cure}"
)
OTHER_QUADRANT: Final = warning(
    "RB108",
    "the arm branch is as stated, but {robot} has the axes 1, 4 and 6 in {counts} "
    "{found}, not {stated} ({where})",
    "state {found}",
)
JOINT_OUTSIDE: Final = error(
    "RB109",
    "{axis} at {value:g} {unit} is outside its limits {low:g} to {high:g}",
    "move the joint target inside the limits",
)
MANY_JOINTS_OUTSIDE: Final = error(
    "RB129",
    "{count} joint targets are outside the limits of {robot}; the worst has {axis} at {value:g} "
    "{unit}, whose limits are {low:g} and {high:g}",
    "{cure}",
)
NO_JOINTS: Final = error(
    "RB126",
    "the joint target states no angle of {robot}, so a joint move of the arm goes nowhere",
    "state the angles of the arm, or move the external axes alone",
)
JOINT_COUNT: Final = error(
    "RB110",
    "{count} joint angles do not fit the axes {axes} of {robot}",
    "state one angle for each axis (0 for an axis that the arm does not have)",
)
UNKNOWN_TOOL: Final = warning(
    "RB111",
    "no {kind} `{name}` is declared, so where moves with it lead is not checked",
    "declare it, or name one of {names}",
    misses=True,
)
VALUELESS_TOOL: Final = warning(
    "RB125",
    "the {kind} `{name}` is declared without values that can be read, so where moves with it lead "
    "is not checked",
    "write its values as plain numbers, and every rotation as a quaternion of length 1",
    misses=True,
)
MOVED_FRAME: Final = info(
    "RB112",
    "frame `{name}` is moved by `{mechanism}`, so reach and limits are not checked",
    "state the configurations, or use a frame that stands still",
)
NOT_KNOWN: Final = info(
    "RB128",
    "{moves} to targets that are known only as the program runs: their reach, limits and arm "
    "branch are not checked",
    "try them at low speed; a target is checked if its declaration states its value and nothing "
    "changes it",
)
