"""Real-time control and the real-time monitor of a virtual CR controller: what it has of UDP."""

from __future__ import annotations

import socket
from typing import Final

import numpy as np

from assistant.virtual.cr.mxt import CYCLE
from assistant.virtual.cr.mxt_arm import MxtArm
from assistant.virtual.cr.mxt_command import Enet, mxt_commands
from assistant.virtual.cr.mxt_monitor import MxtMonitor
from assistant.virtual.cr.state import CrState
from assistant.virtual.melfa.lines import Line

CYCLE_TIMES: Final = {"melfa-basic-6": 0.0035}
"""Language → seconds of a cycle: CR800; 7.11 ms of all others (BFP-A3379-A, 2.2.2)."""


class RealTime:
    """lines, commands: for programs. port: UDP, of `Mxt`, 0 for any that is free.

    monitor_port: of the monitor, which is there where MONMODE is 1 as the controller starts.
    """

    def __init__(self, state: CrState, host: str, port: int, monitor_port: int) -> None:
        self._state, self._host, self._monitor_port = state, host, monitor_port
        self.port = port or _free_port(host)
        self.cycle = CYCLE_TIMES.get(state.language, CYCLE)
        self._monitor: MxtMonitor | None = None
        self.lines: dict[str, Line] = {"ENET:": Enet()}
        self.commands = mxt_commands(
            host=host,
            port=self.port,
            cycle=self.cycle,
            timeout=lambda: int(state.parameters["MXTTOUT"][0]),
        )

    @property
    def monitor_port(self) -> int | None:
        """None while there is no monitor."""
        return None if self._monitor is None else self._monitor.port

    def start(self) -> None:
        """Begins to tell of the arm; raises OSError if the port is taken."""
        if self._state.parameters["MONMODE"] == ("1",):
            self._monitor = MxtMonitor(
                self._arm, host=self._host, port=self._monitor_port, cycle=self.cycle
            )
            self._monitor.__enter__()

    def shut(self) -> None:
        monitor, self._monitor = self._monitor, None
        if monitor is not None:
            monitor.__exit__()

    def _arm(self) -> MxtArm:
        """The arm as it stands now."""
        return MxtArm(self._state.robot, np.array(self._state.joints), self.cycle)


def _free_port(host: str) -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])
