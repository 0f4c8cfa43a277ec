"""Where the arm is, and the tool and work object of its latest motion."""

from __future__ import annotations

from dataclasses import dataclass

from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.rapid.ends import Fault, NotSimulated
from assistant.virtual.rapid.poses import pose_of, truth
from assistant.virtual.rapid.values import Record


@dataclass(slots=True)
class Arm:
    """flange: its pose in the robot's base; joints: degrees; each None while it is not known.

    tool, frame: records of the latest motion, None before the first. configuration, external:
    as the latest target says them. displacement: of all targets, by PDispSet. offsets: of the
    additional axes, by EOffsSet. override, most: percent and mm/s, by VelSet. acceleration:
    percent, by AccSet. watches_joints, watches_lines: whether motions keep to the configurations
    of their targets, by ConfJ and ConfL.
    """

    flange: Pose | None = None
    joints: tuple[float, ...] | None = None
    tool: Record | None = None
    frame: Record | None = None
    configuration: Record | None = None
    external: Record | None = None
    displacement: Pose = IDENTITY
    offsets: tuple[float, ...] = (0.0,) * 6
    override: float = 100.0
    most: float = float("inf")
    acceleration: float = 100.0
    watches_joints: bool = True
    watches_lines: bool = True

    def flange_at(self, target: Pose, tool: Record, frame: Record) -> Pose:
        """The flange where a tool reaches a target of a work object."""
        tip, held = _tool_frame(tool)
        place = _object_frame(frame, held) @ self.displacement
        if held:
            return place @ target @ tip.inverse()
        return tip @ (place @ target).inverse()

    def reading(self, tool: Record, frame: Record, flange: Pose | None = None) -> Pose:
        """The tool in a work object. flange: in the base, None for where the arm stands."""
        flange = flange or self.flange
        if flange is None:
            raise NotSimulated("a position that is read while it is not known where the arm is")
        tip, held = _tool_frame(tool)
        place = _object_frame(frame, held) @ self.displacement
        if held:
            return place.inverse() @ flange @ tip
        return (flange @ place).inverse() @ tip


def work_object(frame: Record, tool: Record) -> Pose:
    """In the base where it stands there, else on the flange."""
    return _object_frame(frame, _tool_frame(tool)[1])


def is_carried(tool: Record) -> Pose:
    """The tool on the flange; none where the robot carries the work piece to it."""
    tip, held = _tool_frame(tool)
    return tip if held else IDENTITY


def _tool_frame(tool: Record) -> tuple[Pose, bool]:
    return pose_of(tool.parts["tframe"]), truth(tool.parts["robhold"])


def _object_frame(frame: Record, held: bool) -> Pose:
    """User and object frame in one: in the base, or on the flange beside a tool in the room."""
    if truth(frame.parts["robhold"]) is held:
        raise Fault("either the tool or the work object is held by the robot, not both or neither")
    if not truth(frame.parts["ufprog"]) or frame.parts["ufmec"] != "":
        raise NotSimulated("a work object that a mechanical unit moves")
    return pose_of(frame.parts["uframe"]) @ pose_of(frame.parts["oframe"])
