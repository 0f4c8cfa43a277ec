"""Limits, reserved words and constants of RAPID, and the states that a controller reports.

Sources: the RAPID kernel manual (3HAC050946) for words and limits; the instruction and data type
manual (3HAC050917) for predefined data, checked against two open tables (RobotComponents,
rpiRobotics/abb_motion_program_exec).

A controller's own state (task name, operating mode, serial number) is unknown on another
controller: a translated program reads it from data of the cell file instead. Reference manual of
functions: GetTaskName, GetSysInfo, RobOS, OpMode, RunMode, MaxRobSpeed, CSpeedOverride,
IOUnitState, UIClientExist; of instructions: IOBusState; application manual of the Production
Manager: PMgrTaskName.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.program.expressions import EXTERNAL
from assistant.program.motion import Blend, Speed
from assistant.program.program import ValueType
from assistant.program.undeclared_names import Plain

LONGEST_NAME: Final = 32
TYPE_ENDING: Final = "data"
"""Common ending of many type names."""
LONGEST_STRING: Final = 80
MOST_DIMENSIONS: Final = 3
MOST_TARGETS: Final = 5000
"""Targets of one module. ABB states no number; production backups run 1,084 and RoboDK's
post-processor splits its files at 5,000 lines."""
MOST_NESTING: Final = 60
"""Brackets or blocks inside each other that the parser takes; no program comes near it."""

MOST_OPERATORS: Final = 150
"""In a row in one expression, component dots included; no program comes near it."""

LEAST_MASS: Final = 0.001
LEAST_CENTRE: Final = (0.0, 0.0, 0.001)
"""Load of `tool0`: the least that the controller takes; 0 kg stops it with event 41438."""

LEAST_ACCELERATION: Final = 20
"""AccSet takes 20 to 100 percent."""
SPEED_CAP: Final = 5000
"""mm/s; second argument of VelSet at program start."""
SHORTEST_PULSE: Final = 0.001
LONGEST_PULSE: Final = 2000
"""Seconds of `\\PLength`; without it a pulse lasts 0.2 (RAPID reference manual, PulseDO)."""
UNUSED: Final = 9e9
LOADED_FROM: Final = "HOME:/"
"""Controller folder of a unit that is loaded for a call."""

RESERVED: Final = frozenset(
    """
    alias and backward case connect const default div do else elseif endfor endfunc endif
    endmodule endproc endrecord endtest endtrap endwhile error exit false for from func goto if
    inout local mod module nostepin not noview or pers proc raise readonly record retry return
    step sysmodule task test then to trap true trynext undo var viewonly while with xor
    """.split()  # noqa: SIM905
)

CELL_MODULE: Final = "CellValues"
"""Module with the cell file's values for undeclared names."""
PREDEFINED_VALUES: Final = {"low": 0, "high": 1}
"""Constants of type dionum, by lower-case name (RAPID reference manual, data types)."""

BUTTON_ANSWERS: Final = {
    "resunkwn": 0, "resok": 1, "resabort": 2, "resretry": 3, "resignore": 4, "rescancel": 5,
    "resyes": 6, "resno": 7,
}  # fmt: skip
"""Constants of type btnres, by lower-case name (RAPID reference manual, data types)."""
_STATE_CONSTANTS: Final = {
    "op_undef": 0, "op_auto": 1, "op_man_prog": 2, "op_man_test": 3,
    "run_undef": 0, "run_cont_cycle": 1, "run_instr_fwd": 2, "run_instr_bwd": 3, "run_sim": 4,
    "run_step_move": 5,
    "iounit_running": 1, "iounit_runerror": 2, "iounit_disable": 3, "iounit_othererr": 4,
    "iounit_log_state_disabled": 10, "iounit_log_state_enabled": 11,
    "iounit_phys_state_deactivated": 20, "iounit_phys_state_running": 21,
    "iounit_phys_state_error": 22, "iounit_phys_state_unconnected": 23,
    "iounit_phys_state_unconfigured": 24, "iounit_phys_state_startup": 25,
    "iounit_phys_state_init": 26,
    "busstate_halted": 0, "busstate_run": 1, "busstate_error": 2, "busstate_startup": 3,
    "busstate_init": 4,
    "common_err": 0, "op_state": 1, "system_err": 2, "hardware_err": 3, "program_err": 4,
    "motion_err": 5, "operator_err": 6, "io_com_err": 7, "user_def_err": 8,
    "process_err": 11, "cfg_err": 12,
    "type_all": 0, "type_state": 1, "type_warn": 2, "type_err": 3,
}  # fmt: skip
"""Constants of types symnum, iounit_state, busstate, errdomain and errtype (the same)."""
_ICONS: Final = {"iconnone": 0, "iconinfo": 1, "iconwarning": 2, "iconerror": 3}
"""Constants of type icondata (the same)."""
_INTEGER_TYPES: Final = {
    "usint": 1, "uint": 2, "udint": 4, "ulint": 8, "sint": -1, "int": -2, "dint": -4, "lint": -8,
}  # fmt: skip
"""Constants of type inttypes (the same)."""
SOCKET_STATES: Final = {
    "socket_created": 1, "socket_connected": 2, "socket_bound": 3, "socket_listening": 4,
    "socket_closed": 5,
}  # fmt: skip
"""Constants of type socketstatus (the same)."""
_CAPITALS: Final = "".join(map(chr, (*range(65, 91), *range(0xC0, 0xD7), *range(0xD8, 0xDF))))
"""The letters of Latin-1 that have both cases."""
PORTABLE_CONSTANTS: Final[Mapping[str, float | str]] = {
    **BUTTON_ANSWERS, **_STATE_CONSTANTS, **_ICONS, **_INTEGER_TYPES, **SOCKET_STATES,
    "pi": math.pi,
    "str_digit": "0123456789",
    "errstr_task": "TASK", "errstr_context": "CONTEXT", "errstr_unused": "", "errstr_empty": "",
    "stempty": "", "eof": "EOF", "eof_num": 9.998e36, "wait_max": 99999.0,
    "str_upper": _CAPITALS, "str_lower": _CAPITALS.lower(),
}  # fmt: skip
"""Constants that are values for other languages, by lower-case name (the same)."""

_SPEEDS: Final = (
    *(5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800),
    *(1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000),
)

SPEEDS: Final[Mapping[str, Speed]] = {
    **{f"v{v}": Speed(float(v)) for v in _SPEEDS},
    "vmax": Speed(math.inf),
}
"""Every predefined speeddata: [v, 500, 5000, 1000]."""

_ZONE_SIZES: Final = {
    0.3: (0.3, 0.3, 0.03, 0.3, 0.03),
    1: (1, 1, 0.1, 1, 0.1),
    5: (8, 8, 0.8, 8, 0.8),
    10: (15, 15, 1.5, 15, 1.5),
    15: (23, 23, 2.3, 23, 2.3),
    20: (30, 30, 3.0, 30, 3.0),
    30: (45, 45, 4.5, 45, 4.5),
    40: (60, 60, 6.0, 60, 6.0),
    50: (75, 75, 7.5, 75, 7.5),
    60: (90, 90, 9.0, 90, 9.0),
    80: (120, 120, 12, 120, 12),
    100: (150, 150, 15, 150, 15),
    150: (225, 225, 23, 225, 23),
    200: (300, 300, 30, 300, 30),
}

ZONES: Final[Mapping[str, Blend]] = {
    "fine": Blend(),
    "z0": Blend(0.3),
    **{f"z{radius}": Blend(float(radius)) for radius in _ZONE_SIZES if radius >= 1},
}
"""Every predefined zonedata; its further sizes are `usual_sizes` of its radius."""


def usual_sizes(radius: float) -> tuple[float, float, float, float, float]:
    """Sizes of a zone that go with its radius: as predefined, else in the same proportion.

    Reorientation mm, external mm, reorientation deg, external linear mm, external rotary deg.
    """
    if radius in _ZONE_SIZES:
        a, b, c, d, e = _ZONE_SIZES[radius]
        return float(a), float(b), float(c), float(d), float(e)
    length, angle = round(1.5 * radius, 3), round(0.15 * radius, 3)
    return length, length, angle, length, angle


TYPE_OF_VALUE: Final[Mapping[ValueType, str]] = {
    "number": "num",
    "truth": "bool",
    "text": "string",
    "position": "robtarget",
    "pose": "pose",
    "joints": "jointtarget",
}

VALUE_OF_TYPE: Final[Mapping[str, ValueType]] = {t: v for v, t in TYPE_OF_VALUE.items()}

COMPONENTS: Final[Mapping[str, tuple[str, str]]] = {
    **{axis: ("trans", axis) for axis in "xyz"},
    **{f"j{i}": ("robax", f"rax_{i}") for i in range(1, 7)},
    **{name: ("extax", f"eax_{axis}") for name, axis in zip(EXTERNAL, "abcdef", strict=True)},
}
"""Components of positions and joints: pseudo-program → RAPID."""


@dataclass(frozen=True, slots=True)
class ControllerState:
    """A controller state as data of the cell. name, type: of that data. usual: value until the cell
    states one, as on a virtual controller. options: options of the function that do not change the
    result.
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
see `PORTABLE_CONSTANTS`.
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
_SYSTEM_INFO: Final[Mapping[str, ControllerState]] = {
    "serialno": ControllerState("controller_serial_number", "string", "14-21858"),
    "swversion": ControllerState("controller_version", "string", "6.08.00.00"),
    "swversionname": ControllerState("controller_version_name", "string", "6.08"),
    "robottype": ControllerState("controller_robot_type", "string", "2400-10/1.5 Type A"),
    "ctrlid": ControllerState("controller_name", "string", "My controller"),
    "lanip": ControllerState("controller_address", "string", "192.168.8.103"),
    "ctrllang": ControllerState("controller_language", "string", "en"),
    "systemname": ControllerState("controller_system", "string", "MYSYSTEM"),
}
"""Results of `GetSysInfo`, by its switch in lower case; the texts are modelled on its examples."""
SYSTEM_INFO_NAMES: Final = frozenset(one.name for one in _SYSTEM_INFO.values())
"""Names of what an option chooses."""
STATE_BY_NAME: Final[Mapping[str, ControllerState]] = {
    one.name: one
    for one in (*CONTROLLER_STATES.values(), *_SYSTEM_INFO.values(), TASK_NUMBER, LAST_ERROR)
}


def state_of(word: str, options: Collection[str]) -> ControllerState | None:
    """Return the controller state that a function or instruction reads, None for any other one.

    options: the names of its options.
    """
    if word.lower() != _SYSTEM:
        return CONTROLLER_STATES.get(word.lower())
    # GetSysInfo takes exactly one switch, so several choose nothing.
    (option,) = options if len(options) == 1 else ("",)
    return _SYSTEM_INFO.get(option.lower())


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
