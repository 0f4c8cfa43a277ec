"""Approaches: free lines of a tool to a position and from it, and times between positions.

On such a line the tool keeps its orientation. The first one that is tried leads along the tool;
then it is tilted, by little first and to all sides. Each is proven without gaps, in the branch of
the arm that is nearest to home, and only then in others. The complete program decides which of them
it takes, and is proven as the controller moves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import error, info
from assistant.cell.collision.continuous import RESOLUTION, JointPath, hits
from assistant.cell.planning.space import Space, goal_joints
from assistant.cell.scene import PlacedRobot, Scene
from assistant.program.geometry import Pose, Vector
from assistant.sources.process import ALONG_TOOL, WayIn

_APPROACH_TILTED: Final = info(
    "CK478",
    "the tool comes and goes {angle:.0f} degrees off its axis: along it `{one}` would come too near"
    " to `{other}`",
    "",
)
_STRAIGHT_OUT_OF_REACH: Final = info(
    "CK477",
    "the tool comes and goes {angle:.0f} degrees off its axis: along it the arm cannot go so far",
    "",
)
_NO_APPROACH: Final = error(
    "CK479",
    "no line of {distance:g} mm that leads here is free, neither along the tool nor tilted from it:"
    " along it `{one}` touches `{other}`",
    "state a shorter approach or retract, or move the place or the body",
)

_TILTS: Final = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
"""Degrees from the tool's axis, after 0."""
_TILT_SIDES: Final = 8
"""Sides to which it is tilted, of each angle."""
_DIRECTION_DECIMALS: Final = 3
"""Decimals of a direction that is written to the program."""


def _approach_directions() -> Iterator[tuple[float, tuple[Vector, ...]]]:
    """Those that are tried, in the tool's own axes, by their angles from its axis."""
    yield 0.0, (ALONG_TOOL,)
    around = 2.0 * np.pi * np.arange(_TILT_SIDES) / _TILT_SIDES
    for tilt in _TILTS:
        t = np.radians(tilt)
        ring = [
            np.sin(t) * np.cos(around),
            np.sin(t) * np.sin(around),
            np.full(_TILT_SIDES, -np.cos(t)),
        ]
        rows = np.round(np.stack(ring, axis=1), _DIRECTION_DECIMALS) + 0.0
        yield tilt, tuple((x, y, z) for x, y, z in rows.tolist())


class CellSurroundings:
    """`sources.surroundings.Surroundings` of a robot in a scene. Other robots stand at home."""

    def __init__(self, scene: Scene, placed: PlacedRobot) -> None:
        self.scene, self.placed, self.robot = scene, placed, placed.robot

    @cached_property
    def space(self) -> Space:
        return Space(self.scene, self.placed)

    def places(self, positions: Floats, quaternions: Floats, tool: Pose) -> Floats | None:
        """In the branch that holds most of them; of several the one that is nearest to home."""
        back = tool.inverse()
        joints, valid = self.robot.ik(
            positions + rotations.rotate(quaternions, np.array(back.position)),
            rotations.multiply(quaternions, np.array(back.quaternion)),
        )
        if not valid.any(axis=1).all():
            return None
        scaled = joints / self.robot.speeds
        far = np.abs(scaled - self.robot.home / self.robot.speeds).max(axis=2)
        nearness = np.where(valid, far, np.inf)
        best = np.lexsort((np.where(valid, far, 0.0).sum(axis=0), -valid.sum(axis=0)))[0]
        chosen = np.where(valid[:, best], best, nearness.argmin(axis=1))
        return np.asarray(scaled[np.arange(len(joints)), chosen])

    def way_in(self, pose: Pose, tool: Pose, distance: float, place: str) -> WayIn:
        """Return the first direction that keeps the margins, or else the first without contact.

        A body that is within its margin at the target itself, such as the work, may be as near on
        the approach. A target that is out of reach, or in contact itself, is reported by the check
        of the program.
        """
        along = _Line(pose, np.array(ALONG_TOOL), distance, tool)
        rows = list[Floats]()
        for row in self._held(pose, tool):
            rows.append(row)
            for most in (np.inf, 0.0):
                found = self._free(row, along, most)
                if found is not None:
                    return self._said(row, along, found, place)
        names = None if not rows else self._in_the_way(rows[0], along)
        if names is None:
            return WayIn()
        one, other = names
        said = _NO_APPROACH(place=place, distance=distance, one=one, other=other)
        return WayIn(findings=(said,))

    def _said(self, row: Floats, along: _Line, found: tuple[float, Vector], place: str) -> WayIn:
        angle, direction = found
        if not angle:
            return WayIn()
        names = self._in_the_way(row, along)
        if names is None:
            return WayIn(direction, (_STRAIGHT_OUT_OF_REACH(place=place, angle=angle),))
        one, other = names
        return WayIn(direction, (_APPROACH_TILTED(place=place, angle=angle, one=one, other=other),))

    def _free(self, row: Floats, along: _Line, most: float) -> tuple[float, Vector] | None:
        """The first free direction from joints (a,), with its angle. most: mm of the margins."""
        margins = self._margins(row, most)
        for angle, ring in _approach_directions():
            lines = [replace(along, direction=np.array(one)) for one in ring]
            free = self._clear(self._tracked(row, lines), margins)
            if free.any():
                return angle, ring[int(np.argmax(free))]
        return None

    def _held(self, pose: Pose, tool: Pose) -> Iterator[Floats]:
        """Joints (a,) that hold a pose and touch nothing there, of whole turns the first."""
        seen = set[tuple[float, ...]]()
        for row in goal_joints(self.robot, pose, self.robot.home, tool):
            turned = np.where(self.robot.sliding, row, row % 360.0)
            key = tuple((np.round(turned, 3) % 360.0).tolist())
            if key not in seen and self.space.distances(row).min(initial=np.inf) > 0.0:
                yield row
            seen.add(key)

    def _tracked(self, row: Floats, lines: Sequence[_Line]) -> list[Floats | None]:
        """Joints (s, a) along lines from joints (a,) on, in one branch; None if the arm cannot."""
        poses = [pose for line in lines for pose in line.flanges()]
        joints, valid = self.robot.ik([p.position for p in poses], [p.quaternion for p in poses])
        joints = joints.reshape(len(lines), -1, *joints.shape[1:])
        valid = valid.reshape(len(lines), -1, valid.shape[1])
        out: list[Floats | None] = []
        for one, usable in zip(joints, valid, strict=True):
            track = [row]
            for some, good in zip(one, usable, strict=True):
                wound = some + self._turns(some, track[-1])
                far = np.where(
                    good & self.robot.inside(wound), np.abs(wound - track[-1]).max(1), np.inf
                )
                best = int(np.argmin(far))
                if not far[best] <= _MOST_TURNED:
                    break
                track.append(wound[best])
            out.append(np.array(track) if len(track) == len(one) + 1 else None)
        return out

    def _turns(self, rows: Floats, near: Floats) -> Floats:
        """Whole turns that bring joints (n, a) nearest to others (a,)."""
        turns = 360.0 * np.round((near - rows) / 360.0)
        turning = np.isin(np.arange(len(near)), self.robot.winding())
        return np.where(turning, turns, 0.0)

    def _margins(self, row: Floats, most: float) -> Floats:
        """(p,) mm that are kept on ways to joints (a,): less of what is nearer there."""
        wanted = np.minimum(self.space.margins, most)
        return np.asarray(np.minimum(wanted, self.space.distances(row) - _MARGIN_LESS))

    def _clear(self, tracks: Sequence[Floats | None], margins: Floats) -> Truths:
        """(n,) whether margins (p,) are kept on ways through joints (s, a)."""
        out = np.array([track is not None for track in tracks])
        going = [track for track in tracks if track is not None]
        if not going:
            return out
        usual, self.space.margins = self.space.margins, margins
        try:
            starts, ends = (
                np.concatenate([track[some] for track in going])
                for some in (slice(None, -1), slice(1, None))
            )
            clear = self.space.clear(starts, ends, _PATH_ROOM)
        finally:
            self.space.margins = usual
        out[out] = [
            part.all() for part in np.split(clear, np.cumsum([len(t) - 1 for t in going])[:-1])
        ]
        return out

    def _in_the_way(self, row: Floats, along: _Line) -> tuple[str, str] | None:
        """Bodies that come too near on a line from joints (a,); None if the arm cannot go it."""
        (way,) = self._tracked(row, [along])
        if way is None:
            return None
        margins = self._margins(row, np.inf) + _PATH_ROOM + RESOLUTION
        found = hits(self.space.model, JointPath(self.space.all_joints(way)), margins)
        if not found:
            return None
        worst = min(found, key=lambda hit: hit.distance)
        contact = self.space.model.contact(worst.joints, worst.pair)
        return contact.one, contact.other


@dataclass(frozen=True, slots=True, eq=False)
class _Line:
    """From a pose of the tip to mm away from it, in a direction (3,) in its axes."""

    pose: Pose
    direction: Floats
    distance: float
    tool: Pose

    def flanges(self) -> list[Pose]:
        """Every `_APPROACH_STEP` mm, without the first."""
        count = max(1, int(np.ceil(self.distance / _APPROACH_STEP)))
        places = np.arange(1, count + 1)[:, None] / count * self.distance * self.direction
        back = self.tool.inverse()
        return [self.pose @ Pose((x, y, z)) @ back for x, y, z in places.tolist()]


_MARGIN_LESS: Final = 0.5
"""mm by which a margin is less than the distance at the place that a way leads to."""
_PATH_ROOM: Final = 0.1
"""mm that the way between two looked at places may be from what the joints go in between."""
_APPROACH_STEP: Final = 4.0
"""Distance in mm between poses that are examined; the stretch in between is proven clear. A line of
that length is 0.02 mm from the arc of a joint 100 mm away.
"""
_MOST_TURNED: Final = 45.0
"""degrees or mm that a joint moves in a step at most, in one branch."""
