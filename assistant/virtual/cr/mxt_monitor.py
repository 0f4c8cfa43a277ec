"""The real-time monitor of a controller (BFP-A3379-A, 5): packets in each cycle to who asked last.

with MxtMonitor(lambda: arm, bits) as monitor:
    Monitor("127.0.0.1", port=monitor.port)
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Final, Self

import numpy as np

from assistant.virtual.cr.mxt import CYCLE, Bits, Signals
from assistant.virtual.cr.mxt_arm import PULSES, MxtArm

MONITOR_BLOCK: Final = "V40"
MONITOR_PACKET: Final = np.dtype(
    [
        ("Command", "<u2"),
        ("reserve0", "<u2"),
        ("Type1", "<u2"),
        ("reserve1", "<u2"),
        ("Data1", MONITOR_BLOCK),
        ("InputTop", "<u2"),
        ("OutputTop", "<u2"),
        ("Input", "<u4"),
        ("Output", "<u4"),
        ("Counter", "<u4"),
        ("Type2", "<u2"),
        ("reserve2", "<u2"),
        ("Data2", MONITOR_BLOCK),
        ("Type3", "<u2"),
        ("reserve3", "<u2"),
        ("Data3", MONITOR_BLOCK),
        ("Type4", "<u2"),
        ("reserve4", "<u2"),
        ("Data4", MONITOR_BLOCK),
    ]
)
assert MONITOR_PACKET.itemsize == 196
MONITOR_START: Final = 1
MONITOR_END: Final = 255
ROBMON: Final = np.dtype(
    [
        ("moving", "<f4", 5),
        ("states", "<i2", 3),
        ("program", "S6"),
        ("temperature", "<i2"),
        ("unused", "<u2"),
        ("counter", "<u4"),
    ]
)
TEMPERATURE: Final = 352
"""Tenths of a degree in the controller, which is not simulated."""
FEEDBACK: Final = frozenset((7, 8, 9, 1007, 1008))
DEGREES: Final = 1000
"""From here on angles are degrees."""


class MxtMonitor:
    """arm: gives where it is now. program: name and step of slot 1. port: UDP, 0 for any."""

    def __init__(
        self,
        arm: Callable[[], MxtArm],
        signals: Signals | None = None,
        *,
        program: Callable[[], tuple[str, int]] = lambda: ("", 0),
        host: str = "127.0.0.1",
        port: int = 0,
        cycle: float = CYCLE,
    ) -> None:
        self._arm, self._program = arm, program
        self._signals = signals or Bits()
        self._place, self._cycle = (host, port), cycle
        self._over = threading.Event()
        self._counter = 0
        self._sent = 0

    def __enter__(self) -> Self:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(self._place)
        self._socket.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="mxt-monitor", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1])

    def _run(self) -> None:
        asked: tuple[np.void, tuple[str, int]] | None = None
        while not self._over.wait(self._cycle):
            self._counter += 1
            asked = self._heard(asked)
            if asked is not None:
                packet, receiver = asked
                try:
                    self._socket.sendto(self._told(packet), receiver)
                except OSError:
                    asked = None

    def _heard(
        self, asked: tuple[np.void, tuple[str, int]] | None
    ) -> tuple[np.void, tuple[str, int]] | None:
        while True:
            try:
                data, sender = self._socket.recvfrom(2048)
            except BlockingIOError:
                return asked
            except ConnectionError:
                continue
            if len(data) != MONITOR_PACKET.itemsize:
                continue
            packet = np.frombuffer(data, MONITOR_PACKET)[0]
            if int(packet["Command"]) == MONITOR_START:
                asked = (packet, sender)
            elif int(packet["Command"]) == MONITOR_END:
                asked = None

    def _told(self, packet: np.void) -> bytes:
        self._sent += 1
        told = np.zeros((), MONITOR_PACKET)
        for name in ("Command", "InputTop", "OutputTop"):
            told[name] = packet[name]
        told["Input"] = self._word(2, int(packet["InputTop"]))
        told["Output"] = self._word(1, int(packet["OutputTop"]))
        told["Counter"] = self._sent & 0xFFFFFFFF
        for i in range(1, 5):
            told[f"Type{i}"] = packet[f"Type{i}"]
            told[f"Data{i}"] = self._data(int(packet[f"Type{i}"]))
        return told.tobytes()

    def _word(self, kind: int, first: int) -> int:
        low, high = self._signals.read(kind, first), self._signals.read(kind, first + 16)
        return low | high << 16

    def _data(self, kind: int) -> bytes:
        """40 bytes of a data type; zeros of those that a simulated arm has nothing to tell of."""
        arm = self._arm()
        joints = arm.fed_back if kind in FEEDBACK else arm.commanded
        numbers = np.zeros(10, dtype="<f4")
        match kind % DEGREES:
            case 1 | 7:
                pose = arm.pose(joints)
                pose[3:] = np.degrees(pose[3:]) if kind > DEGREES else pose[3:]
                numbers[:6] = pose
            case 2 | 8:
                numbers[arm.places] = joints if kind > DEGREES else arm.radians(joints)
            case 3 | 9:
                pulses = np.zeros(10, dtype="<i4")
                pulses[arm.places] = np.round(joints * PULSES)
                return pulses.tobytes()
            case 12:
                return self._robot()
        return numbers.tobytes()

    def _robot(self) -> bytes:
        robot = np.zeros((), ROBMON)
        name, step = self._program()
        robot["states"] = (0, 0, step)
        robot["program"] = name.encode("ascii", "replace")[:6]
        robot["temperature"] = TEMPERATURE
        robot["counter"] = self._counter & 0xFFFFFFFF
        return robot.tobytes()
