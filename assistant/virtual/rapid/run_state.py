"""Counters, clocks, the teach pendant and facts about the run: Incr, ClkStart, OpMode, CDate.

Date and time of day are those of the simulated clock (functions manual, CDate, CTime, GetTime).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Final

from assistant.virtual.events import Said, Stopped
from assistant.virtual.kernel import kernel
from assistant.virtual.rapid import records
from assistant.virtual.rapid.call_arguments import Given, is_present, table_row
from assistant.virtual.rapid.control_flow import Cycled, Fault, NotSimulated
from assistant.virtual.rapid.expressions import whole
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.scopes import Storage
from assistant.virtual.rapid.values import Clock, as_kind, paired, text_of

_BUS_RUNS: Final = 1.0
"""BUSSTATE_RUN: nothing is broken here."""


def _change_counter(change: Callable[[Given], float]) -> Callable[[Given], None]:
    def does(given: Given) -> None:
        place = given.place(0)
        value = place.get()
        one, two, kind = paired(records.number(value), change(given))
        place.set(as_kind(one + two, kind))

    return does


def _clear_counter(given: Given) -> None:
    given.place(0).set(0.0)


def _change_bit(value: bool) -> Callable[[Given], None]:
    """BitSet and BitClear of a byte, whose bits count from 1."""

    def does(given: Given) -> None:
        place = given.place(0)
        mask = 1 << (whole(given.number(1), "the place of a bit") - 1)
        bits = whole(records.number(place.get()), "a byte")
        place.set(float(bits | mask if value else bits & ~mask))

    return does


def _clock_argument(given: Given) -> Clock:
    value = given.place(0).get()
    if not isinstance(value, Clock):
        raise Fault("what is no clock is used as one")
    return value


def _reset_clock(given: Given) -> None:
    """A clock that runs is stopped, too (RAPID reference manual, ClkReset)."""
    one = _clock_argument(given)
    one.total, one.since = 0.0, None


def _start_clock(given: Given) -> None:
    one, kernel = _clock_argument(given), given.machine.task.kernel
    if one.since is None:
        one.since = kernel.now
        # As a timer in other languages, it begins a wait of its own.
        if kernel.timed is not None:
            kernel.timed()


def _stop_clock(given: Given) -> None:
    one = _clock_argument(given)
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
    """Ignore an instruction that only changes the display of the teach pendant."""


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
        table_row("IOBusState", 2, lambda given: given.place(1).set(_BUS_RUNS), "phys logic"),
        table_row("TPErase", 0, _no_effect),
        table_row("TPShow", 1, _no_effect),
        table_row("Stop", 0, _stop_program, "noregain allmovetasks"),
        table_row("Break", 0, _stop_program),
        table_row("ExitCycle", 0, _next_cycle),
    )
)


def _is_given(given: Given) -> bool:
    return is_present(given.machine, given.required[0])


def _dimension_size(given: Given) -> float:
    sizes = given.place(0).shape.sizes
    dimension = whole(given.number(1), "a dimension")
    if not 1 <= dimension <= len(sizes):
        raise Fault(f"there is no dimension {dimension}", "ERR_ILLDIM")
    return float(sizes[dimension - 1])


def _is_stored_as(*storages: Storage) -> Callable[[Given], bool]:
    """Return a function that checks the storage of data; for a parameter that refers to data, that
    of the data.
    """
    return lambda given: given.place(0).storage in storages


def _read_signal(given: Given) -> float:
    return given.machine.signals.read(given.signal(0))


def _test_signal(given: Given) -> bool:
    return _read_signal(given) != 0.0


def _read_clock(given: Given) -> float:
    one = _clock_argument(given)
    if one.since is not None:
        # A wait for this value ends without any event.
        given.machine.hangs_on.add("time")
    return one.total + (0.0 if one.since is None else given.machine.task.kernel.now - one.since)


def _remaining_retries(given: Given) -> float:
    """Return the remaining retries of the statement whose error is handled."""
    frame = given.machine.frame
    if frame.handling is None:
        raise NotSimulated("RemainingRetries outside of an error handler")
    return float(frame.retries)


def _fastest_speed(given: Given) -> float:
    robot = given.machine.robot
    return _FASTEST_SPEED if robot is None or robot.tcp_speed is None else float(robot.tcp_speed)


_AUTOMATIC_MODE: Final = 1.0
"""OP_AUTO."""
_CONTINUOUS_MODE: Final = 1.0
"""RUN_CONT_CYCLE."""
_UNIT_RUNNING: Final = 21.0
"""IOUNIT_PHYS_STATE_RUNNING: nothing is broken here."""
_FASTEST_SPEED: Final = 5000.0
"""Highest speed of an unknown arm in mm/s."""
_READING_FUNCTIONS: Final = (
    *("DInput", "DOutput", "GInput", "GOutput", "AInput", "AOutput"),
    *("GInputDnum", "GOutputDnum"),
)

_SYSTEM_INFO: Final = {
    "serialno": "14-21858",
    "swversion": "6.08.00.00",
    "swversionname": "6.08",
    "robottype": "2400-10/1.5 Type A",
    "ctrlid": "My controller",
    "lanip": "192.168.8.103",
    "ctrllang": "en",
    "systemname": "MYSYSTEM",
}
"""Values of GetSysInfo for this controller, by its switch."""


def _system_info(given: Given) -> str:
    (option,) = given.options
    return _SYSTEM_INFO[option]


RUN_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Present", 1, _is_given),
        table_row("Dim", 2, _dimension_size),
        table_row("IsVar", 1, _is_stored_as("VAR", "IN")),
        table_row("IsPers", 1, _is_stored_as("PERS")),
        table_row("TestDI", 1, _test_signal),
        *(table_row(name, 1, _read_signal) for name in _READING_FUNCTIONS),
        table_row("RobOS", 0, lambda _: False),
        table_row("GetSysInfo", 0, _system_info, " ".join(_SYSTEM_INFO)),
        table_row("OpMode", 0, lambda _: _AUTOMATIC_MODE),
        table_row("RunMode", 0, lambda _: _CONTINUOUS_MODE, "main"),
        table_row("IOUnitState", 1, lambda _: _UNIT_RUNNING, "phys logic"),
        table_row("UIClientExist", 0, lambda _: True),
        table_row("CSpeedOverride", 0, lambda _: 100.0, "ctask"),
        table_row("MaxRobSpeed", 0, _fastest_speed),
        table_row("PMgrTaskName", 0, lambda given: given.machine.task.name),
        table_row("RemainingRetries", 0, _remaining_retries),
        table_row("ClkRead", 1, _read_clock, "highres"),
    )
)


_TIME_PARTS: Final[Mapping[str, Callable[[datetime], int]]] = {
    "wday": datetime.isoweekday,
    "hour": lambda moment: moment.hour,
    "min": lambda moment: moment.minute,
    "sec": lambda moment: moment.second,
}
"""By option of GetTime; Monday is 1."""


def _time_now(given: Given) -> datetime:
    machine = given.machine
    machine.hangs_on.add("time")
    return kernel.date_at(machine.task.kernel.now, machine.controller.options.began)


def _time_part(given: Given) -> float:
    named = [name for name in _TIME_PARTS if given.has(name)]
    if len(named) != 1:
        raise NotSimulated("GetTime without one part of the time that it is asked for")
    return float(_TIME_PARTS[named[0]](_time_now(given)))


DATE_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("CDate", 0, lambda given: f"{_time_now(given):%Y-%m-%d}"),
        table_row("CTime", 0, lambda given: f"{_time_now(given):%H:%M:%S}"),
        table_row("GetTime", 0, _time_part, " ".join(_TIME_PARTS)),
    )
)
