"""Status variables about slots and errors, in tables: M_Run, M_Wai, M_Psa, M_Line, C_Prg, M_Err."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from assistant.virtual.melfa.stops import Unknown
from assistant.virtual.melfa.values import Value

if TYPE_CHECKING:
    from assistant.virtual.melfa.slots import Slot
    from assistant.virtual.melfa.world import World


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
    """Of the error: 1 for a caution, 2 for a low one, 3 for a high one."""
    error = slot.controller.error
    if error is None:
        return 0
    return 1 if error.number in CAUTION_ERRORS else 3 if error.number in HIGH_ERRORS else 2


def _error_number(slot: Slot) -> Value:
    error = slot.controller.error
    if error is None:
        return 0
    if error.number is None:
        raise Unknown("the number of an error that the manuals do not give")
    return error.number


CAUTION_ERRORS: Final = range(9200, 9300)
HIGH_ERRORS: Final = range(9000, 9100)
"""Errors of the user's that are of the high level; those that are raised here else are low."""

SLOT_STATUS: Final[Mapping[str, Callable[[Slot], Value]]] = {
    "M_RUN": lambda slot: int(slot.state == "runs"),
    "M_WAI": lambda slot: int(slot.state == "waits"),
    "M_PSA": lambda slot: int(slot.state == "reset"),
    "M_LINE": _slot_line,
    "C_PRG": _slot_program,
}
"""Of a slot, the own one where no index stands."""

ERROR_STATUS: Final[Mapping[str, Callable[[Slot], Value]]] = {
    "M_ERR": lambda slot: int(slot.controller.error is not None),
    "M_ERRLVL": _error_level,
    "M_ERRNO": _error_number,
}
"""Of the controller."""


def read_slot_status(world: World, name: str, index: tuple[int, ...]) -> Value | None:
    """A status variable about slots; None for another one, or without a controller."""
    slot = world.slot
    if slot is None or len(index) > 1:
        return None
    if name in ERROR_STATUS and not index:
        return ERROR_STATUS[name](slot)
    if name not in SLOT_STATUS:
        return None
    return SLOT_STATUS[name](slot.controller.slot(index[0]) if index else slot)
