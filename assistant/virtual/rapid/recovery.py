"""What becomes of an error: the handlers of routines, and how they go on.

Kernel manual, Error recovery: an error goes to the handler of the routine that it happens in. If
that has none for it, or raises it anew, it happens again where the routine was called. An ERROR
with a list that names it is a point that it goes to in one step. Errors inside of a handler are
not recovered from.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.rapid.ends import Again, Fault, Jump, NotSimulated, Onward
from assistant.virtual.rapid.errors import ANY_ERROR, ERROR_NAMES, ERROR_NUMBERS
from assistant.virtual.rapid.expressions import numeric
from assistant.virtual.rapid.machine import Machine
from assistant.virtual.rapid.scopes import Cell, Frame

Execute = Callable[[Machine, Sequence[s.StatementNode]], None]


def run_with_recovery(
    machine: Machine,
    node: Any,
    does: Callable[[Machine, Any], None],
    execute: Execute,
    row: int = 0,
) -> None:
    """Runs a statement. An error in it goes to the handler of the routine that it stands in.

    execute: what runs the statements of a handler. row: the line of it, from 0, in a run of moves.
    """
    frame = machine.frame
    left = machine.controller.options.retries
    while True:
        machine.step(node, row)
        try:
            does(machine, node)
        except Fault as fault:
            if fault.at is None:
                fault.at, fault.row = machine.at, machine.row
            if not _recover(machine, frame, fault, left, execute):
                return
            left = frame.retries - 1
        else:
            return


def leave_handler(machine: Machine, frame: Frame, fault: Fault) -> None:
    """Raises an error out of a routine: to where it was called, or to a point that names it."""
    fault.leaves = frame
    if fault.goal is None and fault.number is not None:
        below = machine.frames[: machine.frames.index(frame)]
        points = (one for one in reversed(below) if _is_point(machine, one, fault.number))
        fault.goal = next(points, None)
        if fault.goal is None and not (
            machine.controller.options.propagates or frame.handling is fault
        ):
            fault.number = None
    _recovery_point(machine, fault)
    raise fault


def undo_handler(machine: Machine, frame: Frame, execute: Execute) -> None:
    """Runs the UNDO handler of a routine that is left in the midst of it, if it has one."""
    handler = _handler(frame, "UNDO")
    if handler is not None:
        frame.handling = Fault("what is undone")
        execute(machine, handler.body)


def _recover(machine: Machine, frame: Frame, fault: Fault, left: int, execute: Execute) -> bool:
    """Runs the handler of an error; whether the statement is to run again, or the next one."""
    if fault.unsure and any(_handler(one, "ERROR") for one in machine.frames):
        raise NotSimulated(f"whether a handler is there for this error: {fault}") from None
    if fault.leaves is frame or fault.number is None:
        raise fault
    if fault.goal is not None and fault.goal is not frame:
        raise fault
    if frame.handling is not None:  # not recovered from, by whatever handler
        fault.number = None
        raise fault
    handler = _handler(frame, "ERROR")
    if handler is None or not _handles(machine, frame, handler, fault.number):
        leave_handler(machine, frame, fault)
    assert handler is not None
    fault.goal = None
    frame.handling, frame.retries = fault, left
    errno = machine.predefined["errno"]
    assert isinstance(errno, Cell)
    errno.value = float(fault.number)
    try:
        execute(machine, handler.body)
    except Onward:
        return False
    except Again:
        if frame.retries > 0:
            return True
    except Jump as jump:
        raise Fault(f"there is no label `{jump.label}` in the handler") from None
    else:
        _recovery_point(machine, fault)
        raise Fault(f"the handler leaves the error as it is: {fault}")
    finally:
        frame.handling = None
    over = Fault(f"more than {machine.controller.options.retries} retries", "ERR_EXCRTYMAX")
    over.at, over.row = fault.at, fault.row
    if machine.controller.options.retries_raise and fault.number != over.number:
        return _recover(machine, frame, over, 0, execute)
    _recovery_point(machine, fault)
    over.number = None
    raise over


def _recovery_point(machine: Machine, fault: Fault) -> None:
    """Messages are to tell where an error happened, not where it was handled."""
    machine.at, machine.row = fault.at, fault.row


def _handler(frame: Frame, kind: str) -> s.Handler | None:
    handlers = frame.routine.handlers if frame.routine is not None else ()
    return next((one for one in handlers if one.kind == kind), None)


def _is_point(machine: Machine, frame: Frame, number: int) -> bool:
    """Whether the handler of a routine names an error in its list."""
    handler = _handler(frame, "ERROR")
    return (
        handler is not None
        and bool(handler.numbers)
        and frame.handling is None
        and _handles(machine, frame, handler, number)
    )


def _handles(machine: Machine, frame: Frame, handler: s.Handler, number: int) -> bool:
    """Whether a handler is for an error: without a list for any."""
    if not handler.numbers:
        return True
    machine.frames.append(frame)
    try:
        listed = {numeric(machine, one) for one in handler.numbers}
    finally:
        machine.frames.pop()
    return number in listed or ERROR_NUMBERS[ANY_ERROR] in listed


def error_name(number: int) -> str:
    """An error as a message says it."""
    return ERROR_NAMES.get(number, str(number))
