"""The shapes of the links of a URDF: <collision>, or <visual> where no link has the other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.program.geometry import IDENTITY, Pose, Vector
from assistant.robots.arms.arm import Arm
from assistant.robots.outlines import Kind, Outline, Outlines
from assistant.robots.urdf import tree
from assistant.robots.urdf.elements import XmlElement

METRE: Final = 1000.0
"""mm."""
SHAPE_SIZES: Final[Mapping[Kind, tuple[str, ...]]] = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
}
"""Shape → its attributes in metres; `size` holds three. Those of the XML specification of URDF."""
SHAPE_KINDS: Final = (*SHAPE_SIZES, "mesh")


def link_outlines(
    root: XmlElement,
    carried: Mapping[str, tree.UrdfJoint],
    joints: Sequence[tree.UrdfJoint],
    arm: Arm,
    path: str | None,
) -> Outlines | None:
    """Of the links of a tree, of which joints lead to the flange of an arm; None if none has any.

    carried: link → the joint that carries it.
    """
    links = {element.attributes.get("name", ""): element for element in root.all("link")}
    used: Literal["collision", "visual"] = "collision"
    if not any(_drawn_elements(element, used) for element in links.values()):
        used = "visual"
    if not any(_drawn_elements(element, used) for element in links.values()):
        return None
    reader = tree.UrdfReader(path)
    places = _placed(carried, joints)
    frames = dict(zip(_carriers(arm), _frames(arm), strict=True))
    shapes: list[Outline] = []
    for name, element in links.items():
        carrier, pose = places[name]
        there = frames[carrier].inverse() @ pose
        for part in _drawn_elements(element, used):
            shapes += _outline(reader, element, part, name, carrier, there)
    chain = {joint.name for joint in joints}
    hanging = {link for link, element in links.items() if _drawn_elements(element, used)}
    still = {
        j.name for link in hanging for j in tree.joint_chain(link, carried) if j.moving
    } - chain
    folder = str(FilePath(path or "robot.urdf").parent)
    return Outlines(tuple(shapes), folder, tuple(reader.findings), tuple(sorted(still)))


def _drawn_elements(link: XmlElement, used: str) -> list[XmlElement]:
    """The elements of a link that hold a geometry."""
    return [part for part in link.all(used) if part.first("geometry") is not None]


def _carriers(arm: Arm) -> tuple[str, ...]:
    return ("base", *arm.axes, "flange")


def _frames(arm: Arm) -> list[Pose]:
    """Of what carries bodies, with all joints at 0."""
    found = arm.whole_chain.along(np.zeros((1, len(arm.axes))))
    turns = rotations.from_matrix(found.frames[0])
    return [IDENTITY, *(Pose.of(p, q) for p, q in zip(found.origins[0], turns, strict=True))]


def _placed(
    carried: Mapping[str, tree.UrdfJoint], joints: Sequence[tree.UrdfJoint]
) -> dict[str, tuple[str, Pose]]:
    """Link → what carries it, and its pose in the base with all joints at 0."""
    root, tip = joints[0].parent, joints[-1].child
    axes = [joint.name for joint in joints if joint.moving]
    found: dict[str, tuple[str, Pose]] = {root: ("base", IDENTITY)}
    for link, joint in tree.links_outwards(carried):
        carrier, pose = found[joint.parent]
        if joint.name in axes:
            carrier = f"J{axes.index(joint.name) + 1}"
        if joint.parent == tip or (link == tip and not joint.moving):
            carrier = "flange"
        place = pose @ _origin_pose(joint.xyz, joint.rpy)
        if joint.moving and joint.name not in axes:
            place = place @ _rest_value(joint)
        found[link] = carrier, place
    return found


def _rest_value(joint: tree.UrdfJoint) -> Pose:
    """What a joint that is no axis of the arm turns or slides by: 0, or the limit nearest to it."""
    low, high = joint.limits or (0.0, 0.0)
    value = min(max(0.0, low), high)
    x, y, z = joint.axis
    if joint.kind == "prismatic":
        return Pose((x * value * METRE, y * value * METRE, z * value * METRE))
    sine = math.sin(value / 2.0)
    return Pose(quaternion=(math.cos(value / 2.0), x * sine, y * sine, z * sine))


def _origin_pose(xyz: Vector, rpy: Vector) -> Pose:
    """Of metres and of radians about fixed axes."""
    roll, pitch, yaw = (math.degrees(angle) for angle in rpy)
    return Pose.of(np.array(xyz) * METRE, rotations.from_euler([yaw, pitch, roll]))


def _outline(
    reader: tree.UrdfReader,
    link: XmlElement,
    part: XmlElement,
    name: str,
    carrier: str,
    there: Pose,
) -> Iterator[Outline]:
    """The shape of a <collision> or <visual>; what is wrong with it goes to the reader."""
    geometry = part.first("geometry")
    shapes = (
        [] if geometry is None else [one for one in geometry.children if one.tag in SHAPE_KINDS]
    )
    if len(shapes) != 1:
        reader.wrong(
            link, f"has a <{part.tag}> whose <geometry> is not one of {', '.join(SHAPE_KINDS)}"
        )
        return
    (shape,) = shapes
    before = len(reader.findings)
    xyz, rpy, _ = reader.origin(part)
    pose = there @ _origin_pose(xyz, rpy)
    if shape.tag == "mesh":
        file = shape.attributes.get("filename", "").strip()
        scale = reader.vector(link, shape, "scale", (1.0, 1.0, 1.0))
        if not file:
            reader.wrong(link, "has a <mesh> without a filename")
        elif not all(scale):
            reader.wrong(
                link, f"has a <mesh> of scale `{shape.attributes['scale']}`, which is flat"
            )
        if len(reader.findings) == before:
            yield Outline(name, carrier, pose, "mesh", file=file, scale=scale)
        return
    kind = next(kind for kind in SHAPE_SIZES if kind == shape.tag)
    sizes: list[float] = []
    for key in SHAPE_SIZES[kind]:
        if key == "size":
            sizes += reader.vector(link, shape, key, (0.0, 0.0, 0.0))
        else:
            sizes.append(reader.number(link, shape, key, 0.0) or 0.0)
    if len(reader.findings) == before and min(sizes) <= 0.0:
        said = ", ".join(f"{key} `{shape.attributes.get(key, '')}`" for key in SHAPE_SIZES[kind])
        reader.wrong(link, f"has a <{kind}> of {said}: sizes are above 0")
    if len(reader.findings) == before:
        yield Outline(name, carrier, pose, kind, tuple(size * METRE for size in sizes))
