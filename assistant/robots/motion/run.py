"""A run: moves that follow each other without a branch of the program, in columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.diagnostics import Goal, Neighbours, Several, SomeTargets
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import Blend, Kind, Speed

MOST_NAMED_ROWS: Final = 3
"""How many rows, or ranges of rows, a finding names before it counts the rest."""
LEAST_NAMED_RANGE: Final = 4
"""Neighbouring rows from which on a finding names the first and the last alone."""


@dataclass(frozen=True, slots=True)
class Mounting:
    """Which tool moves in which frame, row by row.

    tool, frame: (n,) rows of the tables tools and frames.
    """

    tool: NDArray[np.int32]
    frame: NDArray[np.int32]
    tools: Sequence[Tool]
    frames: Sequence[Frame]

    def to_flange(
        self, positions: Floats, quaternions: Floats, rows: slice | Rows
    ) -> tuple[Floats, Floats]:
        """Targets (m, 3), (m, 4) with the tools and frames of m rows → poses of the flange."""
        if len(self.tools) == 1 and len(self.frames) == 1:
            return to_flange(positions, quaternions, self.tools[0], self.frames[0])
        tool, frame = self.tool[rows], self.frame[rows]
        p, q = np.empty_like(positions), np.empty_like(quaternions)
        for t, f in np.unique(np.stack([tool, frame], axis=1), axis=0):
            here = (tool == t) & (frame == f)
            p[here], q[here] = to_flange(
                positions[here], quaternions[here], self.tools[t], self.frames[f]
            )
        return p, q

    def from_flange(self, flange: Pose, row: int) -> Pose:
        """A pose of the flange → the target with the tool and frame of a row."""
        p, q = np.array([flange.position]), np.array([flange.quaternion])
        tool, frame = self.tools[self.tool[row]], self.frames[self.frame[row]]
        (position,), (quaternion,) = from_flange(p, q, tool, frame)
        return Pose.of(position, quaternion)

    def tip(self, row: int) -> Pose:
        """The tip on the flange at a row; none for a tool that stands in the room."""
        tool, frame = self.tools[self.tool[row]], self.frames[self.frame[row]]
        return tool.tip if tool.held and not frame.held else Pose()

    def arms(self, positions: Floats, quaternions: Floats, rows: Rows) -> Floats:
        """(m, 3) mm in the base from flanges at poses (m, 3), (m, 4) to where they meet the tip."""
        out = np.empty_like(positions)
        tool, frame = self.tool[rows], self.frame[rows]
        for t, f in np.unique(np.stack([tool, frame], axis=1), axis=0):
            here = (tool == t) & (frame == f)
            tip = self.tools[t].tip.position
            if self.frames[f].held or not self.tools[t].held:
                out[here] = tip - positions[here]
            else:
                out[here] = rotations.rotate(quaternions[here], np.array(tip))
        return out

    def unchanged(self) -> Truths:
        """(n,) whether a row has the tool and frame of the row before."""
        same = np.zeros(len(self.tool), dtype=bool)
        same[1:] = (np.diff(self.tool) == 0) & (np.diff(self.frame) == 0)
        return same


@dataclass(frozen=True, slots=True)
class SpeedsAndBlends:
    """How fast the rows are reached and how their corners are rounded.

    speed, blend: (n,) rows of the tables speeds and blends.
    """

    speed: NDArray[np.int32]
    blend: NDArray[np.int32]
    speeds: Sequence[Speed | Name]
    blends: Sequence[Blend | Name]


@dataclass(frozen=True, slots=True)
class Run:
    """n moves of a program.

    names: of the paths and procedures that it consists of. starts: (k + 1,) where each of
    these k parts begins, and n. kinds: (n,) `Kind`. targets: rows → poses of the tool in
    the frame, positions (m, 3) mm and quaternions (m, 4). mounting: the tools and frames of
    the rows. pace: their speeds and blends. configurations: (n, 6). external: (n, 6) deg or
    mm, NaN for an unused axis.
    before: (a,) deg, where the robot is before the run, as far as is known.
    joined: whether it surely is there, so that a linear first move starts from there.
    label: row → what the row is called in a finding.
    exact: (n,) whether a stated quadrant counts; not for what is moved from a target. None: all.
    """

    names: tuple[str, ...]
    starts: Rows
    kinds: NDArray[np.uint8]
    targets: Callable[[slice | Rows], tuple[Floats, Floats]]
    mounting: Mounting
    pace: SpeedsAndBlends
    configurations: NDArray[np.int8]
    external: Floats
    before: Floats
    joined: bool
    label: Callable[[int], Goal]
    exact: Truths | None = None

    def __len__(self) -> int:
        return len(self.kinds)

    def flange(self, rows: slice | Rows) -> tuple[Floats, Floats]:
        """Poses of the flange in the base of the robot at some rows."""
        return self.mounting.to_flange(*self.targets(rows), rows)

    @property
    def exact_rows(self) -> Truths:
        return np.ones(len(self), bool) if self.exact is None else self.exact

    def what(self, rows: Rows) -> Goal | SomeTargets | Several:
        """The first of some rows (ascending) of each part of the run, the rest counted.

        Many neighbours are named by the first and the last of them.
        """
        ends = np.searchsorted(rows, self.starts)
        said = [
            self._of_part(part, rows[ends[part] : ends[part + 1]])
            for part in np.flatnonzero(np.diff(ends))[:MOST_NAMED_ROWS]
        ]
        more = int(np.count_nonzero(np.diff(ends))) - len(said)
        return said[0] if len(said) == 1 and not more else Several(tuple(said), more)

    def _of_part(self, part: int, rows: Rows) -> Goal | SomeTargets:
        whole = int(self.starts[part + 1] - self.starts[part])
        if whole == 1:
            return self.label(int(rows[0]))
        cuts = np.flatnonzero(np.diff(rows) > 1) + 1
        said: list[Goal | Neighbours] = []
        count = 0
        for group in np.split(rows, cuts[:MOST_NAMED_ROWS])[:MOST_NAMED_ROWS]:
            first, last = self.label(int(group[0])), self.label(int(group[-1]))
            if len(group) < LEAST_NAMED_RANGE:
                group = group[: MOST_NAMED_ROWS - len(said)]
                said += [self.label(int(row)) for row in group]
            else:
                said.append(Neighbours(first, last))
            count += len(group)
            if len(said) >= MOST_NAMED_ROWS:
                break
        return SomeTargets(self.names[part], len(rows), whole, tuple(said), len(rows) - count)


def continued(run: Run) -> bool:
    """Whether the first move goes on without a joint move from where the arm is."""
    return run.joined and bool(run.kinds[0] != Kind.JOINT)


def to_flange(
    positions: Floats, quaternions: Floats, tool: Tool, frame: Frame
) -> tuple[Floats, Floats]:
    """Targets of a tool in a frame → poses of the flange in the base of the robot.

    Carried tool: flange = frame · target · tip⁻¹. A tool that stands in the room and a
    work piece that the robot carries: flange = tip · (frame · target)⁻¹.
    """
    placed = frame.pose
    with np.errstate(invalid="ignore", divide="ignore"):  # of no length: found as no number
        unit = quaternions / norms(quaternions)[:, None]
    q = rotations.multiply(placed.quaternion, unit)
    p = rotations.rotate(placed.quaternion, positions) + placed.position
    if frame.held or not tool.held:
        back = rotations.conjugate(q)
        position = -rotations.rotate(back, p)
        tip = tool.tip
        return (
            rotations.rotate(tip.quaternion, position) + tip.position,
            np.asarray(rotations.multiply(tip.quaternion, back)),
        )
    inverse = tool.tip.inverse()
    return (
        p + rotations.rotate(q, inverse.position),
        np.asarray(rotations.multiply(q, inverse.quaternion)),
    )


def from_flange(
    positions: Floats, quaternions: Floats, tool: Tool, frame: Frame
) -> tuple[Floats, Floats]:
    """Poses of the flange (n, 3), (n, 4) → targets of a tool in a frame; undoes `to_flange`."""
    p, q, tip = positions, quaternions, tool.tip
    if frame.held or not tool.held:
        q = rotations.conjugate(q)
        p = -rotations.rotate(q, p)
    into = frame.pose.inverse()
    p = p + rotations.rotate(q, tip.position)
    q = np.asarray(rotations.multiply(q, tip.quaternion))
    return (
        rotations.rotate(into.quaternion, p) + into.position,
        np.asarray(rotations.multiply(into.quaternion, q)),
    )
