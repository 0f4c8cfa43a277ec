"""Counting, clocks, the teach pendant and the program's own end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.events import Said, Stopped
from assistant.virtual.rapid import poses
from assistant.virtual.rapid.ends import Cycled, Fault
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.precision import as_kind, paired
from assistant.virtual.rapid.values import Clock, text_of

BUS_RUNS: Final = 1.0
"""BUSSTATE_RUN: nothing is broken here."""


def _add(change: Callable[[Given], float]) -> Callable[[Given], None]:
    def does(given: Given) -> None:
        place = given.place(0)
        value = place.get()
        one, two, kind = paired(poses.number(value), change(given))
        place.set(as_kind(one + two, kind))

    return does


def _clear(given: Given) -> None:
    given.place(0).set(0.0)


def _bit(value: bool) -> Callable[[Given], None]:
    """BitSet and BitClear of a byte, whose bits count from 1."""

    def does(given: Given) -> None:
        place = given.place(0)
        mask = 1 << (whole(given.number(1), "the place of a bit") - 1)
        bits = whole(poses.number(place.get()), "a byte")
        place.set(float(bits | mask if value else bits & ~mask))

    return does


def clock(given: Given) -> Clock:
    value = given.place(0).get()
    if not isinstance(value, Clock):
        raise Fault("what is no clock is used as one")
    return value


def _reset(given: Given) -> None:
    """A clock that runs is stopped, too (RAPID reference manual, ClkReset)."""
    one = clock(given)
    one.total, one.since = 0.0, None


def _start(given: Given) -> None:
    one, kernel = clock(given), given.machine.task.kernel
    if one.since is None:
        one.since = kernel.now
        if kernel.timed is not None:
            kernel.timed()


def _stop(given: Given) -> None:
    one = clock(given)
    if one.since is not None:
        one.total += given.machine.task.kernel.now - one.since
        one.since = None


def _say(given: Given) -> None:
    kinds = ("num", "bool", "pos", "orient", "dnum")
    values = [given.optional(kind, kind) for kind in kinds if given.has(kind)]
    said = [given.text(0), *(text_of(value) for value in values if value is not None)]
    given.machine.task.tell(Said("".join(said)))


def _halt(given: Given) -> None:
    given.machine.task.tell(Stopped())


def _next_cycle(_: Given) -> None:
    raise Cycled


def _nothing(given: Given) -> None:
    """What only a person at the teach pendant sees."""


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("Incr", 1, _add(lambda _: 1.0)),
        takes("Decr", 1, _add(lambda _: -1.0)),
        takes("Add", 2, _add(lambda given: given.number(1))),
        takes("Clear", 1, _clear),
        takes("BitSet", 2, _bit(True)),
        takes("BitClear", 2, _bit(False)),
        takes("ClkReset", 1, _reset),
        takes("ClkStart", 1, _start),
        takes("ClkStop", 1, _stop),
        takes("TPWrite", 1, _say, "num bool pos orient dnum"),
        takes("IOBusState", 2, lambda given: given.place(1).set(BUS_RUNS), "phys logic"),
        takes("TPErase", 0, _nothing),
        takes("TPShow", 1, _nothing),
        takes("Stop", 0, _halt, "noregain allmovetasks"),
        takes("Break", 0, _halt),
        takes("ExitCycle", 0, _next_cycle),
    )
)
