"""Data of RAPID: limits, reserved words, predefined speeds and zones, types of values.

Sources: the RAPID kernel manual (3HAC050946) for words and limits; the instruction and
data type manual (3HAC050917) for predefined data, checked against two open tables
(RobotComponents, rpiRobotics/abb_motion_program_exec).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from assistant.program.expressions import EXTERNAL
from assistant.program.motion import Blend, Speed
from assistant.program.program import ValueType

LONGEST_NAME: Final = 32
TYPE_ENDING: Final = "data"
"""What the names of many types have in common."""
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
"""Where a unit that is loaded for a call stands on the controller."""

RESERVED: Final = frozenset(
    """
    alias and backward case connect const default div do else elseif endfor endfunc endif
    endmodule endproc endrecord endtest endtrap endwhile error exit false for from func goto if
    inout local mod module nostepin not noview or pers proc raise readonly record retry return
    step sysmodule task test then to trap true trynext undo var viewonly while with xor
    """.split()  # noqa: SIM905
)

CELL_MODULE: Final = "CellValues"
"""The module with what a cell file says of names that nobody else declares."""
PREDEFINED_VALUES: Final = {"low": 0, "high": 1}
"""Constants of type dionum, by lower-case name (RAPID reference manual, data types)."""

BUTTON_ANSWERS: Final = {
    "resunkwn": 0, "resok": 1, "resabort": 2, "resretry": 3, "resignore": 4, "rescancel": 5,
    "resyes": 6, "resno": 7,
}  # fmt: skip
"""Constants of type btnres, by lower-case name (RAPID reference manual, data types)."""
STATE_CONSTANTS: Final = {
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
ICONS: Final = {"iconnone": 0, "iconinfo": 1, "iconwarning": 2, "iconerror": 3}
"""Constants of type icondata (the same)."""
INTEGER_TYPES: Final = {
    "usint": 1, "uint": 2, "udint": 4, "ulint": 8, "sint": -1, "int": -2, "dint": -4, "lint": -8,
}  # fmt: skip
"""Constants of type inttypes (the same)."""
SOCKET_STATES: Final = {
    "socket_created": 1, "socket_connected": 2, "socket_bound": 3, "socket_listening": 4,
    "socket_closed": 5,
}  # fmt: skip
"""Constants of type socketstatus (the same)."""
CAPITALS: Final = "".join(map(chr, (*range(65, 91), *range(0xC0, 0xD7), *range(0xD8, 0xDF))))
"""The letters of Latin-1 that have both cases."""
PORTABLE_CONSTANTS: Final[Mapping[str, float | str]] = {
    **BUTTON_ANSWERS, **STATE_CONSTANTS, **ICONS, **INTEGER_TYPES, **SOCKET_STATES, "pi": math.pi,
    "str_digit": "0123456789",
    "errstr_task": "TASK", "errstr_context": "CONTEXT", "errstr_unused": "", "errstr_empty": "",
    "stempty": "", "eof": "EOF", "eof_num": 9.998e36, "wait_max": 99999.0,
    "str_upper": CAPITALS, "str_lower": CAPITALS.lower(),
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
