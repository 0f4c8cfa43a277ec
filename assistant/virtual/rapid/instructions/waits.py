"""Waiting: for time, for signals, and for conditions.

Instructions manual, WaitTime, WaitUntil, WaitDI and its kin.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.events import Waited
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import place
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function

LOOK_OPTIONS: Final = (
    "visualize header message msgarray wrap icon image visualizetime uiactivesignal"
)
"""What changes only what a person sees while the program waits."""
COMPARISONS: Final = {"lt": operator.lt, "gt": operator.gt, "noteq": operator.ne}
POLL_PERIOD: Final = 0.1
LEAST_POLL_PERIOD: Final = 0.04
"""Seconds after which a condition is looked at again: without `PollRate`, and at least (manual,
WaitUntil). What only hangs on data and signals of this run is looked at whenever they can change.
"""


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
    _wait_for_condition(given, lambda: bool(compare(read(signal), value)), what)


def _wait_until(given: Given) -> None:
    if given.has("inpos"):
        given.machine.settle()
    _wait_for_condition(
        given, lambda: given.truth(0), "the condition that is waited for is not met"
    )


def _wait_for_condition(given: Given, is_met: Callable[[], bool], what: str) -> None:
    r"""\MaxTime ends the wait, with an error or by the flag that \TimeFlag names."""
    machine, flag = given.machine, given.options.get("timeflag")

    def asked() -> bool:
        machine.hangs_on.clear()
        return is_met()

    longest = given.optional_number("maxtime")
    met = asked() or _is_met_in_time(given, asked, math.inf if longest is None else longest, what)
    if flag is not None:
        place(machine, flag).set(not met)
    if met:
        machine.task.met(asked)
        return
    for node in (given.options[name] for name in TIMEOUT_VALUES if name in given.options):
        assert node is not None
        place(machine, node).set(machine.signals.read(given.signal(0)))
    machine.task.tell(Waited(longest or 0.0, limit=True))
    if flag is None:
        raise Fault(f"{what}, and the longest time is over", "ERR_WAIT_MAXTIME")


def _is_met_in_time(given: Given, asked: Callable[[], bool], longest: float, what: str) -> bool:
    """Whether a condition that was asked comes to be met in time.

    It is asked again and again as long as it hangs on time, or on what is outside of the run.
    """
    hangs_on, task = given.machine.hangs_on, given.machine.task
    poll = max(given.optional_number("pollrate") or POLL_PERIOD, LEAST_POLL_PERIOD)
    since = task.kernel.now
    end = since + longest
    while task.kernel.now < end:
        left = end - task.kernel.now
        if hangs_on:
            task.kernel.spend()
            came = task.wait(asked, min(poll, left), what, outside="outside" in hangs_on)
            if "time" in hangs_on:
                task.looked(since, over=came)
            if came:
                return True
        else:
            came = task.wait(
                lambda: asked() or bool(hangs_on), None if math.isinf(left) else left, what
            )
            if came and not hangs_on:
                return True
    return False


def _wait_row(
    name: str, does: Callable[[Given], None], count: int, more: str
) -> tuple[str, Function]:
    return table_row(name, count, does, f"maxtime timeflag {more} {LOOK_OPTIONS}")


TIMEOUT_VALUES: Final = ("valueattimeout", "dvalueattimeout")
"""Where the value goes that the signal has when the longest time is over."""
WAITED_SIGNALS: Final = ("DI", "DO", "GI", "GO", "AI", "AO")

WAIT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("WaitTime", 1, _wait_time, "inpos"),
        *(
            _wait_row(f"Wait{x}", _wait_for, 2, f"lt gt noteq {' '.join(TIMEOUT_VALUES)}")
            for x in WAITED_SIGNALS
        ),
        _wait_row("WaitUntil", _wait_until, 1, "inpos pollrate"),
    )
)
