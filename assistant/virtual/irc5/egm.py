r"""EGM on a virtual controller: an arm that follows what a sensor on the network asks for.

`Guidance` is one movement, step by step in any clock; `VirtualEgm` runs one in a thread in real
time. The arm follows at most as fast as it can, ends when it was close to its target for the
`\CondTime` of EGMRunJoint or EGMRunPose, and stops with event 41822 when nothing comes within the
`\CommTimeout` of EGMSetupUC.
"""

from __future__ import annotations

import math
import socket
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import field
from typing import Final, Literal

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.rotations import between
from assistant.virtual.irc5 import egm_packets as packets
from assistant.virtual.irc5.egm_packets import Kind, RobotState

CYCLE: Final = 0.004
NO_DATA: Final = 41822
"""Event: no data from the UdpUc device."""
End = Literal["converged", "silent", "stopped"]


@dataclass(slots=True)
class Guidance:
    """One movement. values: where the arm is: joints in degrees, or x y z in mm with w x y z.

    speeds: a second, of each joint, or of the tool in mm and degrees. comm_timeout, cond_time:
    seconds. within: degrees (mm) of the convergence.
    waiting: seconds before it takes commands, None until a sensor answers.
    lag: seconds by which the arm is behind, as that of a first-order filter.
    """

    kind: Kind
    values: tuple[float, ...]
    speeds: tuple[float, ...]
    comm_timeout: float = 1.0
    cond_time: float = 1.0
    within: float = 0.5
    waiting: float | None = 0.0
    lag: float = 0.02
    motors: bool = True
    ended: End | None = None
    taken: int = 0
    ignored: int = 0
    _seqno: int = 0
    _clock: float = 0.0
    _heard: float | None = None
    _near: float = 0.0
    _goal: tuple[float, ...] | None = None

    def hear(self, packet: bytes) -> None:
        """Receive a packet from the sensor; ignores packets that are invalid."""
        heard = packets.read_sensor_packet(packet, self.kind, len(self.values))
        if heard is None:
            self.ignored += 1
            return
        self.taken += 1
        self._heard = self._clock
        if self._running:
            self._goal = heard.values

    def step(self, seconds: float) -> bytes:
        """Advance time: move the arm and return the packet that reports it."""
        self._clock += seconds
        if self.motors and self._running and self._goal is not None:
            self.values = self._moved(self._goal, seconds)
        self._look(seconds)
        told = RobotState(
            seqno=self._seqno,
            tm=round(self._clock * 1000),
            measured=self.values,
            planned=self._goal or self.values,
            motors=packets.MOTORS_ON if self.motors else packets.MOTORS_OFF,
            mci=packets.MCI_RUNNING if self._running else packets.MCI_STOPPED,
            rapid=packets.RAPID_RUNNING if self.motors else packets.RAPID_STOPPED,
            converged=self._near > 0.0,
        )
        self._seqno += 1
        return packets.robot_packet(told, self.kind)

    @property
    def _running(self) -> bool:
        return self.motors and self._clock >= self._begin and self.ended is None

    @property
    def _begin(self) -> float:
        if self.waiting is not None:
            return self.waiting
        return math.inf if self._heard is None else 0.0

    def _look(self, seconds: float) -> None:
        """Check whether the guidance is over."""
        if not self._running:
            self._near = 0.0
            return
        # The time-out counts from the begin at the earliest: a sensor may start late.
        if self._clock - max(self._heard or 0.0, self._begin) > self.comm_timeout:
            self.ended = "silent"
        elif self._goal is not None and self._away(self._goal) <= self.within:
            self._near += seconds
            if self._near >= self.cond_time:
                self.ended = "converged"
        else:
            # Convergence has to last without interruption.
            self._near = 0.0

    def _away(self, goal: Sequence[float]) -> float:
        if self.kind == "joints":
            return max(abs(a - b) for a, b in zip(goal, self.values, strict=True))
        return max(math.dist(goal[:3], self.values[:3]), _turn(self.values[3:], goal[3:]))

    def _moved(self, goal: tuple[float, ...], seconds: float) -> tuple[float, ...]:
        if self.kind == "joints":
            return tuple(
                at + math.copysign(self._way(abs(to - at), speed, seconds), to - at)
                for at, to, speed in zip(self.values, goal, self.speeds, strict=True)
            )
        away, turn = math.dist(goal[:3], self.values[:3]), _turn(self.values[3:], goal[3:])
        part = self._way(away, self.speeds[0], seconds) / away if away else 1.0
        place = (a + part * (b - a) for a, b in zip(self.values[:3], goal[:3], strict=True))
        part = self._way(turn, self.speeds[1], seconds) / turn if turn else 1.0
        turned = between(np.array(self.values[3:]), np.array(goal[3:]), np.array(part))
        return (*place, *turned.reshape(-1).tolist())

    def _way(self, away: float, speed: float, seconds: float) -> float:
        """Return the distance covered in that time."""
        # First-order filter: the part of the way that is left decays with time.
        eager = 1.0 - math.exp(-seconds / self.lag) if self.lag > 0.0 else 1.0
        return min(away * eager, speed * seconds)


def _turn(one: Sequence[float], two: Sequence[float]) -> float:
    """Degrees between two quaternions."""
    # q and -q are the same turn; rounding may put the cosine above 1.
    cosine = abs(sum(a * b for a, b in zip(one, two, strict=True)))
    return math.degrees(2.0 * math.acos(min(1.0, cosine)))


@dataclass
class VirtualEgm:
    """A guidance in real time; a context manager. target: where the sensor listens.

    events: numbers of the event log. told: packets that were sent.
    """

    guidance: Guidance
    target: tuple[str, int]
    cycle: float = CYCLE
    local_host: str = "127.0.0.1"
    events: list[int] = field(default_factory=list)
    told: int = 0
    track: list[tuple[float, ...]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="virtual-egm", daemon=True)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((self.local_host, 0))
        self._socket.setblocking(False)

    def __enter__(self) -> VirtualEgm:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.stop()

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()

    def wait(self, seconds: float) -> bool:
        """True if the guidance ends in that time."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def emergency(self) -> None:
        """The emergency stop is pressed: the motors go off, and the program stops."""
        self.guidance.motors = False

    def _run(self) -> None:
        began, last = time.monotonic(), 0
        while not self._over.is_set() and self.guidance.ended is None:
            for _ in range(64):
                try:
                    self.guidance.hear(self._socket.recv(2048))
                except (BlockingIOError, ConnectionRefusedError):
                    break
            # A late thread makes one longer step: time does not fall behind.
            number = max(last + 1, int((time.monotonic() - began) / self.cycle))
            packet = self.guidance.step((number - last) * self.cycle)
            last = number
            self.track.append(self.guidance.values)
            with suppress(OSError):  # nobody listens yet
                self._socket.sendto(packet, self.target)
                self.told += 1
            time.sleep(max(0.0, began + (number + 1) * self.cycle - time.monotonic()))
        if self.guidance.ended == "silent":
            self.events.append(NO_DATA)
