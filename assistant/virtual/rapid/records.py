"""Records of positions, speeds, zones and tools: conversion to poses, and predefined data.

Sources of the predefined data: RobotWare's own records as RobotComponents and
abb_motion_program_exec list them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import IDENTITY, Pose, Quaternion, Vector
from assistant.robots import Robot
from assistant.virtual.rapid.control_flow import ERROR_NUMBERS, Fault
from assistant.virtual.rapid.scopes import Cell, Storage
from assistant.virtual.rapid.values import (
    NUMBER,
    Clock,
    Record,
    Shape,
    Value,
    copied,
    fitted,
    kind_of,
)

_MOST_OFF_UNIT: Final = 1e-3
"""Largest distance of an orientation's sum of squares from 1."""
_UNUSED: Final = 9e9
"""An external axis that is not there."""
_LEAST_UNUSED: Final = 8.9e9
"""The same, as rounded as it may be."""


def number(value: Value) -> float:
    # A bool is no number for RAPID.
    if isinstance(value, bool) or not isinstance(value, float):
        raise Fault(f"{kind_of(value)} where a number is wanted")
    return value


def truth(value: Value) -> bool:
    if not isinstance(value, bool):
        raise Fault(f"{kind_of(value)} where a bool is wanted")
    return value


def text(value: Value) -> str:
    if not isinstance(value, str):
        raise Fault(f"{kind_of(value)} where a string is wanted")
    return value


def record(value: Value, *types: str) -> Record:
    if not isinstance(value, Record) or value.type not in types:
        raise Fault(f"{kind_of(value)} where {' or '.join(types)} is wanted")
    return value


def vector_of(value: Value) -> Vector:
    x, y, z = (number(part) for part in record(value, "pos").parts.values())
    return x, y, z


def quaternion_of(value: Value) -> Quaternion:
    """Return a quaternion of unit length; raises Fault for an invalid orientation."""
    q = np.array([number(part) for part in record(value, "orient").parts.values()])
    # `not <=`, so that NaN is refused, too.
    if not abs(float(q @ q) - 1.0) <= _MOST_OFF_UNIT:
        raise Fault("an orientation whose squares do not add up to 1", "ERR_ILLQUAT")
    w, x, y, z = (float(part) for part in rotations.canonical(q))
    return w, x, y, z


def pose_of(value: Value) -> Pose:
    """Return the pose of a pose or a robtarget."""
    parts = record(value, "pose", "robtarget").parts
    return Pose(vector_of(parts["trans"]), quaternion_of(parts["rot"]))


def joints_of(value: Value) -> tuple[float, ...]:
    """The six angles of a jointtarget, in degrees."""
    robax = record(record(value, "jointtarget").parts["robax"], "robjoint")
    return tuple(number(part) for part in robax.parts.values())


def pos(vector: Vector) -> Record:
    return Record("pos", dict(zip("xyz", vector, strict=True)))


def orient(quaternion: Quaternion) -> Record:
    return Record("orient", {f"q{i}": part for i, part in enumerate(quaternion, 1)})


def pose(value: Pose) -> Record:
    return Record("pose", {"trans": pos(value.position), "rot": orient(value.quaternion)})


def confdata(one: float = 0.0, four: float = 0.0, six: float = 0.0, x: float = 0.0) -> Record:
    return Record("confdata", {"cf1": one, "cf4": four, "cf6": six, "cfx": x})


def extjoint() -> Record:
    return Record("extjoint", {f"eax_{letter}": _UNUSED for letter in "abcdef"})


def axes_of(value: Value) -> list[float | None]:
    """The additional axes of an extjoint, None for those that are not used."""
    axes = [number(part) for part in record(value, "extjoint").parts.values()]
    return [None if axis >= _LEAST_UNUSED else axis for axis in axes]


def extjoint_of(value: Value, offsets: Sequence[float]) -> Record:
    """An extjoint with an offset of each axis that is used."""
    parts = record(value, "extjoint").parts
    axes = zip(parts, axes_of(value), offsets, strict=True)
    found = {name: _UNUSED if axis is None else axis + more for name, axis, more in axes}
    return Record("extjoint", dict(found))


def robtarget(at: Pose, configuration: Record | None, external: Record | None) -> Record:
    return Record(
        "robtarget",
        {
            "trans": pos(at.position),
            "rot": orient(at.quaternion),
            "robconf": copied(configuration or confdata()),
            "extax": copied(external or extjoint()),
        },
    )


def jointtarget(joints: tuple[float, ...], external: Record | None) -> Record:
    robax = {f"rax_{i}": joint for i, joint in enumerate(joints, 1)}
    return Record(
        "jointtarget",
        {"robax": Record("robjoint", dict(robax)), "extax": copied(external or extjoint())},
    )


def moved_target(target: Record, to: Pose) -> Record:
    """The same robtarget elsewhere."""
    fresh = copied(target)
    assert isinstance(fresh, Record)
    fresh.parts["trans"], fresh.parts["rot"] = pos(to.position), orient(to.quaternion)
    return fresh


SPEEDS: Final = (
    *(5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800),
    *(1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000),
)
_ZONES: Final = {
    "z0": (0.3, 0.3, 0.3, 0.03, 0.3, 0.03),
    "z1": (1, 1, 1, 0.1, 1, 0.1),
    "z5": (5, 8, 8, 0.8, 8, 0.8),
    "z10": (10, 15, 15, 1.5, 15, 1.5),
    "z15": (15, 23, 23, 2.3, 23, 2.3),
    "z20": (20, 30, 30, 3, 30, 3),
    "z30": (30, 45, 45, 4.5, 45, 4.5),
    "z40": (40, 60, 60, 6, 60, 6),
    "z50": (50, 75, 75, 7.5, 75, 7.5),
    "z60": (60, 90, 90, 9, 90, 9),
    "z80": (80, 120, 120, 12, 120, 12),
    "z100": (100, 150, 150, 15, 150, 15),
    "z150": (150, 225, 225, 23, 225, 23),
    "z200": (200, 300, 300, 30, 300, 30),
    "fine": (0, 0, 0, 0, 0, 0),
}
_ZONE_PARTS: Final = (
    *("pzone_tcp", "pzone_ori", "pzone_eax"),
    *("zone_ori", "zone_leax", "zone_reax"),
)
NUMBER_DATA: Final = {
    "pi": 3.141592654,
    "low": 0.0,
    "high": 1.0,
    "edge": 2.0,
    "wait_max": 99999.0,
    "eof_bin": -1.0,
    "eof_num": 9.998e36,
}
_ARRAY_SIZES: Final = {"sint": 1, "int": 2, "dint": 4, "lint": 8}
"""Bytes of whole numbers in rawbytes: the constant is negative, that with a `u` in front is not."""
_COUNTED: Final = (
    (
        1,
        "AIO_ABOVE_HIGH AIO_BELOW_HIGH AIO_ABOVE_LOW AIO_BELOW_LOW AIO_BETWEEN AIO_OUTSIDE "
        "AIO_ALWAYS",
    ),
    (1, "SOCKET_CREATED SOCKET_CONNECTED SOCKET_BOUND SOCKET_LISTENING SOCKET_CLOSED"),
    (0, "iconNone iconInfo iconWarning iconError"),
    (-1, "btnNone btnOK btnAbrtRtryIgn btnOKCancel btnRetryCancel btnYesNo btnYesNoCancel"),
    (0, "resUnkwn resOK resAbort resRetry resIgnore resCancel resYes resNo"),
    (1, "LT LTEQ EQ NOTEQ GTEQ GT"),
    (1, "OpAdd OpSub OpMult OpDiv OpMod"),
    (0, "OP_UNDEF OP_AUTO OP_MAN_PROG OP_MAN_TEST"),
    (0, "TYPE_ALL TYPE_STATE TYPE_WARN TYPE_ERR"),
    (0, "BUSSTATE_HALTED BUSSTATE_RUN BUSSTATE_ERROR BUSSTATE_STARTUP BUSSTATE_INIT"),
    (1, "IOUNIT_RUNNING IOUNIT_RUNERROR IOUNIT_DISABLE IOUNIT_OTHERERR"),
    (10, "IOUNIT_LOG_STATE_DISABLED IOUNIT_LOG_STATE_ENABLED"),
    (
        20,
        "IOUNIT_PHYS_STATE_DEACTIVATED IOUNIT_PHYS_STATE_RUNNING IOUNIT_PHYS_STATE_ERROR "
        "IOUNIT_PHYS_STATE_UNCONNECTED IOUNIT_PHYS_STATE_UNCONFIGURED IOUNIT_PHYS_STATE_STARTUP "
        "IOUNIT_PHYS_STATE_INIT",
    ),
    (0, "RUN_UNDEF RUN_CONT_CYCLE RUN_INSTR_FWD RUN_INSTR_BWD RUN_SIM RUN_STEP_MOVE"),
)
"""Names whose numbers follow each other, with the first (manual, data types aiotrigg, socketstatus,
icondata, buttondata, btnres, errtype, busstate and iounit_state; of opnum, opcalc and the modes the
names alone are stated).
"""
_CAPITALS: Final = "".join(map(chr, (*range(65, 91), *range(0xC0, 0xD7), *range(0xD8, 0xDF))))
TEXT_DATA: Final = {
    "stempty": "",
    "errstr_task": "TASK",
    "errstr_context": "CONTEXT",
    "errstr_unused": "",
    "errstr_empty": "",
    "diskhome": "HOME:",
    "disktemp": "TEMP:",
    "diskram": "RAMDISK:",
    "eof": "EOF",
    "str_digit": "0123456789",
    "str_upper": _CAPITALS,
    "str_lower": _CAPITALS.lower(),
}
"""The letters are those of Latin-1 that have both cases."""


def predefined(robot: Robot | None) -> Mapping[str, Cell]:
    """Fresh cells by name in lower case. robot: whose fastest tool is that of `vmax`."""
    # Without an arm no speed is known that `vmax` could stand for.
    fastest = math.inf if robot is None or robot.tcp_speed is None else float(robot.tcp_speed)
    cells = {f"v{v}": _constant_cell(_speed_record(float(v))) for v in SPEEDS}
    cells["vmax"] = _constant_cell(_speed_record(fastest))
    cells |= {name: _constant_cell(_zone_record(name, sizes)) for name, sizes in _ZONES.items()}
    cells |= {name: _constant_cell(value) for name, value in NUMBER_DATA.items()}
    cells |= {name: _constant_cell(-float(size)) for name, size in _ARRAY_SIZES.items()}
    cells |= {f"u{name}": _constant_cell(float(size)) for name, size in _ARRAY_SIZES.items()}
    cells |= {
        name.lower(): _constant_cell(float(number))
        for first, names in _COUNTED
        for number, name in enumerate(names.split(), first)
    }
    cells |= {name: _constant_cell(text) for name, text in TEXT_DATA.items()}
    cells |= _ERROR_DATA
    cells["errno"] = _constant_cell(0.0)
    cells["intno"] = _constant_cell(0.0)
    cells |= {f"reg{i}": _constant_cell(0.0, "VAR") for i in range(1, 6)}
    cells["clock1"] = Cell(Shape("clock"), "VAR", Clock())
    cells["load0"] = _constant_cell(_load_record(), "PERS")
    cells["tool0"] = _constant_cell(tool0(), "PERS")
    cells["wobj0"] = _constant_cell(wobj0(), "PERS")
    return cells


def _load_record() -> Record:
    return Record(
        "loaddata",
        {
            "mass": 0.001,
            "cog": pos((0.0, 0.0, 0.001)),
            "aom": orient((1.0, 0.0, 0.0, 0.0)),
            **dict.fromkeys(("ix", "iy", "iz"), 0.0),
        },
    )


def tool0() -> Record:
    return Record("tooldata", {"robhold": True, "tframe": pose(IDENTITY), "tload": _load_record()})


def wobj0() -> Record:
    return Record(
        "wobjdata",
        {
            "robhold": False,
            "ufprog": True,
            "ufmec": "",
            "uframe": pose(IDENTITY),
            "oframe": pose(IDENTITY),
        },
    )


def _speed_record(tcp: float) -> Record:
    rest = {"v_ori": 500.0, "v_leax": 5000.0, "v_reax": 1000.0}
    return Record("speeddata", {"v_tcp": tcp, **rest})


def _zone_record(name: str, sizes: tuple[float, ...]) -> Record:
    parts = zip(_ZONE_PARTS, map(float, sizes), strict=True)
    return Record("zonedata", {"finep": name == "fine", **dict(parts)})


def _constant_cell(value: Value, storage: Storage = "CONST") -> Cell:
    match value:
        case str():
            return Cell(Shape("string"), storage, value)
        case Record(type):
            return Cell(Shape(type), storage, value)
    # Predefined numbers are nums: `pi` has single precision.
    return Cell(Shape("num"), storage, fitted(value, NUMBER))


_ERROR_DATA: Final[Mapping[str, Cell]] = {
    name: _constant_cell(float(n)) for name, n in ERROR_NUMBERS.items()
}
