"""Poses, tools, frames and targets as RAPID can say them, with a finding for each change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.words import LEAST_CENTRE, LEAST_MASS, UNUSED
from assistant.languages.rapid.tree.runs import (
    JOINT_PLACES,
    POSITION_PLACES,
    QUATERNION_PLACES,
    SIZES_PLACES,
)
from assistant.program import rotations
from assistant.program.geometry import (
    Configuration,
    Frame,
    JointTarget,
    Load,
    Pose,
    Target,
    Tool,
)
from assistant.program.passes.legalising import Legalising
from assistant.program.subjects import Declared, Subject


def sayable_tool(tool: Tool, name: str, job: Legalising) -> Tool:
    """With a load that the controller takes."""
    load, about = tool.load, Declared(name, "tools")
    if load is None:
        job.findings.append(rules.NO_LOAD(name=name, about=about))
        load = Load(LEAST_MASS, LEAST_CENTRE)
    if load.mass < LEAST_MASS:
        job.changed(
            f"the mass of tool `{name}`", f"{LEAST_MASS} kg", "state the tool's mass", about
        )
        load = replace(load, mass=LEAST_MASS)
    if not any(load.centre):
        job.changed(
            f"the centre of gravity of tool `{name}`, which is none",
            "0.001 mm before the flange",
            "state the tool's centre of gravity",
            about,
        )
        load = replace(load, centre=LEAST_CENTRE)
    return replace(tool, tip=sayable_pose(tool.tip, job), load=_printed(load))


def sayable_frame(frame: Frame, job: Legalising) -> Frame:
    user, object = (sayable_pose(x, job) for x in (frame.user, frame.object))
    return replace(frame, user=user, object=object)


def sayable_target(target: Target, about: Subject | str, job: Legalising) -> Target:
    """With a configuration."""
    configuration = target.configuration
    if configuration is None:
        job.findings.append(rules.NO_CONFIGURATION(about=about))
        configuration = Configuration()
    return Target(sayable_pose(target.pose, job), configuration, _axes(target.external))


def sayable_joints(target: JointTarget, about: Subject | str, job: Legalising) -> JointTarget:
    """With six joints."""
    joints = target.joints
    if len(joints) > 6:
        job.cannot(f"{len(joints)} joints", "use six; further axes are external", about)
    if len(joints) < 6 or any(j != j for j in joints):
        job.changed("a joint that is not stated", "0 degrees", "state every joint", about)
        joints = tuple(0.0 if j != j else j for j in joints) + (0.0,) * (6 - len(joints))
    joints = tuple(round(j, JOINT_PLACES) + 0.0 for j in joints)
    return JointTarget(joints, _axes(target.external))


def sayable_pose(pose: Pose, job: Legalising) -> Pose:
    """With a quaternion of one spelling."""
    quaternion = np.array(pose.quaternion)
    if not np.isfinite(quaternion).all() or np.linalg.norm(quaternion) < 0.5:
        job.findings.append(rules.NOT_FINITE(what="an orientation"))
        return pose
    return Pose.of(np.array(pose.position), rotations.canonical(quaternion))


def _axes(values: tuple[float, ...]) -> tuple[float, ...]:
    """External axes as they are printed, NaN for an unused one."""
    return tuple(float("nan") if v >= UNUSED else round(v, JOINT_PLACES) + 0.0 for v in values)


def _printed(load: Load) -> Load:
    """A load as it is printed."""
    x, y, z = (round(v, POSITION_PLACES) + 0.0 for v in load.centre)
    a, b, c, d = (round(v, QUATERNION_PLACES) + 0.0 for v in load.axes)
    i, j, k = (round(v, SIZES_PLACES) + 0.0 for v in load.inertia)
    return Load(round(load.mass, SIZES_PLACES), (x, y, z), (a, b, c, d), (i, j, k))
