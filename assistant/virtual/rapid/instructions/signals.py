"""Outputs.

Instructions manual, SetDO and its kin, PulseDO, AliasIO.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.kernel.motion import Instant
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.scopes import Signal
from assistant.virtual.rapid.types import OUTPUT_TYPES, SIGNAL_TYPES
from assistant.virtual.rapid.values import Handle

PULSE_LENGTH: Final = 0.2
SHORTEST_PULSE: Final = 0.001
LONGEST_PULSE: Final = 2000.0
"""Seconds of a pulse: without `PLength`, and with it (reference, 3)."""


def _set_output(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 1.0)


def _reset_output(given: Given) -> None:
    given.machine.signals.set(given.signal(0), 0.0)


def _invert_output(given: Given) -> None:
    signal, signals = given.signal(0), given.machine.signals
    signals.set(signal, float(signals.read(signal) == 0.0))


def _pulse_output(given: Given) -> None:
    r"""Without \High the pulse is the other value than that which the signal has.

    Where motions take no time, both of its ends come at once: the program does not wait for the
    second. Else a new pulse of the same signal takes the place of one that lasts.
    """
    signal, signals = given.signal(0), given.machine.signals
    value = 1.0 if given.has("high") else float(signals.read(signal) == 0.0)
    length = given.optional_number("plength")
    length = PULSE_LENGTH if length is None else length
    if not SHORTEST_PULSE <= length <= LONGEST_PULSE:
        raise Fault(
            f"a pulse of {length:g} s, which takes {SHORTEST_PULSE:g} to {LONGEST_PULSE:g} s"
        )
    signals.set(signal, value)
    if has_time(given):
        signals.set_later(signal, 1.0 - value, length)
    else:
        signals.set(signal, 1.0 - value, after=length)


def has_time(given: Given) -> bool:
    return not isinstance(given.machine.task.kernel.motion, Instant)


def _delayed_output(value: Callable[[Given], float]) -> Callable[[Given], None]:
    r"""SetDO and its kin: at once, or with \SDelay while the program goes on."""

    def does(given: Given) -> None:
        delay = given.optional_number("sdelay")
        signal, signals = given.signal(0), given.machine.signals
        if delay is None or not has_time(given):
            signals.set(signal, value(given), after=delay)
        else:
            signals.set_later(signal, value(given), delay)

    return does


def _alias_signal(given: Given) -> None:
    """The name is text, or that of a signal itself; the configuration is taken to have it."""
    target, source = given.place(1).get(), given.required[0]
    if not isinstance(target, Handle) or target.type not in SIGNAL_TYPES:
        raise Fault("an alias of what is no data of a signal", "ERR_ALIASIO_DEF")
    name = given.signal(0) if _names_signal(given, source) else given.text(0).lower()
    if not name:
        raise Fault("an alias of a signal without a name", "ERR_ALIASIO_DEF")
    controller = given.machine.controller
    controller.known.add(name)
    if target.type in OUTPUT_TYPES:
        controller.outputs.add(name)
    target.inside = name


def _names_signal(given: Given, node: s.Expression) -> bool:
    if not isinstance(node, s.NameRef):
        return False
    meaning = given.machine.meaning(node.name)
    return meaning is None or isinstance(meaning, Signal)


def _end_alias(given: Given) -> None:
    target = given.place(0).get()
    if not isinstance(target, Handle) or target.type not in SIGNAL_TYPES:
        raise Fault("an alias of what is no data of a signal", "ERR_ALIASIO_DEF")
    target.inside = None


SIGNAL_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("AliasIO", 2, _alias_signal),
        table_row("AliasIOReset", 1, _end_alias),
        table_row("Set", 1, _set_output),
        table_row("Reset", 1, _reset_output),
        table_row(
            "SetDO", 2, _delayed_output(lambda given: float(given.number(1) != 0.0)), "sync sdelay"
        ),
        table_row("SetGO", 2, _delayed_output(lambda given: given.number(1)), "sdelay"),
        table_row("SetAO", 2, _delayed_output(lambda given: given.number(1))),
        table_row("InvertDO", 1, _invert_output),
        table_row("PulseDO", 1, _pulse_output, "high plength"),
    )
)
