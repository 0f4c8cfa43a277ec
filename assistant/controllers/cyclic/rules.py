"""Findings of motion that is commanded cycle by cycle; each says how the arm stands."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

BAD_TRAJECTORY = error(
    "CN701",
    "the trajectory cannot be followed: {reason}; nothing was sent",
    "put it right, or simulate the program again",
)
NO_ROW_UNIT = error(
    "CN705",
    "the trajectory cannot be followed: {reason}; nothing was sent",
    'state it: Trajectory.of_joints(rows, times, unit="deg"), or unit="rad", robot=… for radians '
    "as of roboticstoolbox and numpy",
)
NO_ROBOT_OF_ROWS = error(
    "CN706",
    "the trajectory cannot be followed: only its robot tells which columns in radians are metres "
    "of an axis that slides; nothing was sent",
    'name it: Trajectory.of_joints(rows, times, unit="rad", robot=assistant.robots.get("rv-4frl"))',
)
BAD_LIMITS = error(
    "CN702",
    "the limits cannot be used: {reason}; nothing was sent",
    "give a speed and an acceleration above 0 for each joint, or for position and turning",
)
NOT_SOFT = error(
    "CN703",
    "the arm is {distance:.1f} {unit} away from the first point in {what}, more than the "
    "{most:g} {unit} that a soft start may go; nothing was moved",
    "move the arm near the first point, or, from Python, allow more with `Settings(approach=…)`",
)
BAD_SETTING = error(
    "CN704", "`{name}` cannot be {value}: {reason}; nothing was sent", "give another one"
)
NO_ANSWER = error(
    "CN711",
    "{address} does not answer: {reason}; nothing was moved",
    "check the address, that the program on the controller runs and waits for packets, and that "
    "no firewall is in between",
)
SILENT = error(
    "CN712",
    "the controller sent nothing for {seconds:.2f} s, {done} of {rows} points in; it was told to "
    "end, and a controller without packets holds its position",
    "look at the controller: an error or the stop button, the cable, or a program that ended",
)
STOPPED = error(
    "CN713",
    "the controller no longer follows ({reason}), {done} of {rows} points in; the arm was held "
    "and the control ended",
    "look at what the controller says, put it right, then start from where the arm is",
)
NOT_THERE = error(
    "CN714",
    "the arm is {distance:.2f} {unit} away from where it was told to be in {what}, {done} of "
    "{rows} points in; it was held and the control ended",
    "look for what keeps the arm from following, or, from Python, allow more with "
    "`Settings(lag=…)`",
)
INTERRUPTED = error(
    "CN715",
    "stopped on request, {done} of {rows} points in; the arm was brought to rest on its way and "
    "the control ended",
    "start from where the arm is",
)
BROKEN = error(
    "CN716",
    "the loop failed: {reason}; a controller that is left without packets holds its position",
    "look at where the arm stands before the next motion",
)
GARBLED = error(
    "CN717",
    "{count} packets in a row made no sense ({sample}), {done} of {rows} points in; the arm was "
    "held and the control ended",
    "check that nothing else sends to this port",
)
LEFT = error(
    "CN718",
    "the program that asked for the motion gave no sign of life any more, {done} of {rows} points "
    "in; the arm was brought to rest on its way and the control ended",
    "do not stop (Ctrl-Z) or overload that program; start from where the arm is",
)
OTHER_CYCLE = error(
    "CN719",
    "the controller takes a point every {found:.3g} ms, and the motion has one for every "
    "{stated:.3g} ms: the arm would move {times:.1f} times as fast; it was brought to rest, "
    "{done} of {rows} points in",
    "state the cycle of the controller with `--cycle`, such as 0.0035 s for a CR800",
)
PRIORITY = warning(
    "CN721",
    "the loop ran with the priority of any other program: {reason}",
    "allow real-time priority (`rtprio` in limits.conf, or CAP_SYS_NICE), or keep the machine idle",
)
MISSED = warning(
    "CN722",
    "{late} of {cycles} answers came later than half a cycle, {without} in a row never came",
    "give the loop real-time priority and a core that nothing else uses",
)
ERRORS: Final = {
    rule.code: rule
    for rule in (
        NOT_SOFT,
        NO_ANSWER,
        SILENT,
        STOPPED,
        NOT_THERE,
        INTERRUPTED,
        LEFT,
        OTHER_CYCLE,
        BROKEN,
        GARBLED,
    )
}
"""Errors that the loop's process can end with, by code."""
