"""What a virtual CR controller is and does: arm, slots, alarm, operation right."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.program.rotations import to_euler
from assistant.virtual.cr.store import CrProgram, CrRefusal, CrStore

if TYPE_CHECKING:
    from assistant.robots import Robot

TASKMAX: Final = 8
"""Task slots of a controller as delivered; the edit slot is the next one."""
SUFFIXES: Final = {"melfa-basic-4": "MB4", "melfa-basic-5": "MB5", "melfa-basic-6": "MB6"}
"""Language → suffix of the controller's program files."""


@dataclass
class CrState:
    """A controller that all its connections share; `lock` guards every access.

    joints: degrees, one an axis of the robot. selected: task slot → program.
    alarm: number and level (1 high, 2 low, 3 caution) of the present error.
    right: the session that holds the operation right. edited: program → session.
    """

    robot: Robot
    language: str
    store: CrStore
    clock: Callable[[], datetime] = datetime.now
    override: int = 100
    joints: tuple[float, ...] = ()
    alarm: tuple[int, int] | None = None
    selected: dict[int, str] = field(default_factory=dict)
    right: object | None = None
    edited: dict[str, object] = field(default_factory=dict)
    lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def suffix(self) -> str:
        return SUFFIXES[self.language]

    def shown_joints(self) -> list[tuple[str, str]]:
        """Axis and angle as JPOSF shows them; an axis that the arm lacks is `****`."""
        angles = dict(zip(self.robot.axes, self.joints, strict=True))
        names = [f"J{i}" for i in range(1, 7)]
        return [(name, f"{angles[name]:.2f}" if name in angles else "****") for name in names]

    def shown_pose(self) -> list[tuple[str, str]]:
        """X, Y, Z in mm, A, B, C in degrees of the flange; an arm of five axes shows no C."""
        positions, quaternions = self.robot.fk(np.array([self.joints]))
        values = list(positions[0])
        if self.robot.five_axis:
            from assistant.robots.arms.five_axis import to_ab

            values += list(to_ab(positions, quaternions)[0])
        else:
            values += list(to_euler(quaternions[0], "ZYX")[::-1])
        return [(name, f"{value + 0.0:.2f}") for name, value in zip("XYZABC", values, strict=False)]

    def flags(self) -> str:
        from assistant.robots.configurations import to_flags

        one, two = to_flags(self.robot.configuration(np.array([self.joints])))[0]
        return f"{one},{two}"

    def released(self, session: object) -> None:
        """Forgets what a session held."""
        if self.right is session:
            self.right = None
        self.edited = {name: s for name, s in self.edited.items() if s is not session}


@dataclass(eq=False)
class CrSession:
    """One connection: its edit and its place in the listings.

    slot: of the command under way.
    """

    state: CrState
    slot: int = 1
    name: str | None = None
    program: CrProgram = field(default_factory=CrProgram)
    next_line: int = 0
    next_position: int = 0

    @property
    def edit(self) -> CrProgram:
        """The program that is open; raises CrRefusal 4820."""
        if self.name is None:
            raise CrRefusal(4820)
        return self.program

    def open(self, name: str) -> None:
        """Opens a program or a new one; raises CrRefusal 4170 if another session has it open."""
        if self.state.edited.get(name, self) is not self:
            raise CrRefusal(4170)
        self.close()
        self.state.edited[name] = self
        store = self.state.store
        self.name, self.program = name, store[name].copy() if name in store else CrProgram()
        self.next_line = self.next_position = 0

    def close(self) -> None:
        """Throws the edit away."""
        if self.name is not None:
            self.state.edited.pop(self.name, None)
        self.name, self.program = None, CrProgram()

    def hang_up(self) -> None:
        self.close()
        self.state.released(self)
