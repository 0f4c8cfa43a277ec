"""What a virtual CR controller is and does: arm, slots, alarm, operation right."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.program.rotations import to_euler
from assistant.virtual.cr.error_log import ErrorLog
from assistant.virtual.cr.parameter_table import Parameters
from assistant.virtual.cr.store import CrProgram, CrRefusal, CrStore
from assistant.virtual.kernel import Board

if TYPE_CHECKING:
    from assistant.robots import Robot

TASKMAX: Final = 8
"""Task slots of a controller as delivered; the edit slot is the next one."""
SUFFIXES: Final = {"melfa-basic-4": "MB4", "melfa-basic-5": "MB5", "melfa-basic-6": "MB6"}
"""Language → suffix of the controller's program files."""


HIGH: Final = 1
"""Level of an error that switches the servos off."""
EMERGENCY: Final = 60
"""Number of the emergency stop of the operating panel (ERRSUM in BFP-A4288)."""
HANDS: Final = 4
"""Hands of two valves each on the signals 900 to 907 (HNDSTS in BFP-A4288)."""


@dataclass(slots=True)
class Cycles:
    """What the runs of a program took. total, latest: milliseconds."""

    total: int = 0
    latest: int = 0
    count: int = 0

    @property
    def fields(self) -> str:
        """As PDIR and CYCLETIME tell them, with the average."""
        mean = self.total // self.count if self.count else 0
        return f"{self.total};{self.latest};{mean};{self.count}"


@dataclass(frozen=True, slots=True)
class SlotNow:
    """A slot at a moment. line: number of the line that comes next. step: its place, from 1.

    runs, waits: neither where its program is reset. ends_cycle: whether it stops at the end of the
    cycle. moves: whether it has the arm. is_task: whether it is none for editing.
    """

    program: str = ""
    line: int = 0
    step: int = 1
    mode: str = "REP"
    runs: bool = False
    waits: bool = False
    ends_cycle: bool = False
    moves: bool = False
    is_task: bool = True


@dataclass
class CrState:
    """A controller that all its connections share; `lock` guards every access.

    joints: degrees, one an axis of the robot. selected: task slot → program.
    alarm: number and level (1 high, 2 low, 3 caution) of the present error.
    right: the session that holds the operation right. edited: program → session.
    shared: variables of all programs. hours: of the meters T (power), S (servos), D (programs),
    B (battery). cycles: program → what its runs took. lines: task slot → the line that its program
    begins with, where that is not the first one. clock_off: seconds that the controller's clock
    was set ahead by. servo_time: seconds until the servos are on. emergency: whether an emergency
    stop is pressed. stop_on: STOPON is latched. may_start: AUEON. slow: SAFE=1.
    real_inputs: what the inputs were before they were made pseudo inputs, None while they are real.
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
    board: Board = field(default_factory=Board)
    log: ErrorLog = field(default_factory=ErrorLog)
    shared: CrProgram = field(default_factory=CrProgram)
    hours: dict[str, int] = field(default_factory=lambda: dict.fromkeys("TSDB", 0))
    cycles: dict[str, Cycles] = field(default_factory=dict)
    lines: dict[int, int] = field(default_factory=dict)
    clock_off: float = 0.0
    servo_time: float = 0.0
    emergency: bool = False
    stop_on: bool = False
    machine_lock: bool = False
    may_start: bool = True
    slow: bool = False
    tool: int = 0
    hands: dict[int, bool] = field(default_factory=lambda: dict.fromkeys(range(1, HANDS + 1), True))
    real_inputs: dict[str, float] | None = None
    lock: threading.RLock = field(default_factory=threading.RLock)
    _servo_since: float | None = None

    def __post_init__(self) -> None:
        self.began = self.clock()
        self.parameters = Parameters(self.robot, self.language, TASKMAX)

    # ----------------------------------------------------------------------------- clock

    def now(self) -> datetime:
        return self.clock() + timedelta(seconds=self.clock_off)

    # ---------------------------------------------------------------------------- errors

    def alert(self, number: int, level: int = 2, program: str = "", line: int = 0) -> None:
        """An error holds from now on, and stands in the history. A high one has the servos off."""
        self.alarm = (number, level)
        self.log.add(self.now(), number, level, program, line)
        if level == HIGH:
            self._servo_since = None

    def reset_error(self) -> None:
        """An emergency stop that is still pressed stays an error."""
        self.alarm = (EMERGENCY, HIGH) if self.emergency else None

    # ---------------------------------------------------------------------------- servos

    @property
    def servo(self) -> bool:
        """Whether the servos are on."""
        since = self._servo_since
        return since is not None and time.monotonic() - since >= self.servo_time

    def switch_servo(self, on: bool) -> None:
        """Raises CrRefusal where they cannot be switched on."""
        if not on:
            self._servo_since = None
            return
        if self.alarm is not None and self.alarm[1] == HIGH:
            raise CrRefusal(5600)
        if self._servo_since is None:
            self._servo_since = time.monotonic()

    @property
    def suffix(self) -> str:
        return SUFFIXES[self.language]

    # ----------------------------------------------------------------------------- slots

    def slot_now(self, number: int) -> SlotNow:
        """How a slot is at this moment."""
        name = self.selected.get(number, "")
        steps = sorted(self.store[name].steps) if name in self.store else []
        line = self.lines.get(number, steps[0] if steps else 0)
        return SlotNow(
            program=name,
            line=line,
            step=steps.index(line) + 1 if line in steps else 1,
            moves=number == 1,
            is_task=1 <= number <= TASKMAX,
        )

    def select(self, slot: int, program: str) -> None:
        self.selected[slot] = program
        self.lines.pop(slot, None)

    def go_to_line(self, slot: int, line: int) -> None:
        self.lines[slot] = line

    def reset_slot(self, slot: int) -> None:
        """The program of a slot begins at its first line."""
        self.lines.pop(slot, None)

    def restart(self) -> None:
        """As if the power was switched off and on: errors, switches and slots are forgotten."""
        self.reset_error()
        self.stop_on = self.machine_lock = self.slow = False
        self.may_start, self.real_inputs = True, None
        self.switch_servo(False)
        self.right = None
        for slot in range(1, TASKMAX + 1):
            self.reset_slot(slot)

    # ------------------------------------------------------------------------- positions

    def move_hand(self, hand: int, opens: bool) -> None:
        self.hands[hand] = opens

    def speed(self) -> float:
        """mm/s of the tool."""
        return 0.0

    def limits_reached(self) -> str:
        """Axes at their upper and lower limits, two hexadecimal digits each, and a reserve."""
        return "00000000"

    def shown_joints(self, *, goal: bool = False) -> list[tuple[str, str]]:
        """Axis and angle as JPOSF shows them; an axis that the arm lacks is `****`.

        goal: where the motion at hand leads.
        """
        del goal
        angles = dict(zip(self.robot.axes, self.joints, strict=True))
        names = [f"J{i}" for i in range(1, 7)]
        return [(name, f"{angles[name]:.2f}" if name in angles else "****") for name in names]

    def shown_pose(self, *, goal: bool = False) -> list[tuple[str, str]]:
        """X, Y, Z in mm, A, B, C in degrees of the flange; an arm of five axes shows no C."""
        del goal
        positions, quaternions = self.robot.fk(np.array([self.joints]))
        values = list(positions[0])
        if self.robot.five_axis:
            from assistant.robots.arms.five_axis import to_ab

            values += list(to_ab(positions, quaternions)[0])
        else:
            values += list(to_euler(quaternions[0], "ZYX")[::-1])
        return [(name, f"{value + 0.0:.2f}") for name, value in zip("XYZABC", values, strict=False)]

    def shown_cylinder(self) -> list[tuple[str, str]]:
        """Radius in mm and angle in degrees about the base in the places of X and Y (RPOSF)."""
        shown = self.shown_pose()
        x, y = (float(value) for _, value in shown[:2])
        radius, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
        return [("R", f"{radius:.2f}"), ("T", f"{angle:.2f}"), *shown[2:]]

    def flags(self) -> str:
        from assistant.robots.configurations import to_flags

        one, two = to_flags(self.robot.configuration(np.array([self.joints])))[0]
        return f"{one},{two}"

    # ------------------------------------------------------------------------- variables

    def program_now(self, name: str) -> CrProgram:
        """A stored program, its variables as they are now."""
        return self.store[name]

    def shared_variables(self) -> CrProgram:
        """The variables of all programs, as they are now."""
        return self.shared

    def set_variable(self, program: str | None, name: str, value: str) -> None:
        """Gives a variable of a program a value; None for one that all programs share."""
        (self.shared if program is None else self.store[program]).keep(name, value)

    def forget(self, program: str) -> None:
        """A program is another one now, or is gone."""
        self.cycles.pop(program, None)

    def released(self, session: object) -> None:
        """Forgets what a session held."""
        if self.right is session:
            self.right = None
        self.edited = {name: s for name, s in self.edited.items() if s is not session}


@dataclass(slots=True)
class BlockFile:
    """A file that FOPEN opened. data: to be read from `at` on, or what was written so far."""

    name: str
    writes: bool
    data: bytearray
    at: int = 0


@dataclass(eq=False)
class CrSession:
    """One connection: its edit and its place in the listings.

    slot: of the command under way. following: by listing, the index behind what was listed last.
    block: the file that is open for blocks. keyword: whether protected parameters are open.
    changed:
    whether the edit differs from what is stored. listed: changed parameters still to be listed.
    """

    state: CrState
    slot: int = 1
    name: str | None = None
    program: CrProgram = field(default_factory=CrProgram)
    following: dict[str, int] = field(default_factory=dict)
    block: BlockFile | None = None
    keyword: bool = False
    changed: bool = False
    listed: list[str] = field(default_factory=list)

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
        self.changed = False
        self.following.clear()

    def close(self) -> None:
        """Throws the edit away."""
        if self.name is not None:
            self.state.edited.pop(self.name, None)
        self.name, self.program = None, CrProgram()

    def hang_up(self) -> None:
        self.close()
        self.block = None
        self.state.released(self)
