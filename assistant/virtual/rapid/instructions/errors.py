"""Errors that a program makes itself, and messages for the event log."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from typing import Final

from assistant.virtual.events import Reported
from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.errors import FIRST_BOOKED
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.recovery import leave_handler
from assistant.virtual.rapid.scopes import Cell


def _book_number(given: Given) -> None:
    """BookErrNo: a number that nobody else has."""
    booked = given.machine.controller.booked
    number = next(n for n in count(FIRST_BOOKED) if n not in booked)
    given.place(0).set(float(number))
    booked.add(number)


def _write_event(given: Given) -> None:
    lines = [given.text(1)]
    lines += [poses.text(v) for name in MESSAGE_LINES if (v := given.optional(name)) is not None]
    _report_error(given, given.text(0), lines)


def _log_event(given: Given) -> None:
    number = whole(given.number(0), "the number of a message")
    _report_error(given, str(number), [given.text(i) for i in range(1, 6)])


def _report_error(given: Given, header: str, lines: list[str]) -> None:
    kind = "warning" if given.has("w") else "information" if given.has("i") else "error"
    given.machine.task.tell(Reported(kind, header, tuple(lines)))


def _raise_booked(given: Given) -> None:
    """ErrRaise: a warning, and the error whose number a datum of this name has."""
    machine, name = given.machine, given.text(0)
    cell = machine.meaning(name)
    if not isinstance(cell, Cell) or not isinstance(cell.value, float):
        raise Fault(f"there is no error `{name}`", "ERR_ILLRAISE")
    texts = tuple(given.text(i) for i in range(2, 7))
    number = whole(given.number(1), "the number of a message")
    machine.task.tell(Reported("warning", str(number), texts))
    fault = Fault(f"the error {name} is raised", number=int(cell.value))
    if machine.frame.handling is None:
        raise fault
    fault.at = machine.at
    machine.frame.handling = fault
    leave_handler(machine, machine.frame, fault)


def _reset_retries(given: Given) -> None:
    given.machine.frame.retries = given.machine.controller.options.retries


MESSAGE_LINES: Final = ("rl2", "rl3", "rl4")

ERROR_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("BookErrNo", 1, _book_number),
        table_row("ErrWrite", 2, _write_event, "w i rl2 rl3 rl4"),
        table_row("ErrLog", 6, _log_event, "w i"),
        table_row("ErrRaise", 7, _raise_booked),
        table_row("ResetRetryCount", 0, _reset_retries),
    )
)
