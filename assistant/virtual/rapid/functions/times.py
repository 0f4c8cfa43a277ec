"""Functions that tell the date and the time of day: of the simulated clock.

Functions manual, CDate, CTime, GetTime.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Final

from assistant.virtual.kernel import dates
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function

PARTS: Final[Mapping[str, Callable[[datetime], int]]] = {
    "wday": datetime.isoweekday,
    "hour": lambda moment: moment.hour,
    "min": lambda moment: moment.minute,
    "sec": lambda moment: moment.second,
}
"""By option of GetTime; Monday is 1."""


def _now(given: Given) -> datetime:
    machine = given.machine
    machine.hangs_on.add("time")
    return dates.at(machine.task.kernel.now, machine.controller.options.began)


def _part(given: Given) -> float:
    named = [name for name in PARTS if given.has(name)]
    if len(named) != 1:
        raise NotSimulated("GetTime without one part of the time that it is asked for")
    return float(PARTS[named[0]](_now(given)))


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("CDate", 0, lambda given: f"{_now(given):%Y-%m-%d}"),
        takes("CTime", 0, lambda given: f"{_now(given):%H:%M:%S}"),
        takes("GetTime", 0, _part, " ".join(PARTS)),
    )
)
