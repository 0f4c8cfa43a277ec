"""Counting, clocks, the teach pendant and the program's own end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.events import Said, Stopped
from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Cycled, Fault
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.precision import as_kind, paired
from assistant.virtual.rapid.values import Clock, text_of

BUS_RUNS: Final = 1.0
"""BUSSTATE_RUN: nothing is broken here."""


def _change_counter(change: Callable[[Given], float]) -> Callable[[Given], None]:
    def does(given: Given) -> None:
        place = given.place(0)
        value = place.get()
        one, two, kind = paired(poses.number(value), change(given))
        place.set(as_kind(one + two, kind))

    return does


def _clear_counter(given: Given) -> None:
    given.place(0).set(0.0)


def _change_bit(value: bool) -> Callable[[Given], None]:
    """BitSet and BitClear of a byte, whose bits count from 1."""

    def does(given: Given) -> None:
        place = given.place(0)
        mask = 1 << (whole(given.number(1), "the place of a bit") - 1)
        bits = whole(poses.number(place.get()), "a byte")
        place.set(float(bits | mask if value else bits & ~mask))

    return does


def clock_argument(given: Given) -> Clock:
    value = given.place(0).get()
    if not isinstance(value, Clock):
        raise Fault("what is no clock is used as one")
    return value


def _reset_clock(given: Given) -> None:
    """A clock that runs is stopped, too (RAPID reference manual, ClkReset)."""
    one = clock_argument(given)
    one.total, one.since = 0.0, None


def _start_clock(given: Given) -> None:
    one, kernel = clock_argument(given), given.machine.task.kernel
    if one.since is None:
        one.since = kernel.now
        if kernel.timed is not None:
            kernel.timed()


def _stop_clock(given: Given) -> None:
    one = clock_argument(given)
    if one.since is not None:
        one.total += given.machine.task.kernel.now - one.since
        one.since = None


def _write_pendant(given: Given) -> None:
    kinds = ("num", "bool", "pos", "orient", "dnum")
    values = [given.optional(kind, kind) for kind in kinds if given.has(kind)]
    said = [given.text(0), *(text_of(value) for value in values if value is not None)]
    given.machine.task.tell(Said("".join(said)))


def _stop_program(given: Given) -> None:
    given.machine.task.tell(Stopped())


def _next_cycle(_: Given) -> None:
    raise Cycled


def _no_effect(given: Given) -> None:
    """What only a person at the teach pendant sees."""


RUN_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Incr", 1, _change_counter(lambda _: 1.0)),
        table_row("Decr", 1, _change_counter(lambda _: -1.0)),
        table_row("Add", 2, _change_counter(lambda given: given.number(1))),
        table_row("Clear", 1, _clear_counter),
        table_row("BitSet", 2, _change_bit(True)),
        table_row("BitClear", 2, _change_bit(False)),
        table_row("ClkReset", 1, _reset_clock),
        table_row("ClkStart", 1, _start_clock),
        table_row("ClkStop", 1, _stop_clock),
        table_row("TPWrite", 1, _write_pendant, "num bool pos orient dnum"),
        table_row("IOBusState", 2, lambda given: given.place(1).set(BUS_RUNS), "phys logic"),
        table_row("TPErase", 0, _no_effect),
        table_row("TPShow", 1, _no_effect),
        table_row("Stop", 0, _stop_program, "noregain allmovetasks"),
        table_row("Break", 0, _stop_program),
        table_row("ExitCycle", 0, _next_cycle),
    )
)
