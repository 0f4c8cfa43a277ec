"""Handlers: error recovery and traps, with the instructions that raise errors and order interrupts.

Kernel manual, Error recovery: an error goes to the handler of the routine that it happens in. If
that has none for it, or raises it anew, it happens again where the routine was called. An ERROR
with a list that names it is a point that it goes to in one step. Errors inside of a handler are not
recovered from. Instructions manual, ISignalDI and its kin, ITimer, IPers, ISleep, IWatch, IDisable,
IEnable: interrupts are connected to trap routines, which answer them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Reported
from assistant.virtual.rapid import records
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import (
    ANY_ERROR,
    ERROR_NAMES,
    ERROR_NUMBERS,
    FIRST_BOOKED,
    Again,
    Fault,
    Jump,
    NotSimulated,
    Onward,
)
from assistant.virtual.rapid.expressions import numeric, place, whole
from assistant.virtual.rapid.machine import Cancel, Function, Interrupt, Machine
from assistant.virtual.rapid.records import number
from assistant.virtual.rapid.scopes import Cell, Frame, Known
from assistant.virtual.rapid.values import Value, copied, same

Execute = Callable[[Machine, Sequence[s.StatementNode]], None]


def run_with_recovery(
    machine: Machine,
    node: Any,
    does: Callable[[Machine, Any], None],
    execute: Execute,
    row: int = 0,
) -> None:
    """Run a statement. An error in it passes to the handler of its routine.

    execute: runs the statements of a handler. row: its line, from 0, in a run of moves.
    """
    frame = machine.frame
    left = machine.controller.options.retries
    while True:
        machine.step(node, row)
        try:
            does(machine, node)
        except Fault as fault:
            # The innermost statement is where the error
            # happened; outer ones see the same fault pass.
            if fault.at is None:
                fault.at, fault.row = machine.at, machine.row
            if not _recover(machine, frame, fault, left, execute):
                return
            left = frame.retries - 1
        else:
            return


def leave_handler(machine: Machine, frame: Frame, fault: Fault) -> None:
    """Raises an error out of a routine: to where it was called, or to a point that names it."""
    # The routine's own handlers are past: `_recover` of the same frame must not take it again.
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
    # The manuals give this error no number, so that a handler might or might not take it.
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
    """True if the handler of a routine names an error in its list."""
    handler = _handler(frame, "ERROR")
    return (
        handler is not None
        and bool(handler.numbers)
        and frame.handling is None
        and _handles(machine, frame, handler, number)
    )


def _handles(machine: Machine, frame: Frame, handler: s.Handler, number: int) -> bool:
    """True if a handler is for an error: without a list for any."""
    if not handler.numbers:
        return True
    # The list of numbers is read in the scope of the handler's routine, not of the one that failed.
    machine.frames.append(frame)
    try:
        listed = {numeric(machine, one) for one in handler.numbers}
    finally:
        machine.frames.pop()
    return number in listed or ERROR_NUMBERS[ANY_ERROR] in listed


def error_name(number: int) -> str:
    """Return the name of an error for messages."""
    return ERROR_NAMES.get(number, str(number))


def _book_number(given: Given) -> None:
    """BookErrNo: book a free error number."""
    booked = given.machine.controller.booked
    number = next(n for n in count(FIRST_BOOKED) if n not in booked)
    given.place(0).set(float(number))
    booked.add(number)


def _write_event(given: Given) -> None:
    lines = [given.text(1)]
    lines += [records.text(v) for name in _MESSAGE_LINES if (v := given.optional(name)) is not None]
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


_MESSAGE_LINES: Final = ("rl2", "rl3", "rl4")

ERROR_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("BookErrNo", 1, _book_number),
        table_row("ErrWrite", 2, _write_event, "w i rl2 rl3 rl4"),
        table_row("ErrLog", 6, _log_event, "w i"),
        table_row("ErrRaise", 7, _raise_booked),
        table_row("ResetRetryCount", 0, _reset_retries),
    )
)


def connect_trap(machine: Machine, node: s.Connect) -> None:
    """CONNECT: a variable gets the number of a new interrupt."""
    variable = place(machine, node.interrupt)
    if variable.storage not in ("VAR", "IN"):
        raise Fault("what is no variable is connected to a trap routine", "ERR_CNTNOTVAR")
    trap = machine.meaning(node.trap)
    if not isinstance(trap, Known) or trap.node.kind != "TRAP":
        raise Fault(f"`{node.trap}` is no trap routine")
    given = machine.interrupts.connect(int(number(variable.get())), trap)
    variable.set(float(given))


def run_trap(machine: Machine, interrupt: Interrupt) -> None:
    """Other interrupts wait meanwhile. `INTNO` is its number."""
    intno = machine.predefined["intno"]
    assert isinstance(intno, Cell)
    # Outputs on the way belong to the interrupted move, not to moves of the trap routine.
    before, on_way = intno.value, machine.on_way
    intno.value, machine.on_way = float(interrupt.number), ()
    # Further interrupts queue while this is above 0.
    machine.task.closed += 1
    try:
        machine.abilities.call(machine, interrupt.trap, ())
    finally:
        machine.task.closed -= 1
        intno.value, machine.on_way = before, on_way


_Occur = Callable[[], None]

_LOW, HIGH, _EDGE = 0.0, 1.0, 2.0
_LEAST_SINGLE: Final = 0.01
_LEAST_CYCLE: Final = 0.1
"""Seconds of a timed interrupt (manual, ITimer)."""


def _analog_zones(value: float, high: float, low: float) -> Mapping[int, bool]:
    """Return for each aiotrigg whether a value meets it (manual, data type aiotrigg)."""
    return {
        1: value > high,
        2: value < high,
        3: value > low,
        4: value < low,
        5: low < value < high,
        6: value > high or value < low,
        7: True,
    }


def _order_interrupt(given: Given, index: int, begin: Callable[[_Occur], Cancel]) -> None:
    """index: which argument is the variable of the interrupt."""
    number = whole(given.number(index), "the number of an interrupt")
    single, safe = given.has("single"), given.has("singlesafe")
    given.machine.interrupts.order(number, begin, single, safe)


def _listen_signal(given: Given, index: int, hears: Callable[[float, float], bool]) -> None:
    """hears: whether a change of the signal, from one value to another, is an interrupt."""
    machine, signal = given.machine, given.signal(0)
    board = machine.task.kernel.board
    side = board.outputs if signal in machine.signals.outputs else board.inputs

    def begin(occur: _Occur) -> Cancel:
        # Changes of inputs up to this moment came before the order, and are no interrupts.
        machine.task.kernel.catch_up()

        def listener(name: str, before: float, now: float) -> None:
            if name == signal and hears(before, now):
                occur()

        side.listeners.append(listener)
        side.watched.append(signal)

        def leave() -> None:
            # A fired single interrupt has left already when IDelete ends it.
            if listener in side.listeners:
                side.listeners.remove(listener)
                side.watched.remove(signal)

        return leave

    _order_interrupt(given, index, begin)


def _order_digital(given: Given) -> None:
    """A signal that has the value already is no interrupt: it has to change to it."""
    value = given.number(1)
    if value not in (_LOW, HIGH, _EDGE):
        raise Fault(f"{value:g} as the value of a digital signal that interrupts")
    _listen_signal(given, 2, lambda _, now: value in (_EDGE, now))


def _order_group(given: Given) -> None:
    _listen_signal(given, 1, lambda *_: True)


def _order_analog(given: Given) -> None:
    r"""In its zone, and by more than DeltaValue away from where it was when it last was so.

    \DPos and \DNeg: only of one direction; the others are remembered alike.
    """
    zone = whole(given.number(1), "the condition of an analog signal")
    if zone not in _analog_zones(0.0, 0.0, 0.0):
        raise Fault("a condition of an analog signal that there is not")
    high, low, delta = given.number(2), given.number(3), given.number(4)
    up, down = not given.has("dneg"), not given.has("dpos")
    reference = given.machine.signals.read(given.signal(0))

    def hears(_: float, now: float) -> bool:
        nonlocal reference
        difference = now - reference
        if not _analog_zones(now, high, low)[zone] or abs(difference) <= delta:
            return False
        reference = now
        return up if difference > 0.0 else down

    _listen_signal(given, 5, hears)


def _order_timer(given: Given) -> None:
    seconds, kernel = given.number(0), given.machine.task.kernel
    once = given.has("single") or given.has("singlesafe")
    least = _LEAST_SINGLE if once else _LEAST_CYCLE
    if seconds < least:
        raise Fault(f"a timed interrupt after {seconds:g} s, which are {least:g} s at least")

    def begin(occur: _Occur) -> Cancel:
        def fire() -> None:
            if not once:
                # From the planned time, not from now: a cycle
                # does not drift by the time that traps take.
                timers[0] = kernel.at(timers[0].time + seconds, fire)
            occur()

        # A list, since `fire` replaces the timer and `cancel` has to find the latest one.
        timers = [kernel.at(kernel.now + seconds, fire)]

        def cancel() -> None:
            timers[0].cancelled = True

        return cancel

    _order_interrupt(given, 1, begin)


def _order_persistent(given: Given) -> None:
    """Whoever changes it, of whichever task; that it is set to what it was is no change."""
    watched, looks = given.place(0), given.machine.controller.looks
    if watched.storage != "PERS":
        raise Fault("IPers of what is no persistent")

    def begin(occur: _Occur) -> Cancel:
        # A copy: an assignment to a component changes the record in place.
        known: Value = copied(watched.get())

        def look() -> None:
            nonlocal known
            now = watched.get()
            if not same(known, now):
                known = copied(now)
                occur()

        looks.append(look)
        return lambda: looks.remove(look) if look in looks else None

    _order_interrupt(given, 1, begin)


def _interrupt_number(given: Given) -> int:
    variable = place(given.machine, given.required[0]).get()
    return int(variable) if isinstance(variable, float) else 0


def _delete_interrupt(given: Given) -> None:
    given.machine.interrupts.delete(_interrupt_number(given))


def _sleep_interrupt(given: Given) -> None:
    given.machine.interrupts.sleep(_interrupt_number(given), asleep=True)


def _watch_interrupt(given: Given) -> None:
    given.machine.interrupts.sleep(_interrupt_number(given), asleep=False)


def _disable_all(given: Given) -> None:
    given.machine.interrupts.disable(disabled=True)


def _enable_all(given: Given) -> None:
    given.machine.interrupts.disable(disabled=False)


_ONCE: Final = "single singlesafe"

INTERRUPT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        *(table_row(f"ISignal{kind}", 3, _order_digital, _ONCE) for kind in ("DI", "DO")),
        *(table_row(f"ISignal{kind}", 2, _order_group, _ONCE) for kind in ("GI", "GO")),
        *(
            table_row(f"ISignal{kind}", 6, _order_analog, f"{_ONCE} dpos dneg")
            for kind in ("AI", "AO")
        ),
        table_row("ITimer", 2, _order_timer, _ONCE),
        table_row("IPers", 2, _order_persistent, _ONCE),
        table_row("IDelete", 1, _delete_interrupt),
        table_row("ISleep", 1, _sleep_interrupt),
        table_row("IWatch", 1, _watch_interrupt),
        table_row("IDisable", 0, _disable_all),
        table_row("IEnable", 0, _enable_all),
    )
)
"""Interrupts of errors (IError) and of messages (IRMQMessage) are not simulated."""
