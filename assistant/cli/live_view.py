"""`view --live`: the page of a program follows a controller, which is only looked at."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Callable
from threading import Thread
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Refused, error
from assistant.base.termination import is_ctrl_c
from assistant.cli.cells import Session, connected, robot_of_cell, state_lines
from assistant.cli.presentation import Format, print_json, say

if TYPE_CHECKING:
    from assistant.controllers.states import Position, Sample
    from assistant.robots import Robot
    from assistant.view.live import LivePage

OTHER_ROBOT: Final = error(
    "CL047",
    "`{name}` moves a {there} by the project, and the program is shown on a {robot}",
    "name the controller of that robot, or the robot of this one with --robot",
)
OTHER_AXES: Final = error(
    "CL048",
    "`{name}` tells of the axes {there}, and a {robot} has {own}",
    "name the robot that it moves with --robot",
)
NOT_SERVED: Final = error(
    "CL049", "the page cannot be served on this computer: {reason}", "try it again"
)
LIVE_PERIOD: Final = 0.1
"""Seconds between two looks at the controller."""
ARM_AXES: Final = 6
"""Axes that a controller counts to the arm; those behind them are additional ones."""


def run_live(
    address: str, robot: Robot, page: Callable[[str], str], answer: dict[str, Any], format: Format
) -> None:
    """Serves a page until Ctrl-C or until the controller is lost, and tells it where the arm is.

    page: its text, of the name of the controller. answer: what `--format json` tells of the
    program. Raises Refused for a controller that is not reached, or that moves another robot.
    """
    from assistant.view.live import LivePage

    with connected(address, "view --live") as there:
        name = there.one.name
        _check_robot(there, robot)
        _check_axes(name, robot, there.controller.position())
        served = LivePage(page(name))
        try:
            served.__enter__()
        except OSError as failed:
            reason = failed.strerror or str(failed)
            raise Refused(NOT_SERVED(reason=reason)) from None
        try:
            _announce_page(name, served, answer, format)
            _follow_controller(there, robot, served)
        except KeyboardInterrupt as caught:
            if not is_ctrl_c(caught):
                raise
        except Refused as refused:
            served.tell("lost", {"text": refused.findings[0].message})
            raise
        finally:
            served.__exit__(None, None, None)


def _announce_page(name: str, served: LivePage, answer: dict[str, Any], format: Format) -> None:
    if format is Format.JSON:
        print_json(answer | {"follows": name, "address": served.address})
    else:
        say(f"following {name} on {served.address}, listening there until Ctrl-C")
    sys.stdout.flush()
    # A browser of the terminal would come back only when it is closed.
    Thread(target=webbrowser.open, args=(served.address,), daemon=True).start()


def _follow_controller(there: Session, robot: Robot, served: LivePage) -> None:
    before = 0.0
    for sample in there.controller.watch(LIVE_PERIOD):
        joints = _arm_joints(robot, sample.position)
        if joints is not None:
            interval = max(LIVE_PERIOD, sample.seconds - before)
            served.tell("sample", _state_record(there.one.name, robot, joints, sample, interval))
            before = sample.seconds


def _state_record(
    name: str, robot: Robot, joints: list[float], sample: Sample, interval: float
) -> dict[str, Any]:
    from assistant.base.source_text import visible

    return {
        "joints": robot.chained(np.array([joints]))[0].tolist(),
        "state": visible(f"{name}: {'; '.join(state_lines(sample.state))}"),
        "interval": interval,
    }


def _check_robot(there: Session, robot: Robot) -> None:
    said = robot_of_cell(there.one)
    if said is not None and said.name != robot.name:
        finding = OTHER_ROBOT(name=there.one.name, there=said.title, robot=robot.title)
        raise Refused(finding, exit_status=2)


def _check_axes(name: str, robot: Robot, position: Position) -> None:
    there = [i for i, joint in enumerate(position.joints) if joint is not None]
    if [i for i in there if i < max(ARM_AXES, len(robot.axes))] != list(robot.places):
        told = ", ".join(f"J{i + 1}" for i in there) or "none"
        own = ", ".join(robot.axes)
        finding = OTHER_AXES(name=name, there=told, robot=robot.title, own=own)
        raise Refused(finding, exit_status=2)


def _arm_joints(robot: Robot, position: Position) -> list[float] | None:
    """The joints of the arm's axes, None if one is not told at the moment."""
    joints = [position.joints[i] for i in robot.places if i < len(position.joints)]
    known = [joint for joint in joints if joint is not None and np.isfinite(joint)]
    return known if len(known) == len(robot.axes) else None
