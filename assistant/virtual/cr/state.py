"""The state of a virtual CR controller: alarm, operation right, programs, errors, parameters.

`CrState` is shared by all connections, `CrSession` is one of them. The table `errors.tsv` says what
error numbers mean. The table `parameters.tsv` has the parameters that have an effect here or that
tools ask for, with the settings of BFP-A4288 and BFP-A3379 where those state any; COM2 to COM8 lead
to lines of the network. No manual at hand says which parameters a controller protects: here it
protects those of the origin.
"""

from __future__ import annotations

import csv
import io
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field
from datetime import datetime, timedelta
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Final

from assistant.base.data_classes import dataclass
from assistant.virtual.cr.slots_and_arm import Equipment, Machinery
from assistant.virtual.cr.store import CrProgram, CrRefusal, CrStore
from assistant.virtual.kernel import Board

if TYPE_CHECKING:
    from assistant.robots import Robot


_MOST_ERRORS: Final = 128
"""That the history keeps; the oldest go first."""
LEVELS: Final = {"H": 1, "L": 2, "C": 3}


@dataclass(frozen=True, slots=True)
class ErrorEntry:
    """level: 1 high, 2 low, 3 caution. program, line: where it came, empty and 0 for none."""

    when: datetime
    number: int
    level: int
    program: str = ""
    line: int = 0

    @property
    def detail(self) -> str:
        """The number with the detail that nothing here tells, nine digits."""
        return f"{self.number:04}00000"

    @property
    def fields(self) -> str:
        """Return the entry as ERRORLOG lists it."""
        when = f"{self.when:%y-%m-%d;%H:%M:%S}"
        text = error_message(self.number)
        return (
            f"{when};{self.number:04};{text};{self.level};{self.program};{self.line};{self.detail}"
        )


@dataclass
class ErrorLog:
    """entries: the newest first. counts: by number, since the summary was cleared.

    since: when the history and the summary were begun.
    """

    entries: list[ErrorEntry] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    latest: dict[int, datetime] = field(default_factory=dict)
    since: dict[str, datetime] = field(default_factory=dict)

    def add(self, when: datetime, number: int, level: int, program: str, line: int) -> None:
        self.entries.insert(0, ErrorEntry(when, number, level, program, line))
        del self.entries[_MOST_ERRORS:]
        self.counts[number] = self.counts.get(number, 0) + 1
        self.latest[number] = when

    def of(self, level: int, detail: str) -> Sequence[ErrorEntry]:
        """The newest first; of a level, 0 for all, whose details begin as stated."""
        return [e for e in self.entries if level in (0, e.level) and e.detail.startswith(detail)]

    def clear(self, level: int) -> None:
        self.entries = [e for e in self.entries if level not in (0, e.level)]

    def clear_summary(self) -> None:
        self.counts.clear()
        self.latest.clear()


def error_message(number: int) -> str:
    """Return the text of an error number; never fails."""
    return _error_table().get(number, ("", f"Error {number:04}"))[1]


def error_level(number: int) -> int:
    """1 high, 2 low, 3 caution; low where the table does not know the number."""
    return LEVELS.get(_error_table().get(number, ("L", ""))[0], LEVELS["L"])


@cache
def _error_table() -> Mapping[int, tuple[str, str]]:
    """Number → letter of its level, and what it means."""
    # QUOTE_NONE: texts of errors hold quotation marks.
    text = files(__package__).joinpath("errors.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return {int(row["number"]): (row["level"], row["text"]) for row in rows}


VALUE_SEPARATOR: Final = ", "
_PARAMETER_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)", re.ASCII)
_PARAMETER_CHARACTERS: Final = re.compile(r"[ -:<-~]*", re.ASCII)
"""A value takes part in answers: no semicolon and no control character."""


@dataclass(frozen=True, slots=True)
class _Parameter:
    """values: as the controller is delivered. protected: can be read and written by PAR and PAW,
    by PNR and PRM only behind the keyword.
    """

    name: str
    values: tuple[str, ...]
    protected: bool = False


class Parameters:
    """robot, language, slots: what some of them tell."""

    def __init__(self, robot: Robot, language: str, slots: int) -> None:
        own = [
            _Parameter("RLNG", ("1" if language == "melfa-basic-4" else "2",)),
            _Parameter("TASKMAX", (str(slots),)),
            _Parameter("MEJAR", tuple(f"{float(v):.2f}" for p in robot.limits for v in p)),
            _Parameter("JSAFE", _safe_joints(robot)),
        ]
        self._rows: Mapping[str, _Parameter] = {
            row.name: row for row in (*_parameter_table(), *own)
        }
        self._values: dict[str, tuple[str, ...]] = {}

    def __getitem__(self, name: str) -> tuple[str, ...]:
        """The values of a parameter that there is."""
        return self._values.get(name, self._rows[name].values)

    def read(self, name: str, *, all_levels: bool) -> tuple[str, ...]:
        """Return a parameter's values; raises CrRefusal 7080 if it is missing or protected."""
        row = self._rows.get(name)
        if row is None or (row.protected and not all_levels):
            raise CrRefusal(7080)
        return self[name]

    def write(self, name: str, text: str, *, all_levels: bool) -> None:
        """Raises CrRefusal: 7040 where it is protected, 7081 for values that it cannot have."""
        row = self._rows.get(name)
        if row is None:
            raise CrRefusal(7081)
        if row.protected and not all_levels:
            raise CrRefusal(7040)
        values = tuple(part.strip() for part in text.split(","))
        fits = len(values) == len(row.values) and _PARAMETER_CHARACTERS.fullmatch(text)
        if not fits or not all(map(_formatted_like, values, row.values)):
            raise CrRefusal(7081)
        self._values[name] = values

    def undo(self, name: str) -> None:
        """Restore a parameter to its delivered values; raises CrRefusal 7080."""
        if name not in self._rows:
            raise CrRefusal(7080)
        self._values.pop(name, None)

    def undo_all(self) -> None:
        self._values.clear()

    @property
    def changed(self) -> list[str]:
        """Names of those that are not as delivered."""
        return [n for n, v in self._values.items() if v != self._rows[n].values]


def _formatted_like(value: str, before: str) -> bool:
    """A number stays a number."""
    return bool(_PARAMETER_NUMBER.fullmatch(value)) or not _PARAMETER_NUMBER.fullmatch(before)


def _safe_joints(robot: Robot) -> tuple[str, ...]:
    """The joints J1 to J8 of the safe position."""
    angles = dict(zip(robot.places, robot.home, strict=True))
    return tuple(f"{float(angles.get(at, 0.0)):.2f}" for at in range(8))


@cache
def _parameter_table() -> tuple[_Parameter, ...]:
    text = files(__package__).joinpath("parameters.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return tuple(
        _Parameter(
            row["name"],
            tuple(value.strip() for value in row["values"].split(",")),
            row["level"] == "key",
        )
        for row in rows
    )


TASKMAX: Final = 8
"""Task slots of a controller as delivered; the edit slot is the next one."""
SUFFIXES: Final = {"melfa-basic-4": "MB4", "melfa-basic-5": "MB5", "melfa-basic-6": "MB6"}
"""Language → suffix of the controller's program files."""


HIGH: Final = 1
"""Level of an error that switches the servos off."""
_CAUTION: Final = 3
"""Level of one that programs go on with."""
FIRST_HAND: Final = 900
"""Output of the first hand, two for each (HNDSTS in BFP-A4288)."""
_EMERGENCY: Final = 60
"""Number of the emergency stop of the operating panel (ERRSUM in BFP-A4288)."""
HANDS: Final = 4
"""Hands of two valves each on the signals 900 to 907 (HNDSTS in BFP-A4288)."""


@dataclass(slots=True)
class Cycles:
    """Durations of a program's runs. total, latest: milliseconds."""

    total: int = 0
    latest: int = 0
    count: int = 0

    @property
    def fields(self) -> str:
        """Return the durations as PDIR and CYCLETIME list them, with the average."""
        mean = self.total // self.count if self.count else 0
        return f"{self.total};{self.latest};{mean};{self.count}"


@dataclass
class CrState:
    """A controller that all its connections share; `lock` guards every access.

    alarm: number and level (1 high, 2 low, 3 caution) of the present error. right: the session that
    holds the operation right. edited: program → session. hours: meters T (power), S (servos), D
    (programs), B (battery). cycles: program → durations of its runs. clock_off: seconds that the
    controller's clock is ahead. servo_time: seconds until the servos are on. emergency: True while
    an emergency stop is pressed. stop_on: STOPON is latched. may_start: AUEON. slow: SAFE=1.
    real_inputs: the inputs before they became pseudo inputs, None while they are real. report: is
    called with a text for the end of each program.
    """

    robot: Robot
    language: str
    store: CrStore
    clock: Callable[[], datetime] = datetime.now
    alarm: tuple[int, int] | None = None
    right: CrSession | None = None
    edited: dict[str, CrSession] = field(default_factory=dict)
    board: Board = field(default_factory=Board)
    log: ErrorLog = field(default_factory=ErrorLog)
    hours: dict[str, int] = field(default_factory=lambda: dict.fromkeys("TSDB", 0))
    cycles: dict[str, Cycles] = field(default_factory=dict)
    clock_off: float = 0.0
    servo_time: float = 0.1
    emergency: bool = False
    stop_on: bool = False
    machine_lock: bool = False
    may_start: bool = True
    slow: bool = False
    tool: int = 0
    hands: dict[int, bool] = field(default_factory=lambda: dict.fromkeys(range(1, HANDS + 1), True))
    real_inputs: dict[str, float] | None = None
    report: Callable[[str], None] | None = None
    lock: threading.RLock = field(default_factory=threading.RLock)
    _machinery: Machinery | None = None

    def __post_init__(self) -> None:
        self.began = self.clock()
        self.parameters = Parameters(self.robot, self.language, TASKMAX)
        self._standing = tuple(float(angle) for angle in self.robot.home)
        for number in range(2 * HANDS):
            self.board.outputs.values[str(FIRST_HAND + number)] = float(number % 2 == 0)

    # ----------------------------------------------------------------------- what runs

    @property
    def machinery(self) -> Machinery:
        """The machinery that runs programs; raises RuntimeError while the controller is off."""
        if self._machinery is None:
            raise RuntimeError("the controller is off")
        return self._machinery

    def start(self, equipment: Equipment) -> None:
        """The power is on: the slots have their programs, those that always run begin."""
        self._machinery = Machinery(
            self.robot,
            self.language,
            self._standing,
            TASKMAX + 1,
            self.store.get,
            self.board,
            equipment,
            self,
        )
        self._machinery.start()
        self._load_table()

    def stop(self) -> None:
        if self._machinery is not None:
            self._standing = self._machinery.joints()
            self._machinery.stop()
            self._machinery = None

    def _load_table(self) -> None:
        for slot in range(1, TASKMAX + 1):
            program, mode, condition, lines = self.parameters[f"SLT{slot}"]
            if program in self.store:
                self.machinery.set_up(slot, program, mode, condition, int(lines))

    def restart(self) -> None:
        """Reset the state as after switching the power off and on: errors, switches and slots are
        forgotten.
        """
        self.machinery.switch_servo(False)
        self.machinery.clear_slots()
        self.reset_error()
        self.stop_on = self.machine_lock = self.slow = False
        self.may_start, self.real_inputs = True, None
        self.right = None
        self._load_table()

    def failed(self, number: int, program: str, line: int, text: str) -> None:
        """A program ended with an error."""
        self.alert(number, error_level(number), program, line)
        if self.report is not None:
            self.report(f"error {number:04} of {program or 'a command'}, line {line}: {text}")

    def cycle_over(self, program: str, milliseconds: int) -> None:
        cycles = self.cycles.setdefault(program, Cycles())
        cycles.total += milliseconds
        cycles.latest = milliseconds
        cycles.count += 1

    # ----------------------------------------------------------------------------- clock

    def now(self) -> datetime:
        return self.clock() + timedelta(seconds=self.clock_off)

    # ---------------------------------------------------------------------------- errors

    def alert(self, number: int, level: int = 2, program: str = "", line: int = 0) -> None:
        """Set the present error and add it to the history.

        An error stops the programs, unless it is a caution; a high one switches the servos off.
        """
        self.alarm = (number, level)
        self.log.add(self.now(), number, level, program, line)
        if self._machinery is None:
            return
        if level == HIGH:
            self._machinery.switch_servo(False)
        elif level != _CAUTION:
            self._machinery.stop_all()

    def reset_error(self) -> None:
        """An emergency stop that is still pressed stays an error."""
        self.alarm = (_EMERGENCY, HIGH) if self.emergency else None

    def press_emergency(self, pressed: bool) -> None:
        """Released, the error stays until it is reset."""
        before, self.emergency = self.emergency, pressed
        if pressed and not before:
            self.alert(_EMERGENCY, HIGH)

    # ---------------------------------------------------------------------------- servos

    @property
    def servo(self) -> bool:
        """True if the servos are on."""
        return self._machinery is not None and self._machinery.servo

    def switch_servo(self, on: bool) -> None:
        """Raises CrRefusal where they cannot be switched on."""
        if on and self.alarm is not None and self.alarm[1] == HIGH:
            raise CrRefusal(5600)
        self.machinery.switch_servo(on, self.servo_time)

    @property
    def override(self) -> int:
        """Percent."""
        return round(self.machinery.arm.override)

    @override.setter
    def override(self, percent: int) -> None:
        self.machinery.arm.override = float(percent)

    @property
    def suffix(self) -> str:
        return SUFFIXES[self.language]

    @property
    def selected(self) -> dict[int, str]:
        """Task slot → program."""
        return self.machinery.selected()

    # ------------------------------------------------------------------------- positions

    @property
    def joints(self) -> tuple[float, ...]:
        """(a,) degrees, where the arm is now."""
        return self._standing if self._machinery is None else self._machinery.joints()

    @joints.setter
    def joints(self, angles: Sequence[float]) -> None:
        """Puts the arm somewhere."""
        self._standing = tuple(angles)
        if self._machinery is not None:
            self._machinery.put(angles)

    def order_hand(self, hand: int, opens: bool) -> None:
        """Open or close a hand as a program does."""
        board = self.board
        self.machinery.do(lambda: board.outputs.set(f"hand{hand}", float(opens)))
        self.hand_moved(hand, opens)

    def hand_moved(self, hand: int, opens: bool) -> None:
        """The two valves of a hand follow."""
        if hand in self.hands:
            self.hands[hand] = opens
            first = FIRST_HAND + 2 * (hand - 1)
            self.board.outputs.set(str(first), float(opens))
            self.board.outputs.set(str(first + 1), float(not opens))

    # ------------------------------------------------------------------------- variables

    def program_now(self, name: str) -> CrProgram:
        """A stored program, its variables as they are now."""
        program = self.store[name]
        return program if self._machinery is None else self._machinery.program_now(name, program)

    def set_variable(self, program: str | None, name: str, value: str) -> None:
        """Gives a variable of a program a value; None for one that all programs share."""
        if program is not None:
            self.store[program].keep(name, value)
        self.machinery.set_variable(program, name, value)

    def is_edited(self, name: str, by: CrSession | None = None) -> bool:
        """True if a session has the program open, other than `by`.

        A session that has said nothing for `SILENT` seconds loses it to the one that asks.
        """
        holder = self.edited.get(name)
        if holder is None or holder is by:
            return False
        # A client that died would otherwise keep its program for ever.
        if holder.silent:
            holder.close()
            return False
        return True

    def forget(self, program: str) -> None:
        """A program is another one now, or is gone."""
        self.cycles.pop(program, None)
        self.machinery.forget(program)

    def released(self, session: object) -> None:
        """Forgets what a session held."""
        if self.right is session:
            self.right = None
        self.edited = {name: s for name, s in self.edited.items() if s is not session}

    @contextmanager
    def unlocked(self) -> Iterator[None]:
        """While a command waits, others may come; the lock is held once."""
        self.lock.release()
        try:
            yield
        finally:
            self.lock.acquire()


SILENT: Final = 15.0
"""Seconds without a command after which a client no longer keeps others out; no manual at hand says
how long a controller waits."""


@dataclass(slots=True)
class BlockFile:
    """A file that FOPEN opened. data: bytes to read from `at` on, or the bytes written so far."""

    name: str
    writes: bool
    data: bytearray
    at: int = 0


@dataclass(eq=False)
class CrSession:
    """One connection: its edit and its place in the listings.

    slot: of the command under way. following: by listing, the index behind what was listed last.
    block: the file that is open for blocks. keyword: whether protected parameters are open.
    changed: whether the edit differs from what is stored. listed: changed parameters that are
    still to be listed. heard: by `time.monotonic`, when its last command was over, inf while one is
    under way.
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
    heard: float = field(default_factory=time.monotonic)

    @property
    def silent(self) -> bool:
        """True if the client counts as dead: it may vanish without closing its connection."""
        return time.monotonic() - self.heard > SILENT

    @property
    def edit(self) -> CrProgram:
        """The program that is open; raises CrRefusal 4820."""
        if self.name is None:
            raise CrRefusal(4820)
        return self.program

    def open(self, name: str) -> None:
        """Opens a program or a new one; raises CrRefusal 4170 if another session has it open."""
        if self.state.is_edited(name, self):
            raise CrRefusal(4170)
        self.close()
        self.state.edited[name] = self
        stored = name in self.state.store
        self.name = name
        # A copy: the edit is thrown away unless it is saved.
        self.program = self.state.program_now(name).copy() if stored else CrProgram()
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
