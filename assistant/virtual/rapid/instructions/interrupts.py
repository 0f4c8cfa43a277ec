"""Instructions that order interrupts: of signals, of time and of persistent data.

Instructions manual, ISignalDI and its kin, ITimer, IPers, ISleep, IWatch, IDisable, IEnable.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.interrupts import Cancel
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.values import Value, copied, same

Occur = Callable[[], None]

LOW, HIGH, EDGE = 0.0, 1.0, 2.0
LEAST_SINGLE: Final = 0.01
LEAST_CYCLE: Final = 0.1
"""Seconds of a timed interrupt (manual, ITimer)."""


def analog_zones(value: float, high: float, low: float) -> Mapping[int, bool]:
    """Whether a value meets each aiotrigg (manual, data type aiotrigg)."""
    return {
        1: value > high,
        2: value < high,
        3: value > low,
        4: value < low,
        5: low < value < high,
        6: value > high or value < low,
        7: True,
    }


def _order_interrupt(given: Given, index: int, begin: Callable[[Occur], Cancel]) -> None:
    """index: which argument is the variable of the interrupt."""
    number = whole(given.number(index), "the number of an interrupt")
    single, safe = given.has("single"), given.has("singlesafe")
    given.machine.interrupts.order(number, begin, single, safe)


def _listen_signal(given: Given, index: int, hears: Callable[[float, float], bool]) -> None:
    """hears: whether a change of the signal, from one value to another, is an interrupt."""
    machine, signal = given.machine, given.signal(0)
    board = machine.task.kernel.board
    side = board.outputs if signal in machine.signals.outputs else board.inputs

    def begin(occur: Occur) -> Cancel:
        machine.task.kernel.catch_up()

        def listener(name: str, before: float, now: float) -> None:
            if name == signal and hears(before, now):
                occur()

        side.listeners.append(listener)
        side.watched.append(signal)

        def leave() -> None:
            if listener in side.listeners:
                side.listeners.remove(listener)
                side.watched.remove(signal)

        return leave

    _order_interrupt(given, index, begin)


def _order_digital(given: Given) -> None:
    """A signal that has the value already is no interrupt: it has to change to it."""
    value = given.number(1)
    if value not in (LOW, HIGH, EDGE):
        raise Fault(f"{value:g} as the value of a digital signal that interrupts")
    _listen_signal(given, 2, lambda _, now: value in (EDGE, now))


def _order_group(given: Given) -> None:
    _listen_signal(given, 1, lambda *_: True)


def _order_analog(given: Given) -> None:
    r"""In its zone, and by more than DeltaValue away from where it was when it last was so.

    \DPos and \DNeg: only of one direction; the others are remembered alike.
    """
    zone = whole(given.number(1), "the condition of an analog signal")
    if zone not in analog_zones(0.0, 0.0, 0.0):
        raise Fault("a condition of an analog signal that there is not")
    high, low, delta = given.number(2), given.number(3), given.number(4)
    up, down = not given.has("dneg"), not given.has("dpos")
    reference = given.machine.signals.read(given.signal(0))

    def hears(_: float, now: float) -> bool:
        nonlocal reference
        difference = now - reference
        if not analog_zones(now, high, low)[zone] or abs(difference) <= delta:
            return False
        reference = now
        return up if difference > 0.0 else down

    _listen_signal(given, 5, hears)


def _order_timer(given: Given) -> None:
    seconds, kernel = given.number(0), given.machine.task.kernel
    once = given.has("single") or given.has("singlesafe")
    least = LEAST_SINGLE if once else LEAST_CYCLE
    if seconds < least:
        raise Fault(f"a timed interrupt after {seconds:g} s, which are {least:g} s at least")

    def begin(occur: Occur) -> Cancel:
        def fire() -> None:
            if not once:
                timers[0] = kernel.at(timers[0].time + seconds, fire)
            occur()

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

    def begin(occur: Occur) -> Cancel:
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


ONCE: Final = "single singlesafe"

INTERRUPT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        *(table_row(f"ISignal{kind}", 3, _order_digital, ONCE) for kind in ("DI", "DO")),
        *(table_row(f"ISignal{kind}", 2, _order_group, ONCE) for kind in ("GI", "GO")),
        *(
            table_row(f"ISignal{kind}", 6, _order_analog, f"{ONCE} dpos dneg")
            for kind in ("AI", "AO")
        ),
        table_row("ITimer", 2, _order_timer, ONCE),
        table_row("IPers", 2, _order_persistent, ONCE),
        table_row("IDelete", 1, _delete_interrupt),
        table_row("ISleep", 1, _sleep_interrupt),
        table_row("IWatch", 1, _watch_interrupt),
        table_row("IDisable", 0, _disable_all),
        table_row("IEnable", 0, _enable_all),
    )
)
"""Interrupts of errors (IError) and of messages (IRMQMessage) are not simulated."""
