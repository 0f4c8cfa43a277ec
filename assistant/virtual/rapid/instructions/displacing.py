"""Displacements of all targets, and offsets of additional axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.rapid.ends import NotSimulated
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import axes_of, extjoint, extjoint_of, pose_of
from assistant.virtual.rapid.predefined import wobj0


def _displace_on(given: Given) -> None:
    r"""PDispOn: from a programmed position to the one of \ExeP, or to where the arm stands.

    Both are told in the work object. Without \Rot the axes keep their directions.
    """
    arm = given.machine.arm
    programmed = pose_of(given.record(0, "robtarget"))
    executed = given.optional_record("exep", "robtarget")
    if executed is not None:
        there = pose_of(executed)
    else:
        tool = given.record(1, "tooldata")
        frame = given.optional_record("wobj", "wobjdata") or wobj0()
        arm.displacement = IDENTITY
        there = arm.reading(tool, frame)
    if given.has("rot"):
        arm.displacement = there @ programmed.inverse()
    else:
        x, y, z = (a - b for a, b in zip(there.position, programmed.position, strict=True))
        arm.displacement = Pose((x, y, z))


def _displace_set(given: Given) -> None:
    given.machine.arm.displacement = pose_of(given.record(0, "pose"))


def _displace_add(given: Given) -> None:
    """PDispAdd: a displacement of the displaced frame."""
    arm = given.machine.arm
    arm.displacement = arm.displacement @ pose_of(given.record(0, "pose"))


def _displace_off(given: Given) -> None:
    given.machine.arm.displacement = IDENTITY


def _offsets_on(given: Given) -> None:
    arm = given.machine.arm
    programmed = axes_of(given.record(0, "robtarget").parts["extax"])
    executed = given.optional_record("exep", "robtarget")
    if executed is not None:
        there = axes_of(executed.parts["extax"])
    else:
        if arm.external is None:
            raise NotSimulated("additional axes that are read before the first motion")
        there = axes_of(extjoint_of(arm.external, arm.offsets))
    arm.offsets = tuple(
        0.0 if a is None or b is None else a - b for a, b in zip(there, programmed, strict=True)
    )


def _offsets_set(given: Given) -> None:
    axes = axes_of(given.record(0, "extjoint"))
    given.machine.arm.offsets = tuple(axis or 0.0 for axis in axes)


def _offsets_off(given: Given) -> None:
    given.machine.arm.offsets = tuple(0.0 for _ in extjoint().parts)


DISPLACEMENT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("PDispOn", 2, _displace_on, "rot exep wobj"),
        table_row("PDispSet", 1, _displace_set),
        table_row("PDispAdd", 1, _displace_add),
        table_row("PDispOff", 0, _displace_off),
        table_row("EOffsOn", 1, _offsets_on, "exep"),
        table_row("EOffsSet", 1, _offsets_set),
        table_row("EOffsOff", 0, _offsets_off),
    )
)
