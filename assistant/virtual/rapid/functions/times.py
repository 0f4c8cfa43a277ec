"""Functions that tell the date and the time of day: of the simulated clock.

Functions manual, CDate, CTime, GetTime.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Final

from assistant.virtual.kernel import dates
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function

TIME_PARTS: Final[Mapping[str, Callable[[datetime], int]]] = {
    "wday": datetime.isoweekday,
    "hour": lambda moment: moment.hour,
    "min": lambda moment: moment.minute,
    "sec": lambda moment: moment.second,
}
"""By option of GetTime; Monday is 1."""


def _time_now(given: Given) -> datetime:
    machine = given.machine
    machine.hangs_on.add("time")
    return dates.date_at(machine.task.kernel.now, machine.controller.options.began)


def _time_part(given: Given) -> float:
    named = [name for name in TIME_PARTS if given.has(name)]
    if len(named) != 1:
        raise NotSimulated("GetTime without one part of the time that it is asked for")
    return float(TIME_PARTS[named[0]](_time_now(given)))


DATE_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("CDate", 0, lambda given: f"{_time_now(given):%Y-%m-%d}"),
        table_row("CTime", 0, lambda given: f"{_time_now(given):%H:%M:%S}"),
        table_row("GetTime", 0, _time_part, " ".join(TIME_PARTS)),
    )
)
