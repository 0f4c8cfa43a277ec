"""Status variables, in tables: of the arm, slots, signals, the clock and errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from assistant.virtual.kernel import kernel
from assistant.virtual.kernel.kernel import Progress
from assistant.virtual.melfa import arm_state
from assistant.virtual.melfa.arm_state import FULL, OPTIMUM, Arm
from assistant.virtual.melfa.values import ORIGIN, Unknown, Value, open_point, out_of_range, whole
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.virtual.melfa.controller import Slot


def _slot_line(slot: Slot) -> Value:
    """The number of the step that runs."""
    running = slot.world.running if slot.world is not None else []
    number = running[-1].code.rows[running[-1].here].number if running else None
    if number is None:
        raise Unknown(f"the line of slot {slot.number}")
    return number


def _slot_program(slot: Slot) -> Value:
    if not slot.program:
        raise Unknown(f"the program of slot {slot.number}, which has none")
    return slot.program


def _error_level(slot: Slot) -> Value:
    """Return the level of the error: 1 for a caution, 2 for a low one, 3 for a high one."""
    error = slot.controller.error
    if error is None:
        return 0
    return 1 if error.number in _CAUTION_ERRORS else 3 if error.number in _HIGH_ERRORS else 2


def _error_number(slot: Slot) -> Value:
    error = slot.controller.error
    if error is None:
        return 0
    if error.number is None:
        raise Unknown("the number of an error that the manuals do not give")
    return error.number


_CAUTION_ERRORS: Final = range(9200, 9300)
_HIGH_ERRORS: Final = range(9000, 9100)
"""Errors of the user's that are of the high level; those that are raised here else are low."""

_SLOT_STATUS: Final[Mapping[str, Callable[[Slot], Value]]] = {
    "M_RUN": lambda slot: int(slot.state == "runs"),
    "M_WAI": lambda slot: int(slot.state == "waits"),
    "M_PSA": lambda slot: int(slot.state == "reset"),
    "M_LINE": _slot_line,
    "C_PRG": _slot_program,
}
"""Status variables of a slot, by default of the program's slot."""

_ERROR_STATUS: Final[Mapping[str, Callable[[Slot], Value]]] = {
    "M_ERR": lambda slot: int(slot.controller.error is not None),
    "M_ERRLVL": _error_level,
    "M_ERRNO": _error_number,
}
"""Status variables of the controller."""


def _read_slot_status(world: World, name: str, index: tuple[int, ...]) -> Value | None:
    """A status variable about slots; None for another one, or without a controller."""
    slot = world.slot
    if slot is None or len(index) > 1:
        return None
    if name in _ERROR_STATUS and not index:
        return _ERROR_STATUS[name](slot)
    if name not in _SLOT_STATUS:
        return None
    return _SLOT_STATUS[name](slot.controller.slot(index[0]) if index else slot)


_STANDARD_GRAVITY: Final = 9.80665

_READ_POSITIONS: Final = frozenset(("P_CURR", "P_FBC"))
_ARM_STATUS: Final[Mapping[str, Callable[[Arm], Value]]] = {
    "J_CURR": Arm.shown_joints,
    "J_FBC": Arm.shown_joints,
    "P_TOOL": lambda arm: arm.tool,
    "P_BASE": lambda arm: arm.base,
    "M_TOOL": lambda arm: _known_number(
        arm.tool_number, "the number of a tool that a position gives"
    ),
    "M_BSNO": lambda arm: _known_number(
        arm.base_number, "the number of a base that a position gives"
    ),
    "M_SVO": lambda arm: int(arm.servo),
}
"""Status variables of the mechanism, with or without the index 1."""


def _known_number(number: int | None, what: str) -> int:
    if number is None:
        raise Unknown(what)
    return number


_SLOT_SETTINGS: Final[Mapping[str, Callable[[World], Value]]] = {
    "M_SPD": lambda world: world.settings.speed,
    "M_OVRD": lambda world: world.settings.override,
    "M_JOVRD": lambda world: world.settings.joint_override,
    "M_ACL": lambda world: world.settings.acceleration[0],
    "M_DACL": lambda world: world.settings.acceleration[1],
    "M_BRKCQ": lambda world: int(world.left),
    "M_SKIPCQ": lambda world: int(world.skipped),
    "M_ERR": lambda world: int(world.error != 0),
    "M_ERRLVL": lambda world: int(world.error != 0),
    "M_ERRNO": lambda world: world.error,
}
"""Settings of a slot, by default of the program's slot."""

_CLOCK_FORMATS: Final[Mapping[str, str]] = {"C_DATE": "%Y/%m/%d", "C_TIME": "%H:%M:%S"}
"""Formats of the date and the time of day: 2007/04/01, 13:01:30 (their manuals)."""

_MOTION_STATUS: Final[Mapping[str, Callable[[Progress], float]]] = {
    "M_RDST": lambda progress: progress.left,
    "M_RATIO": lambda progress: progress.done,
}

_CONSTANTS: Final[Mapping[str, Value]] = {
    "P_NTOOL": ORIGIN, "P_NBASE": ORIGIN, "P_ZERO": ORIGIN,
    "M_NSPD": OPTIMUM, "M_NOVRD": FULL, "M_NJOVRD": FULL, "M_NACL": FULL, "M_NDACL": FULL,
    "M_OPOVRD": FULL, "M_PI": math.pi, "M_EXP": math.e, "M_G": _STANDARD_GRAVITY,
    "M_ON": 1, "M_OFF": 0,
}  # fmt: skip
"""Status variables that never change in a run here: no fault occurs and no operator interferes."""

SIGNAL_WIDTHS: Final[Mapping[str, tuple[bool, int]]] = {
    "M_IN": (False, 1), "M_INB": (False, 8), "M_IN8": (False, 8), "M_INW": (False, 16),
    "M_IN16": (False, 16), "M_IN32": (False, 32), "M_OUT": (True, 1), "M_OUTB": (True, 8),
    "M_OUT8": (True, 8), "M_OUTW": (True, 16), "M_OUT16": (True, 16), "M_OUT32": (True, 32),
}  # fmt: skip
"""Signals: whether it is an output, and its bits."""

REGISTER_OUTPUTS: Final[Mapping[str, bool]] = {"M_DIN": False, "M_DOUT": True}
"""Registers of a field bus: whether it is an output."""

IO_WIDTHS: Final = {"BIT": 1, "BYTE": 8, "WORD": 16, "INTEGER": 16, "DWORD": 32}
"""Widths of `Def Io` in bits."""


def _hand_state(world: World, hand: int) -> int:
    if hand not in world.arm.hands:
        raise Unknown(f"how hand {hand} is when power comes on (parameter HANDINIT)")
    return int(world.arm.hands[hand])


def _hand_check(world: World, number: int) -> int:
    """M_HndCq: inputs 900 to 907 (COSIROP: HOPEN)."""
    if number not in range(1, 9):
        raise out_of_range(f"the hand check input {number}")
    return world.read(output=False, first=_FIRST_CHECK + number - 1, width=1)


_FIRST_CHECK: Final = 900
_HAND_STATUS: Final[Mapping[str, Callable[[World, int], Value]]] = {
    "M_HND": _hand_state,
    "M_HNDCQ": _hand_check,
}
"""Status variables of hands, by the number of the hand."""
_OWN_MECHANISM: Final = (1,)
_TIMER_NUMBERS: Final = range(1, 9)


def read(world: World, name: str, arguments: tuple[Value, ...]) -> Value:
    """The value of a status variable; raises Unknown for one that is not simulated."""
    index = tuple(whole(a, f"the index of {name}") for a in arguments)
    if name in SIGNAL_WIDTHS and len(index) == 1:
        output, width = SIGNAL_WIDTHS[name]
        value = world.read(output, index[0], width)
        return _signed_group(world, value, width)
    if name in REGISTER_OUTPUTS and len(index) == 1:
        return world.register(REGISTER_OUTPUTS[name], index[0])
    if name == "M_TIMER" and len(index) == 1:
        return world.timer(timer_number(index[0]))
    if name in _HAND_STATUS and len(index) == 1:
        return _HAND_STATUS[name](world, index[0])
    about_slots = _read_slot_status(world, name, index)
    if about_slots is not None:
        return about_slots
    if name == "M_OPEN" and len(index) == 1:
        return _file_state(world, index[0])
    if name in _MOTION_STATUS and index in ((), _OWN_MECHANISM):
        return _motion_progress(world, name)
    if name == "M_RSPD" and len(index) <= 1:
        return _motion_speed(world, *index)
    if name in _SLOT_SETTINGS and len(index) <= 1:
        return _SLOT_SETTINGS[name](world.of_slot(*index))
    if name in _READ_POSITIONS and index in ((), _OWN_MECHANISM):
        return arm_state.read_position(world)
    if name in _ARM_STATUS and index in ((), _OWN_MECHANISM):
        return _ARM_STATUS[name](arm_state.arm_now(world))
    if name in _CLOCK_FORMATS and not index:
        return format(
            kernel.date_at(world.task.kernel.now, world.options.began), _CLOCK_FORMATS[name]
        )
    if name in _CONSTANTS and index in ((), _OWN_MECHANISM):
        return _CONSTANTS[name]
    raise Unknown(f"the status variable {name}")


def _motion_progress(world: World, name: str) -> float:
    """Return a status variable of the current or last motion."""
    progress = world.task.kernel.motion.progress()
    if progress is None:
        raise Unknown(f"the status variable {name}")
    return _MOTION_STATUS[name](progress)


def _motion_speed(world: World, *slot: int) -> float:
    """Return the speed of the motion that a slot has commanded, mm/s."""
    mine = world.slot
    if mine is None:
        world.of_slot(*slot)  # the one that there is
    elif slot:
        mine = mine.controller.slot(*slot)  # single commands move in one without a program
    moves = mine is None or mine.controller.owner is mine
    progress = world.task.kernel.motion.progress() if moves else None
    return 0.0 if progress is None else progress.speed


def _file_state(world: World, number: int) -> int:
    """Return 1 if the other end of a file is connected, else 0; -1 if the file is not open."""
    channel = world.files.get(number)
    return -1 if channel is None else int(channel.line.connected())


def timer_number(number: int) -> int:
    if number not in _TIMER_NUMBERS:
        raise out_of_range(f"the timer {number}")
    return number


def group_bits(world: World, name: str, index: tuple[Value, ...]) -> int | None:
    """The signals of a group as a number without a sign; None for another status variable."""
    if name not in SIGNAL_WIDTHS or len(index) != 1:
        return None
    output, width = SIGNAL_WIDTHS[name]
    return world.read(output, whole(index[0], f"the index of {name}"), width)


def _signed_group(world: World, value: int, width: int) -> int:
    """A number of 16 or 32 bits whose highest one is set may be shown as negative or not."""
    if width in (16, 32) and value >> (width - 1):
        if world.options.signed is None:
            raise open_point(
                f"the sign of a group of {width} signals whose highest is on", "signed"
            )
        return value - (1 << width) if world.options.signed else value
    return value
