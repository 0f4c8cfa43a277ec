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
class State:
    """name, type: of the data of the cell. usual: what stands for it until the cell says it, as a
    virtual controller has it. options: those of the function that change nothing there.
    """

    name: str
    type: str
    usual: Plain
    arguments: int = 0
    options: frozenset[str] = frozenset()


_PHYSICAL: Final = frozenset({"phys", "logic"})
_TASK: Final = State("controller_task", "string", "T_ROB1")
STATES: Final[Mapping[str, State]] = {
    "gettaskname": _TASK,
    "pmgrtaskname": _TASK,
    "robos": State("controller_is_real", "bool", False),
    "opmode": State("controller_mode", "num", 1.0),
    "runmode": State("controller_run_mode", "num", 1.0, 0, frozenset({"main"})),
    "maxrobspeed": State("controller_fastest", "num", 5000.0),
    "cspeedoverride": State("controller_override", "num", 100.0, 0, frozenset({"ctask"})),
    "iounitstate": State("controller_unit_state", "num", 21.0, 1, _PHYSICAL),
    "uiclientexist": State("controller_has_pendant", "bool", True),
    "iobusstate": State("controller_bus_state", "num", 1.0, 2, _PHYSICAL),
}
"""By lower-case name of the function, or of the instruction whose last argument takes the value.

Numbers are those of `OP_AUTO`, `RUN_CONT_CYCLE`, `IOUNIT_PHYS_STATE_RUNNING` and `BUSSTATE_RUN`,
see `words.ELSEWHERE`.
"""
TASK_NUMBER: Final = State("controller_task_number", "num", 1.0)
NUMBERS: Final = frozenset({"taskno", "mectaskno"})
"""Options of `GetTaskName` in lower case, to whose variable it gives the number of the task."""
LAST_ERROR: Final = State("controller_error", "num", 0.0)
"""Value of `ERRNO` where nothing handles an error."""
COUNT: Final = "_tasks"
"""Behind the name of a list of tasks, of the cell's number of programs that meet there."""
MEETING: Final = frozenset(("waitsynctask", "syncmoveon"))
"""Instructions at which the tasks of a list meet."""
_SYSTEM: Final = "getsysinfo"
OF_SYSTEM: Final[Mapping[str, State]] = {
    "serialno": State("controller_serial_number", "string", "14-21858"),
    "swversion": State("controller_version", "string", "6.08.00.00"),
    "swversionname": State("controller_version_name", "string", "6.08"),
    "robottype": State("controller_robot_type", "string", "2400-10/1.5 Type A"),
    "ctrlid": State("controller_name", "string", "My controller"),
    "lanip": State("controller_address", "string", "192.168.8.103"),
    "ctrllang": State("controller_language", "string", "en"),
    "systemname": State("controller_system", "string", "MYSYSTEM"),
}
"""What `GetSysInfo` tells, by its switch in lower case; the texts are made up like those of its
examples."""
OF_OPTIONS: Final = frozenset(one.name for one in OF_SYSTEM.values())
"""Names of what an option chooses."""
BY_NAME: Final[Mapping[str, State]] = {
    one.name: one for one in (*STATES.values(), *OF_SYSTEM.values(), TASK_NUMBER, LAST_ERROR)
}


def state_of(word: str, options: Collection[str]) -> State | None:
    """What a function or instruction gives, None of one that tells nothing of the controller.

    options: the names of its options.
    """
    if word.lower() != _SYSTEM:
        return STATES.get(word.lower())
    (option,) = options if len(options) == 1 else ("",)
    return OF_SYSTEM.get(option.lower())


OPTIONS_OF_A_CELL: Final = frozenset(
    {"Production Manager", "SmarTac", "SmartGripper", "Servo Tool", "Spot Welding", "Tool Change"}
)
"""Options of RobotWare whose routines drive equipment of one make, or answer another program."""
OF_A_CELL: Final = frozenset(
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
