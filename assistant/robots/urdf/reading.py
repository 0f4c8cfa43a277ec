"""A URDF as an arm, and what of a robot file it says."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Refused, info
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.arms.arm import Arm
from assistant.robots.arms.chain import Joint as Axis
from assistant.robots.arms.recognition import recognise_six_axis
from assistant.robots.arms.serial import Serial
from assistant.robots.outlines import Outlines
from assistant.robots.programming import programming_languages
from assistant.robots.urdf import tree
from assistant.robots.urdf.drawn_links import METRE, link_outlines
from assistant.robots.urdf.elements import XmlElement, parse_xml

ASSUMED: Final = info(
    "RB008",
    "a URDF does not say everything of a robot: {what}",
    "write a TOML file with the key `urdf` and what you know better",
)
NOT_IN_NAMES: Final = re.compile(r"[^A-Za-z0-9_.-]+")
"""What the name of a robot cannot hold, see `robot_file`."""
MOST_AXES: Final = 32
"""Of a chain; more than any arm has."""
ENDLESS_TURN: Final = 360.0
"""degrees to either side for an axis that turns without end."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """arm: in closed form where there is one. table: what a robot file would say of the rest.

    missing: of an axis and field of the table that the file leaves out, what to tell.
    findings: what is taken although the file does not say it. outlines: of the links.
    """

    arm: Arm
    table: dict[str, Any]
    missing: dict[tuple[str, str], Diagnostic]
    findings: tuple[Diagnostic, ...]
    outlines: Outlines | None = None


def read(data: bytes, path: str | None) -> Drawn:
    """Raises Unreadable, or Refused with a finding for everything that is wrong."""
    root = parse_xml(data, path)
    reader = tree.UrdfReader(path)
    carried = reader.tree(root)
    if reader.findings:
        raise Refused(*reader.findings)
    if not any(joint.moving for joint in carried.values()):
        raise Refused(root.wrong(path, "has no joint that moves"))
    tip, reason = tree.flange_link(carried)
    joints = tree.joint_chain(tip, carried)
    _refuse_unfit(joints, path)
    moving = [joint for joint in joints if joint.moving]
    if len(moving) > MOST_AXES:
        reason = f"has {len(moving)} axes up to link `{tip}`, more than {MOST_AXES}"
        raise Refused(root.wrong(path, reason))
    chain = _serial_arm(joints)
    arm = recognise_six_axis(chain) or chain
    table, missing = _robot_table(root, moving, arm, path)
    table["source"] = f"URDF, the chain from {joints[0].parent} to {tip}"
    notes = [f"the flange is link `{tip}`, {reason}"]
    if any(joint.rounded for joint in joints):
        notes.append("angles printed like 1.5708 are taken for quarter turns")
    if isinstance(arm, Serial):
        notes.append("its arm has no closed form here and is solved numerically")
    endless = [j.name for j in moving if j.kind == "continuous"]
    if endless:
        notes.append(
            f"{', '.join(endless)} turn without end and get {ENDLESS_TURN:g} degrees either way"
        )
    what = "maker, languages, payload and home are assumed; " + "; ".join(notes)
    drawn = link_outlines(root, carried, joints, arm, path)
    return Drawn(arm, table, missing, (ASSUMED(path=path, what=what),), drawn)


def _refuse_unfit(joints: tuple[tree.UrdfJoint, ...], path: str | None) -> None:
    wrong = []
    for joint in joints:
        if joint.kind in ("floating", "planar"):
            wrong.append(joint.element.wrong(path, f"is {joint.kind}, which no axis of an arm is"))
        elif joint.moving and joint.follows:
            wrong.append(joint.element.wrong(path, "follows another joint, which is not supported"))
    if wrong:
        raise Refused(*wrong)


def _serial_arm(joints: tuple[tree.UrdfJoint, ...]) -> Serial:
    """The chain, fixed joints made part of the moving ones behind them."""
    axes, pose = [], IDENTITY
    for joint in joints:
        roll, pitch, yaw = (math.degrees(angle) for angle in joint.rpy)
        turn = rotations.from_euler([yaw, pitch, roll])
        pose = pose @ Pose.of(np.array(joint.xyz) * METRE, turn)
        if joint.moving:
            sliding = joint.kind == "prismatic"
            unit = METRE if sliding else 1.0
            low, high = joint.limits or (-math.pi, math.pi)
            axes.append(Axis(pose, joint.axis, sliding, low * unit, high * unit))
            pose = IDENTITY
    return Serial(tuple(axes), pose)


def _robot_table(
    root: XmlElement, joints: list[tree.UrdfJoint], arm: Arm, path: str | None
) -> tuple[dict[str, Any], dict[tuple[str, str], Diagnostic]]:
    title = " ".join(root.attributes.get("name", "").split())
    name = NOT_IN_NAMES.sub("-", title).strip("-_.")[:64] or "robot"
    table: dict[str, Any] = {
        "name": name,
        "title": title or name,
        "maker": "unknown",
        "controller": "unknown",
        "languages": list(programming_languages()),
        "configuration": "quadrants",
        "reach_mm": max(arm.reach, 1.0),
        "unconfirmed": ["maker", "controller", "languages", "configuration", "home"],
        "axes_deg": {},
        "axes_mm": {},
    }
    missing: dict[tuple[str, str], Diagnostic] = {}
    for axis, joint in zip(arm.axes, joints, strict=True):
        sliding = joint.kind == "prismatic"
        entry: dict[str, Any] = {}
        limits = (
            (-math.radians(ENDLESS_TURN), math.radians(ENDLESS_TURN))
            if joint.kind == "continuous"
            else None
        )
        limits = joint.limits or limits
        if limits is None:
            missing[axis, "limits"] = joint.element.wrong(path, "has no <limit> lower and upper")
        else:
            entry["limits"] = [_in_file_units(value, sliding) for value in limits]
            entry["home"] = min(max(0.0, entry["limits"][0]), entry["limits"][1])
        if joint.velocity is None:
            reason = "has no <limit> velocity above 0, so that nobody knows how fast it is"
            missing[axis, "speed"] = joint.element.wrong(path, reason)
        else:
            entry["speed"] = _in_file_units(joint.velocity, sliding)
        table["axes_mm" if sliding else "axes_deg"][axis] = entry
    return table, missing


def _in_file_units(value: float, sliding: bool) -> float:
    """Radians or m as degrees or mm."""
    return value * METRE if sliding else math.degrees(value)
