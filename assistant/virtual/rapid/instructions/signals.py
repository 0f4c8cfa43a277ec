"""Outputs.

Instructions manual, SetDO and its kin, PulseDO.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.kernel.motion import Instant
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function

PULSE: Final = 0.2
SHORTEST: Final = 0.001
LONGEST: Final = 2000.0
"""Seconds of a pulse: without `PLength`, and with it (reference, 3)."""


def _set(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 1.0)


def _reset(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 0.0)


def _invert(given: Given) -> None:
    signal, signals = given.signal(0), given.machine.signals
    signals.set(signal, float(signals.read(signal) == 0.0))


def _pulse(given: Given) -> None:
    r"""Without \High the pulse is the other value than that which the signal has.

    Where motions take no time, both of its ends come at once: the program does not wait for the
    second. Else a new pulse of the same signal takes the place of one that lasts.
    """
    signal, signals = given.signal(0), given.machine.signals
    value = 1.0 if given.has("high") else float(signals.read(signal) == 0.0)
    length = given.optional_number("plength")
    length = PULSE if length is None else length
    if not SHORTEST <= length <= LONGEST:
        raise Fault(f"a pulse of {length:g} s, which takes {SHORTEST:g} to {LONGEST:g} s")
    signals.set(signal, value)
    if has_time(given):
        signals.set_later(signal, 1.0 - value, length)
    else:
        signals.set(signal, 1.0 - value)


def has_time(given: Given) -> bool:
    return not isinstance(given.machine.task.kernel.motion, Instant)


def _delayed(value: Callable[[Given], float]) -> Callable[[Given], None]:
    r"""SetDO and its kin: at once, or with \SDelay while the program goes on."""

    def does(given: Given) -> None:
        delay = given.optional_number("sdelay")
        signal, signals = given.signal(0), given.machine.signals
        if delay is None:
            signals.set(signal, value(given))
        elif not has_time(given):
            raise NotSimulated(r"`\sdelay` where motions take no time")
        else:
            signals.set_later(signal, value(given), delay)

    return does


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("Set", 1, _set),
        takes("Reset", 1, _reset),
        takes("SetDO", 2, _delayed(lambda given: float(given.number(1) != 0.0)), "sync sdelay"),
        takes("SetGO", 2, _delayed(lambda given: given.number(1)), "sdelay"),
        takes("SetAO", 2, _delayed(lambda given: given.number(1))),
        takes("InvertDO", 1, _invert),
        takes("PulseDO", 1, _pulse, "high plength"),
    )
)
