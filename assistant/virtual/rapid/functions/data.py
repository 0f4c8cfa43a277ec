"""Functions that ask about data, parameters, signals and clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, is_present, table_row
from assistant.virtual.rapid.instructions.others import clock_argument
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.scopes import Storage


def _is_given(given: Given) -> bool:
    return is_present(given.machine, given.required[0])


def _dimension_size(given: Given) -> float:
    sizes = given.place(0).shape.sizes
    dimension = whole(given.number(1), "a dimension")
    if not 1 <= dimension <= len(sizes):
        raise Fault(f"there is no dimension {dimension}", "ERR_ILLDIM")
    return float(sizes[dimension - 1])


def _is_stored_as(*storages: Storage) -> Callable[[Given], bool]:
    """Whether data is stored so; of a parameter that refers to data, how that is."""
    return lambda given: given.place(0).storage in storages


def _read_signal(given: Given) -> float:
    return given.machine.signals.read(given.signal(0))


def _test_signal(given: Given) -> bool:
    return _read_signal(given) != 0.0


def _read_clock(given: Given) -> float:
    one = clock_argument(given)
    if one.since is not None:
        given.machine.hangs_on.add("time")
    return one.total + (0.0 if one.since is None else given.machine.task.kernel.now - one.since)


def _remaining_retries(given: Given) -> float:
    """Of the statement whose error is handled."""
    frame = given.machine.frame
    if frame.handling is None:
        raise NotSimulated("RemainingRetries outside of an error handler")
    return float(frame.retries)


def _fastest_speed(given: Given) -> float:
    robot = given.machine.robot
    return FASTEST_SPEED if robot is None or robot.tcp_speed is None else float(robot.tcp_speed)


AUTOMATIC_MODE: Final = 1.0
"""OP_AUTO."""
CONTINUOUS_MODE: Final = 1.0
"""RUN_CONT_CYCLE."""
UNIT_RUNNING: Final = 21.0
"""IOUNIT_PHYS_STATE_RUNNING: nothing is broken here."""
FASTEST_SPEED: Final = 5000.0
"""mm/s, of an arm that nobody named."""
READING_FUNCTIONS: Final = (
    *("DInput", "DOutput", "GInput", "GOutput", "AInput", "AOutput"),
    *("GInputDnum", "GOutputDnum"),
)

SYSTEM_INFO: Final = {
    "serialno": "14-21858",
    "swversion": "6.08.00.00",
    "swversionname": "6.08",
    "robottype": "2400-10/1.5 Type A",
    "ctrlid": "My controller",
    "lanip": "192.168.8.103",
    "ctrllang": "en",
    "systemname": "MYSYSTEM",
}
"""What GetSysInfo tells of this controller, by its switch."""


def _system_info(given: Given) -> str:
    (option,) = given.options
    return SYSTEM_INFO[option]


RUN_FUNCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("Present", 1, _is_given),
        table_row("Dim", 2, _dimension_size),
        table_row("IsVar", 1, _is_stored_as("VAR", "IN")),
        table_row("IsPers", 1, _is_stored_as("PERS")),
        table_row("TestDI", 1, _test_signal),
        *(table_row(name, 1, _read_signal) for name in READING_FUNCTIONS),
        table_row("RobOS", 0, lambda _: False),
        table_row("GetSysInfo", 0, _system_info, " ".join(SYSTEM_INFO)),
        table_row("OpMode", 0, lambda _: AUTOMATIC_MODE),
        table_row("RunMode", 0, lambda _: CONTINUOUS_MODE, "main"),
        table_row("IOUnitState", 1, lambda _: UNIT_RUNNING, "phys logic"),
        table_row("UIClientExist", 0, lambda _: True),
        table_row("CSpeedOverride", 0, lambda _: 100.0, "ctask"),
        table_row("MaxRobSpeed", 0, _fastest_speed),
        table_row("PMgrTaskName", 0, lambda given: given.machine.task.name),
        table_row("RemainingRetries", 0, _remaining_retries),
        table_row("ClkRead", 1, _read_clock, "highres"),
    )
)
