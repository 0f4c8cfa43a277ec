"""Functions of RAPID that tell about the controller itself, which another one cannot know.

What they give is the cell's to say: data of the cell file, which a program asks instead.
Reference manual of functions: GetTaskName, GetSysInfo, RobOS, OpMode, RunMode, MaxRobSpeed,
CSpeedOverride, IOUnitState, UIClientExist; of instructions: IOBusState; application manual of the
Production Manager: PMgrTaskName.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Final

from assistant.program.undeclared_names import Plain


@dataclass(frozen=True, slots=True)
class ControllerState:
    """name, type: of the data of the cell. usual: what stands for it until the cell says it, as a
    virtual controller has it. options: those of the function that change nothing there.
    """

    name: str
    type: str
    usual: Plain
    arguments: int = 0
    options: frozenset[str] = frozenset()


_PHYSICAL: Final = frozenset({"phys", "logic"})
_TASK: Final = ControllerState("controller_task", "string", "T_ROB1")
CONTROLLER_STATES: Final[Mapping[str, ControllerState]] = {
    "gettaskname": _TASK,
    "pmgrtaskname": _TASK,
    "robos": ControllerState("controller_is_real", "bool", False),
    "opmode": ControllerState("controller_mode", "num", 1.0),
    "runmode": ControllerState("controller_run_mode", "num", 1.0, 0, frozenset({"main"})),
    "maxrobspeed": ControllerState("controller_fastest", "num", 5000.0),
    "cspeedoverride": ControllerState("controller_override", "num", 100.0, 0, frozenset({"ctask"})),
    "iounitstate": ControllerState("controller_unit_state", "num", 21.0, 1, _PHYSICAL),
    "uiclientexist": ControllerState("controller_has_pendant", "bool", True),
    "iobusstate": ControllerState("controller_bus_state", "num", 1.0, 2, _PHYSICAL),
}
"""By lower-case name of the function, or of the instruction whose last argument takes the value.

Numbers are those of `OP_AUTO`, `RUN_CONT_CYCLE`, `IOUNIT_PHYS_STATE_RUNNING` and `BUSSTATE_RUN`,
see `words.ELSEWHERE`.
"""
TASK_NUMBER: Final = ControllerState("controller_task_number", "num", 1.0)
TASK_NUMBER_OPTIONS: Final = frozenset({"taskno", "mectaskno"})
"""Options of `GetTaskName` in lower case, to whose variable it gives the number of the task."""
LAST_ERROR: Final = ControllerState("controller_error", "num", 0.0)
"""Value of `ERRNO` where nothing handles an error."""
TASK_COUNT_SUFFIX: Final = "_tasks"
"""Behind the name of a list of tasks, of the cell's number of programs that meet there."""
TASK_MEETINGS: Final = frozenset(("waitsynctask", "syncmoveon"))
"""Instructions at which the tasks of a list meet."""
_SYSTEM: Final = "getsysinfo"
SYSTEM_INFO: Final[Mapping[str, ControllerState]] = {
    "serialno": ControllerState("controller_serial_number", "string", "14-21858"),
    "swversion": ControllerState("controller_version", "string", "6.08.00.00"),
    "swversionname": ControllerState("controller_version_name", "string", "6.08"),
    "robottype": ControllerState("controller_robot_type", "string", "2400-10/1.5 Type A"),
    "ctrlid": ControllerState("controller_name", "string", "My controller"),
    "lanip": ControllerState("controller_address", "string", "192.168.8.103"),
    "ctrllang": ControllerState("controller_language", "string", "en"),
    "systemname": ControllerState("controller_system", "string", "MYSYSTEM"),
}
"""What `GetSysInfo` tells, by its switch in lower case; the texts are made up like those of its
examples."""
SYSTEM_INFO_NAMES: Final = frozenset(one.name for one in SYSTEM_INFO.values())
"""Names of what an option chooses."""
STATE_BY_NAME: Final[Mapping[str, ControllerState]] = {
    one.name: one
    for one in (*CONTROLLER_STATES.values(), *SYSTEM_INFO.values(), TASK_NUMBER, LAST_ERROR)
}


def state_of(word: str, options: Collection[str]) -> ControllerState | None:
    """What a function or instruction gives, None of one that tells nothing of the controller.

    options: the names of its options.
    """
    if word.lower() != _SYSTEM:
        return CONTROLLER_STATES.get(word.lower())
    (option,) = options if len(options) == 1 else ("",)
    return SYSTEM_INFO.get(option.lower())


CELL_OPTIONS: Final = frozenset(
    {"Production Manager", "SmarTac", "SmartGripper", "Servo Tool", "Spot Welding", "Tool Change"}
)
"""Options of RobotWare whose routines drive equipment of one make, or answer another program."""
CELL_ROUTINES: Final = frozenset(
    {
        "fitcircle",
        "mtoolrotcalib",
        "mtooltcpcalib",
        "readcfgdata",
        "textget",
        "texttabget",
        "writecfgdata",
    }
)
"""Other routines, in lower case, that work by what only the first controller has: its texts, its
configuration, its way to measure tools."""
