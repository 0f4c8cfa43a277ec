"""Outputs, and waiting for inputs and for time."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.events import Waited
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function

LOOKS: Final = (
    "inpos pollrate visualize header message msgarray wrap icon image visualizetime uiactivesignal"
)
"""What changes only what a person sees while the program waits."""
COMPARISONS: Final = {"lt": operator.lt, "gt": operator.gt, "noteq": operator.ne}


def _set(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 1.0)


def _reset(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 0.0)


def _set_digital(given: Given) -> None:
    """Any value but 0 is 1."""
    given.machine.signals.set(given.signal(0), float(given.number(1) != 0.0))


def _set_number(given: Given) -> None:
    given.machine.signals.set(given.signal(0), given.number(1))


def _invert(given: Given) -> None:
    signal, signals = given.signal(0), given.machine.signals
    signals.set(signal, float(signals.read(signal) == 0.0))


def _pulse(given: Given) -> None:
    r"""Both of its ends at once: the program does not wait for the second.

    Without \High the pulse is the other value than that which the signal has.
    """
    signal, signals = given.signal(0), given.machine.signals
    value = 1.0 if given.has("high") else float(signals.read(signal) == 0.0)
    given.optional_number("plength")
    signals.set(signal, value)
    signals.set(signal, 1.0 - value)


def _wait_time(given: Given) -> None:
    seconds = given.number(0)
    if seconds < 0.0:
        raise Fault(f"a wait of {seconds:g} seconds")
    if given.has("inpos"):
        given.machine.settle()
    given.machine.task.delay(seconds)


def _wait_for(given: Given) -> None:
    """WaitDI and its kin: the signal is to have the value, or to be beyond it."""
    compare = next((COMPARISONS[name] for name in COMPARISONS if given.has(name)), operator.eq)
    signal, value = given.signal(0), given.number(1)
    read = given.machine.signals.read
    what = f"`{signal}` is {read(signal):g}, {value:g} is waited for"
    _await(given, lambda: bool(compare(read(signal), value)), what)


def _wait_until(given: Given) -> None:
    _await(given, lambda: given.truth(0), "the condition that is waited for is not met")


def _await(given: Given, is_met: Callable[[], bool], what: str) -> None:
    r"""\MaxTime ends the wait, with an error or by the flag that \TimeFlag names."""
    flag, task = given.options.get("timeflag"), given.machine.task
    met, longest = is_met(), None
    if not met:
        longest = given.optional_number("maxtime")
        met = task.wait(is_met, longest, what)
    if flag is not None:
        place(given.machine, flag).set(not met)
    if met:
        return
    if flag is None:
        raise Fault(f"{what}, and the longest time is over", "ERR_WAIT_MAXTIME")
    task.tell(Waited(longest or 0.0))


def _wait(name: str, does: Callable[[Given], None], count: int = 2) -> tuple[str, Function]:
    return takes(name, count, does, f"maxtime timeflag lt gt noteq {LOOKS}")


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("Set", 1, _set),
        takes("Reset", 1, _reset),
        takes("SetDO", 2, _set_digital, "sync"),
        takes("SetGO", 2, _set_number),
        takes("SetAO", 2, _set_number),
        takes("InvertDO", 1, _invert),
        takes("PulseDO", 1, _pulse, "high plength"),
        takes("WaitTime", 1, _wait_time, "inpos"),
        *(_wait(f"Wait{kind}", _wait_for) for kind in ("DI", "DO", "GI", "GO", "AI", "AO")),
        _wait("WaitUntil", _wait_until, 1),
    )
)
"""A \\SDelay, which sets a signal later, is not simulated."""
