"""Positions, orientations and targets between records of RAPID and poses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import Pose, Quaternion, Vector
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.values import Record, Value, copied, kind_of

MOST_OFF_UNIT: Final = 1e-3
"""How far the sum of squares of an orientation may be from 1, and still be one."""
UNUSED: Final = 9e9
"""An external axis that is not there."""
LEAST_UNUSED: Final = 8.9e9
"""The same, as rounded as it may be."""


def number(value: Value) -> float:
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
    """Of unit length; raises Fault for what is no orientation."""
    q = np.array([number(part) for part in record(value, "orient").parts.values()])
    if not abs(float(q @ q) - 1.0) <= MOST_OFF_UNIT:
        raise Fault("an orientation whose squares do not add up to 1", "ERR_ILLQUAT")
    w, x, y, z = (float(part) for part in rotations.canonical(q))
    return w, x, y, z


def pose_of(value: Value) -> Pose:
    """Of a pose or a robtarget."""
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
    return Record("extjoint", {f"eax_{letter}": UNUSED for letter in "abcdef"})


def axes_of(value: Value) -> list[float | None]:
    """The additional axes of an extjoint, None for those that are not used."""
    axes = [number(part) for part in record(value, "extjoint").parts.values()]
    return [None if axis >= LEAST_UNUSED else axis for axis in axes]


def extjoint_of(value: Value, offsets: Sequence[float]) -> Record:
    """An extjoint with an offset of each axis that is used."""
    parts = record(value, "extjoint").parts
    axes = zip(parts, axes_of(value), offsets, strict=True)
    found = {name: UNUSED if axis is None else axis + more for name, axis, more in axes}
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
