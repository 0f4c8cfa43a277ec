"""Servo an arm to a goal with cameras: `servo`.

The motion ends when the tool is seen at its goal, when the operator ends it, or when the cameras
do not see well enough. What was recorded is written however it ends.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.arm_motion import (
    LinkedOptions,
    RecordingOption,
    check_recording,
    moving,
    progress_bar,
    servo_modes,
)
from assistant.cli.command import argument, command, option
from assistant.cli.controller_session import (
    CellArgument,
    Session,
    YesOption,
    confirm,
    named_by,
    print_there,
    robot_of_cell,
)
from assistant.cli.options import FormatOption
from assistant.cli.presentation import print_findings

if TYPE_CHECKING:
    from assistant.base.arrays import Floats
    from assistant.controllers import Programs
    from assistant.controllers.setpoint_streams import Mode
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


@command
class Servo:
    """Lead an arm by what cameras see, to its goal. Asks before; Ctrl-C stops the arm."""

    cell: CellArgument
    task: Path = argument("File of what is led where.", metavar="SERVO.toml")
    cameras: Path = option("File of the cameras.", metavar="CAMERAS.toml")
    by: str = option("Way to lead it.", choices=servo_modes)
    log: RecordingOption
    link: LinkedOptions
    yes: YesOption
    format: FormatOption

    def run(self) -> int:
        """Sets it up, asks, and leads the arm; what was recorded is written however it ends."""
        from assistant.controllers.controller import require_lasting
        from assistant.vision.cameras.camera_file import read_cameras
        from assistant.vision.servoing.live_cameras import require_sources
        from assistant.vision.servoing.servo_loop import ServoStopped, servo
        from assistant.vision.servoing.servo_task import open_eyes, read_servo, set_up_servo

        check_recording(self.log)
        mode, wishes = setpoint_mode(self.by), self.link.wishes
        file, rig = read_servo(self.task), read_cameras(self.cameras)
        named = named_by(self.cell)
        robot = robot_of_cell(named)
        if robot is None:
            raise Refused(_SERVO_WITHOUT_ROBOT(name=named.name), exit_status=2)
        setting = set_up_servo(file, rig, robot)
        require_sources(setting.cameras, rig.sources)
        require_lasting(named)
        with moving(self.cell, "servo") as motion:
            there = motion.cell
            session: Programs = there.controller if mode.operates else there.session
            mode.check(session, wishes)
            begin = joints_nearby(session, robot)
            carrier = mode.make(session, setting.guard.arm(), wishes, begin)
            with ExitStack() as open_:
                eyes = open_.enter_context(open_eyes(setting, carrier.joints))
                names = ", ".join(camera.name for camera in setting.cameras)
                what = f"leads the arm by what camera {names} sees"
                print_findings([*mode.faster(setting.guard.arm(), str(there.one.address))])
                confirm(there.one, f"{what}: {setting.title}, {mode.title}", self.yes)
                motion.began = True
                try:
                    open_.enter_context(carrier)
                    progress = open_.enter_context(
                        progress_bar(f"servoing {self.task}", self.format)
                    )
                    parts = (eyes, setting.law, carrier, setting.guard, file.settings)
                    done = servo(*parts, progress=progress)
                except ServoStopped as broken:
                    motion.began = (
                        not {finding.code for finding in broken.findings} <= _ENDS_BEFORE_MOTION
                    )
                    self._save(broken.served)
                    raise
                except Refused as refused:
                    motion.began = (
                        not {finding.code for finding in refused.findings} <= mode.unbegun
                    )
                    raise
        self._save(done)
        self._print(there, done)
        return 0

    def _save(self, served: ServoResult | None) -> None:
        if self.log is not None and served is not None:
            served.save(self.log)

    def _print(self, there: Session, done: ServoResult) -> None:
        x, y, z = done.pose.position
        lines = [
            f"{there.one.name}: at its goal, {done}",
            f"the tip is at ({x:.2f}, {y:.2f}, {z:.2f}) mm",
            *([] if self.log is None else [f"wrote {self.log}"]),
        ]
        print_there(there, self.format, _result_record(done), lines)


def setpoint_mode(by: str) -> Mode:
    """Return the mode of that name to lead an arm; raises Refused."""
    from assistant.controllers.setpoint_streams import MODES

    if by not in MODES:
        raise Refused(_NO_SERVO_MODE(by=by, known=", ".join(MODES)), exit_status=2)
    return MODES[by]


def joints_nearby(session: Programs, robot: Robot) -> Floats:
    """Return joints near those of the arm: its own, if the controller reports them."""
    import numpy as np

    from assistant.compiler.taught_targets import own_joints
    from assistant.controllers import Controller

    if isinstance(session, Controller):
        return np.array(own_joints(session.position(), robot))
    return robot.home


def _result_record(done: ServoResult) -> dict[str, Any]:
    import numpy as np

    left = {"pixels": done.pixels, "mm": done.distance, "degrees": done.turn}
    return {
        "joints": done.joints.tolist(),
        "position": list(done.pose.position),
        "quaternion": list(done.pose.quaternion),
        "left": {key: value for key, value in left.items() if np.isfinite(value)},
        "pictures": done.pictures,
        "seconds": done.seconds,
    }
