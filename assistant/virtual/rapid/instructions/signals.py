"""Outputs, and waiting for inputs and for time."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid import motion
from assistant.virtual.rapid.ends import Fault, Over
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
        motion.stop(given.machine)
    given.machine.wait(seconds)


def _wait_for(given: Given) -> None:
    """WaitDI and its kin: the signal is to have the value, or to be beyond it."""
    compare = next((COMPARISONS[name] for name in COMPARISONS if given.has(name)), operator.eq)
    signal, value = given.signal(0), given.number(1)
    reads = given.machine.signals.read(signal)
    _await(given, bool(compare(reads, value)), f"`{signal}` is {reads:g}, {value:g} is waited for")


def _wait_until(given: Given) -> None:
    _await(given, given.truth(0), "the condition that is waited for is not met")


def _await(given: Given, met: bool, else_: str) -> None:
    r"""Signals stay as they are: what is not met now never is, but \MaxTime ends the wait."""
    flag = given.options.get("timeflag")
    if flag is not None:
        place(given.machine, flag).set(not met)
    if met:
        return
    longest = given.optional_number("maxtime")
    if longest is None:
        raise Over("stopped", else_)
    if flag is None:
        raise Fault(f"{else_}, and the longest time is over (ERR_WAIT_MAXTIME)")
    given.machine.wait(longest)


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
