"""Externally Guided Motion as the loop of cyclic control sees it.

The controller is the client: it sends `EgmRobot` each 4 ms to the address of its UdpUc device, and
takes the `EgmSensor` that comes back (manual 3HAC073318; states as in ros-industrial/abb_libegm).
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from assistant.controllers.abb.egm.messages import Message, decode, encode
from assistant.controllers.cyclic import Measured
from assistant.controllers.cyclic.space import POSE_COLUMNS, Kind

CORRECTION: Final = 3
"""MSGTYPE_CORRECTION: position guidance by a sensor."""
MOTORS_OFF: Final = 2
EGM_ERROR, EGM_RUNNING = 1, 3
RAPID_STOPPED: Final = 1
"""RAPID is `undefined` after each restart of a controller although it runs (abb_libegm, #96)."""
ROBOT_AXES: Final = 6
"""What `joints` holds; the others are in `externalJoints`."""
COUNTER_WRAP: Final = 1 << 32


@dataclass(frozen=True, slots=True)
class Egm:
    r"""The packets of one guidance.

    kind: joints in degrees, or poses as x, y, z in mm with w, x, y, z, in the frames of EGMActPose.
    axes: of the joints, additional ones (degrees or mm) behind the six of the robot.
    cycle: seconds, \SampleRate of EGMActJoint or EGMActPose.
    """

    kind: Kind = "joints"
    axes: int = ROBOT_AXES
    cycle: float = 0.004
    speaks_first: bool = True
    recorded: tuple[str, ...] = ("tm", "converged", "utilization")

    def hello(self, count: int) -> bytes:  # noqa: ARG002
        """Nothing: the controller speaks first."""
        return b""

    def read(self, packet: bytes) -> Measured | None:
        try:
            message = decode("EgmRobot", packet)
        except ValueError:
            return None
        values = self._values(message)
        seqno = message.all("header", "seqno")
        if values is None or not seqno or not all(map(math.isfinite, values)):
            return None
        stopped = _stopped(message)
        ready = _state(message, "mciState") == EGM_RUNNING
        if not ready and not stopped:
            stopped = "its EGM does not run (any more)"
        extra = (
            next(iter(message.all("header", "tm")), math.nan),
            message.number("mciConvergenceMet") or 0.0,
            _finite(message.number("utilizationRate")),
        )
        return Measured(values, int(seqno[-1]) % COUNTER_WRAP, 0, stopped, ready, extra)

    def command(self, values: Sequence[float], count: int) -> bytes:
        milliseconds = time.monotonic_ns() // 1_000_000
        header = Message(
            {
                "seqno": [count % COUNTER_WRAP],
                "tm": [milliseconds % COUNTER_WRAP],
                "mtype": [CORRECTION],
            }
        )
        if self.kind == "poses":
            x, y, z, *turn = values
            place = Message({"x": [x], "y": [y], "z": [z]})
            orient = Message({f"u{i}": [part] for i, part in enumerate(turn)})
            planned = {"cartesian": Message(parts={"pos": place, "orient": orient})}
        else:
            planned = {"joints": Message({"joints": list(values[:ROBOT_AXES])})}
            if len(values) > ROBOT_AXES:
                planned["externalJoints"] = Message({"joints": list(values[ROBOT_AXES:])})
        sensor = Message(parts={"header": header, "planned": Message(parts=planned)})
        return encode("EgmSensor", sensor)

    def end(self, values: Sequence[float], count: int) -> bytes | None:  # noqa: ARG002
        """None: the controller ends when the arm has converged, or when nothing comes any more."""
        return None

    def _values(self, message: Message) -> tuple[float, ...] | None:
        """Where the arm is, None if the message does not say all of it."""
        if self.kind == "poses":
            pose = ("feedBack", "cartesian")
            place = [message.all(*pose, "pos", name)[-1:] for name in "xyz"]
            turn = [message.all(*pose, "orient", f"u{i}")[-1:] for i in range(4)]
            found = tuple(value for part in (*place, *turn) for value in part)
            return found if len(found) == POSE_COLUMNS else None
        own = message.all("feedBack", "joints", "joints")
        more = message.all("feedBack", "externalJoints", "joints")
        found = (*own[:ROBOT_AXES], *more)
        return found[: self.axes] if len(found) >= self.axes else None


def _state(message: Message, name: str) -> float | None:
    return next(iter(message.all(name, "state")[-1:]), None)


def _stopped(message: Message) -> str:
    """What keeps the arm from moving whatever is sent, "" for nothing."""
    if _state(message, "motorState") == MOTORS_OFF:
        return "its motors are off"
    if _state(message, "mciState") == EGM_ERROR:
        return "its EGM reports an error"
    if _state(message, "rapidExecState") == RAPID_STOPPED:
        return "its program is stopped"
    return ""


def _finite(value: float | None) -> float:
    return value if value is not None and math.isfinite(value) else math.nan
