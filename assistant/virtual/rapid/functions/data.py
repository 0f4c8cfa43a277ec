"""Functions that ask about data, parameters, signals and clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.given import Given, is_present, takes
from assistant.virtual.rapid.instructions.others import clock
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.scopes import Storage


def _present(given: Given) -> bool:
    return is_present(given.machine, given.required[0])


def _size(given: Given) -> float:
    sizes = given.place(0).shape.sizes
    dimension = whole(given.number(1), "a dimension")
    if not 1 <= dimension <= len(sizes):
        raise Fault(f"there is no dimension {dimension}", "ERR_ILLDIM")
    return float(sizes[dimension - 1])


def _is(*storages: Storage) -> Callable[[Given], bool]:
    """Whether data is stored so; of a parameter that refers to data, how that is."""
    return lambda given: given.place(0).storage in storages


def _signal(given: Given) -> float:
    return given.machine.signals.read(given.signal(0))


def _test(given: Given) -> bool:
    return _signal(given) != 0.0


def _clock(given: Given) -> float:
    one = clock(given)
    if one.since is not None:
        given.machine.hangs_on.add("time")
    return one.total + (0.0 if one.since is None else given.machine.task.kernel.now - one.since)


def _retries(given: Given) -> float:
    """Of the statement whose error is handled."""
    frame = given.machine.frame
    if frame.handling is None:
        raise NotSimulated("RemainingRetries outside of an error handler")
    return float(frame.retries)


def _fastest(given: Given) -> float:
    robot = given.machine.robot
    return FASTEST if robot is None or robot.tcp_speed is None else float(robot.tcp_speed)


AUTOMATIC: Final = 1.0
"""OP_AUTO."""
CONTINUOUS: Final = 1.0
"""RUN_CONT_CYCLE."""
RUNNING: Final = 21.0
"""IOUNIT_PHYS_STATE_RUNNING: nothing is broken here."""
FASTEST: Final = 5000.0
"""mm/s, of an arm that nobody named."""
READS: Final = (
    *("DInput", "DOutput", "GInput", "GOutput", "AInput", "AOutput"),
    *("GInputDnum", "GOutputDnum"),
)

SYSTEM: Final = {
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


def _of_system(given: Given) -> str:
    (option,) = given.options
    return SYSTEM[option]


TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("Present", 1, _present),
        takes("Dim", 2, _size),
        takes("IsVar", 1, _is("VAR", "IN")),
        takes("IsPers", 1, _is("PERS")),
        takes("TestDI", 1, _test),
        *(takes(name, 1, _signal) for name in READS),
        takes("RobOS", 0, lambda _: False),
        takes("GetSysInfo", 0, _of_system, " ".join(SYSTEM)),
        takes("OpMode", 0, lambda _: AUTOMATIC),
        takes("RunMode", 0, lambda _: CONTINUOUS, "main"),
        takes("IOUnitState", 1, lambda _: RUNNING, "phys logic"),
        takes("UIClientExist", 0, lambda _: True),
        takes("CSpeedOverride", 0, lambda _: 100.0, "ctask"),
        takes("MaxRobSpeed", 0, _fastest),
        takes("PMgrTaskName", 0, lambda given: given.machine.task.name),
        takes("RemainingRetries", 0, _retries),
        takes("ClkRead", 1, _clock, "highres"),
    )
)
