"""Servo an arm to a goal with cameras: `servo`.

The motion ends when the tool is seen at its goal, when the operator ends it, or when the cameras
do not see well enough. What was recorded is written however it ends.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Refused, error
from assistant.cli.arm_motion import NO_RECORDING, RECORDING_SUFFIXES, moving, progress_bar
from assistant.cli.controller_session import confirm, record, robot_of_cell
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.controllers import Programs
    from assistant.controllers.setpoint_streams import Mode
    from assistant.controllers.trajectory_execution import LinkOptions
    from assistant.robots import Robot
    from assistant.vision.servoing.servo_loop import ServoResult


_NO_SERVO_MODE: Final = error(
    "CL530", "no arm is led step by step by `{by}`", "choose one of {known}"
)
_SERVO_WITHOUT_ROBOT: Final = error(
    "CL531",
    "no project says which robot `{name}` moves, so it cannot be led",
    "write robot = NAME into its table in assistant.toml",
)
_ENDS_BEFORE_MOTION: Final = frozenset({"VS201", "VS208"})
"""Codes of servoing that ends before the first step."""


@dataclass(frozen=True, slots=True)
class ServoOptions:
    """cameras: their file. by: name of a mode. log: file of what was recorded, or None."""

    cameras: Path
    by: str
    log: Path | None
    wishes: LinkOptions
    yes: bool
    format: Format


def run_servo(cell: str, task: Path, options: ServoOptions) -> int:
    """Sets it up, asks, and leads the arm; what was recorded is written however it ends."""
    from assistant.vision.cameras.camera_file import read_cameras
    from assistant.vision.servoing.servo_loop import ServoStopped, servo
    from assistant.vision.servoing.servo_task import open_eyes, read_servo, set_up_servo

    mode = _servo_mode(options)
    file, rig = read_servo(task), read_cameras(options.cameras)
    with moving(cell, "servo") as motion:
        there = motion.cell
        robot = robot_of_cell(there.one)
        if robot is None:
            raise Refused(_SERVO_WITHOUT_ROBOT(name=there.one.name), exit_status=2)
        session: Programs = there.controller if mode.operates else there.session
        mode.check(session, options.wishes)
        setting = set_up_servo(file, rig, robot)
        begin = joints_nearby(session, robot)
        carrier = mode.make(session, setting.guard.arm(), options.wishes, begin)
        with ExitStack() as open_:
            eyes = open_.enter_context(open_eyes(setting, carrier.joints))
            names = ", ".join(camera.name for camera in setting.cameras)
            what = f"leads the arm by what camera {names} sees"
            print_findings([*mode.faster(setting.guard.arm(), str(there.one.address))])
            confirm(there.one, f"{what}: {setting.title}, {mode.title}", options.yes)
            motion.began = True
            try:
                open_.enter_context(carrier)
                progress = open_.enter_context(progress_bar(f"servoing {task}", options.format))
                parts = (eyes, setting.law, carrier, setting.guard, file.settings)
                done = servo(*parts, progress=progress)
            except ServoStopped as broken:
                motion.began = (
                    not {finding.code for finding in broken.findings} <= _ENDS_BEFORE_MOTION
                )
                _write_recording(broken.served, options)
                raise
            except Refused as refused:
                motion.began = not {finding.code for finding in refused.findings} <= mode.unbegun
                raise
    _write_recording(done, options)
    _print_result(there.one.name, str(there.one.address), done, options)
    return 0


def _servo_mode(options: ServoOptions) -> Mode:
    from assistant.controllers.recording import check_place

    if options.log is not None and options.log.suffix.lower() not in RECORDING_SUFFIXES:
        raise Refused(NO_RECORDING(name=options.log), exit_status=2)
    if options.log is not None:
        check_place(options.log)
    return setpoint_mode(options.by)


def setpoint_mode(by: str) -> Mode:
    """Return the mode of that name to lead an arm; raises Refused."""
    from assistant.controllers.setpoint_streams import MODES

    if by not in MODES:
        raise Refused(_NO_SERVO_MODE(by=by, known=", ".join(MODES)), exit_status=2)
    return MODES[by]


def joints_nearby(session: Programs, robot: Robot) -> Floats:
    """Return joints near those of the arm: its own, if the controller reports them."""
    from assistant.compiler.taught_targets import own_joints
    from assistant.controllers import Controller

    if isinstance(session, Controller):
        return np.array(own_joints(session.position(), robot))
    return robot.home


def _write_recording(served: ServoResult | None, options: ServoOptions) -> None:
    if options.log is not None and served is not None:
        served.save(options.log)


def _print_result(name: str, address: str, done: ServoResult, options: ServoOptions) -> None:
    if options.format is Format.JSON:
        print_json(record(_result_record(address, done)))
        return
    x, y, z = done.pose.position
    say(f"{name}: at its goal, {done}")
    say(f"the tip is at ({x:.2f}, {y:.2f}, {z:.2f}) mm")
    if options.log is not None:
        say(f"wrote {options.log}")


def _result_record(address: str, done: ServoResult) -> dict[str, Any]:
    left = {"pixels": done.pixels, "mm": done.distance, "degrees": done.turn}
    return {
        "address": address,
        "joints": done.joints.tolist(),
        "position": list(done.pose.position),
        "quaternion": list(done.pose.quaternion),
        "left": {key: value for key, value in left.items() if np.isfinite(value)},
        "pictures": done.pictures,
        "seconds": done.seconds,
    }
