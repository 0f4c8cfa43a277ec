"""The two virtual cells of the demo: where a program is installed, started and watched."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from assistant.base.arrays import Floats

if TYPE_CHECKING:
    from assistant.controllers import Controller, Programs
    from assistant.controllers.mitsubishi.data_link import Joints
    from assistant.program.geometry import Pose
    from assistant.report.points import Poses
    from assistant.virtual.cr import VirtualCr

ABB: Final = "irb1200-7-0.7"
MITSUBISHI: Final = "rv-2aj"
TIME_FACTOR: Final = 2.0
"""Simulated seconds for each real one."""
LOOK_PERIOD: Final = 0.01
"""Seconds between two looks at an arm."""
JOINT_SENDER: Final = b"""10 WAIT M_RUN(1)=1
20 OPEN "COM2:" AS #1
30 PRINT #1,J_CURR
40 DLY 0.02
50 IF M_RUN(1)=1 THEN 30
60 PRINT #1,J_CURR
70 PRINT #1,"END"
80 CLOSE #1
90 END
"""
"""Sends the joints on a data link while slot 1 runs, as a second task."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A virtual controller with its arm.

    programs: where programs are installed. play: starts the program of a name, and returns the
    joints (n, a) that the arm had until its end.
    """

    robot: str
    programs: Programs
    play: Callable[[str], Floats]

    def seen(self, name: str, tip: Pose) -> Poses:
        """Return the poses of the tip of a tool while the program of that name runs."""
        from assistant import robots
        from assistant.base import rotations
        from assistant.report.points import Poses

        flange, turns = robots.get(self.robot).fk(self.play(name))
        tips = flange + rotations.rotate(turns, np.array(tip.position))
        return Poses(tips, rotations.multiply(turns, np.array(tip.quaternion)))


def start_cells(stack: ExitStack) -> Mapping[str, Cell]:
    """Start a controller for each robot, both empty, until `stack` is closed."""
    from assistant.controllers import connect
    from assistant.virtual.cr import VirtualCr
    from assistant.virtual.irc5 import VirtualIrc5

    home = stack.enter_context(tempfile.TemporaryDirectory(prefix="robot-assistant-home-"))
    irc5 = stack.enter_context(VirtualIrc5(home, rate=TIME_FACTOR / 2.0))  # it is seen more seldom
    cr = stack.enter_context(VirtualCr(MITSUBISHI, pace=TIME_FACTOR))

    def play_rapid(name: str) -> Floats:
        with connect(irc5.rws_address, password=irc5.password) as controller:
            return _run_and_watch(cast("Controller", controller), name)

    return {
        ABB: Cell(ABB, connect(irc5.address, password=irc5.password), play_rapid),
        MITSUBISHI: Cell(MITSUBISHI, connect(cr.address), lambda name: _run_and_receive(cr, name)),
    }


def _run_and_watch(controller: Controller, name: str) -> Floats:
    """Run a program and ask for the joints, by the line that it was started on."""
    controller.load(name)
    controller.motors(True)
    controller.start()
    rows = []
    for sample in controller.watch(LOOK_PERIOD):
        rows.append(sample.position.joints)
        if not sample.state.running:
            break
    controller.motors(False)
    return np.array(rows, dtype=np.float64)


def _run_and_receive(cr: VirtualCr, name: str) -> Floats:
    """Run a program, and have a second one send the joints on a data link meanwhile.

    The line of the commands answers five times a second, and a data link as often as is sent.
    """
    from assistant import robots
    from assistant.controllers import connect
    from assistant.controllers.mitsubishi.data_link import DataLink, Form

    form = Form.parse("J_CURR")
    host, port = cr.data_ports["COM2:"]
    rows = []
    with cast("Controller", connect(cr.address)) as controller:
        controller.write("STATUS", JOINT_SENDER)
        controller.load("STATUS", task="2")
        controller.load(name)
        controller.motors(True)
        controller.start("2")
        with DataLink(f"{host}:{port}") as line:
            controller.start("1")
            while (text := line.receive()) != "END":
                (joints,) = form.read(text)
                rows.append(cast("Joints", joints).values)
        controller.motors(False)
    return np.array(rows, dtype=np.float64)[:, list(robots.get(MITSUBISHI).places)]
