"""The linear and circular moves of a run in columns: where each begins, how long it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from assistant.base.arrays import Floats, Rows, Truths, all_of, norms
from assistant.program.expressions import Name
from assistant.program.geometry import Pose
from assistant.program.motion import Blend, Kind, Speed
from assistant.robots import Robot
from assistant.robots.motion.along import ToolWays, flange_along
from assistant.robots.motion.arcs import Arcs, Circles, circles
from assistant.robots.motion.run import Run
from assistant.robots.solved_program import SolvedRun


@dataclass(frozen=True)
class Moves:
    """m linear and circular moves of a solved run, those whose start is known.

    rows: (m,) row of the run that a move ends at. starts: (m,) the one that it begins at, -1 for
    where the robot stands before the run. vias: (m,) row of the via point of an arc, else -1.
    positions, quaternions, joints: of the run, one place further down, the first being where the
    robot stands before it; NaN where that is not known.
    speeds, blends: of the run, by row of its tables; NaN for a named one that nobody declares.
    """

    solved_run: SolvedRun
    robot: Robot
    rows: Rows
    starts: Rows
    vias: Rows
    positions: Floats
    quaternions: Floats
    joints: Floats
    speeds: tuple[Speed, ...]
    radii: Floats

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def run(self) -> Run:
        return self.solved_run.run

    @cached_property
    def arcs(self) -> Truths:
        """(m,) which moves are circular."""
        return self.vias >= 0

    @cached_property
    def _round(self) -> Arcs | None:
        """The moves that are round, each a whole arc."""
        at = np.flatnonzero(self.arcs)
        if not len(at):
            return None
        on = self.circles(at)
        around = np.flatnonzero(on.ends > 0.0)
        circles = on.of(around)
        return (
            Arcs(at[around], circles, np.zeros(len(around)), circles.ends) if len(around) else None
        )

    @cached_property
    def length(self) -> Floats:
        """(m,) mm of the way of the TCP in its frame."""
        chord = norms(self.positions[self.rows + 1] - self.positions[self.starts + 1])
        at = np.flatnonzero(self.arcs)
        if len(at):
            on = self.circles(at)
            chord[at] = np.where(on.ends > 0.0, on.radii * on.ends, chord[at])
        return np.asarray(chord)

    @cached_property
    def turn(self) -> Floats:
        """(m,) degrees of reorientation."""
        q0, q1 = self.quaternions[self.starts + 1], self.quaternions[self.rows + 1]
        q1 = np.where(np.einsum("ij,ij->i", q0, q1)[:, None] < 0.0, -q1, q1)
        half = norms(q1 - q0) / 2.0
        return np.asarray(4.0 * np.degrees(np.arcsin(np.minimum(half, 1.0))))

    @cached_property
    def tcp(self) -> Floats:
        """(m,) mm/s that are programmed; infinite for as fast as can be, NaN if not known."""
        return self._of_speed([speed.tcp for speed in self.speeds])

    @cached_property
    def rotation(self) -> Floats:
        """(m,) deg/s of reorientation that are programmed."""
        return self._of_speed([speed.rotation for speed in self.speeds])

    @cached_property
    def seconds(self) -> Floats:
        """(m,) that a move takes at its programmed speeds, without accelerating; NaN if not known.

        A controller lets position and orientation arrive together, so the slower one counts.
        """
        fastest = self.robot.tcp_speed or np.inf
        tcp = np.minimum(self.tcp, fastest)
        return np.asarray(np.maximum(self.length / tcp, self.turn / self.rotation))

    @cached_property
    def through(self) -> tuple[Truths, Truths]:
        """(m,) whether a move begins, and whether it ends, without a stop."""
        passing = np.append(False, self.radii[self.run.pace.blend] > 0.0)
        return passing[self.starts + 1], passing[self.rows + 1]

    def circles(self, at: Rows) -> Circles:
        """Those of some arcs; they go round up to `Circles.ends`, 0 for three points on a line."""
        return circles(
            *(self.positions[rows[at] + 1] for rows in (self.starts, self.vias, self.rows))
        )

    def tangents(self, at: Rows, *, at_end: bool) -> Floats:
        """Directions (k, 3) in which some arcs begin or end."""
        a, c = self.positions[self.starts[at] + 1], self.positions[self.rows[at] + 1]
        on = self.circles(at)
        along = on.directions(on.ends if at_end else np.zeros(len(at)))
        return np.where(on.ends[:, None] > 0.0, along, c - a)

    def poses(self, at: Rows, parts: int) -> tuple[Floats, Floats]:
        """Poses of the flange between the ends of some moves: (k, parts - 1, 3), (k, parts - 1, 4).

        They divide the way into equal parts.
        """
        even = np.arange(1, parts) / parts
        return self.poses_at(at, np.broadcast_to(even, (len(at), parts - 1)))

    def poses_at(self, at: Rows, part: Floats) -> tuple[Floats, Floats]:
        """Poses of the flange at parts (k, s) of some moves (k,): (k, s, 3), (k, s, 4).

        Equal parts take equal times, as a controller divides the way at a steady speed.
        """
        first, last = self.starts[at] + 1, self.rows[at] + 1
        starts = self.positions[first], self.quaternions[first]
        ends = self.positions[last], self.quaternions[last]
        tool = ToolWays(starts, ends, at, self._round).at(part)
        return flange_along(self.run.mounting, self.rows[at], tool)

    def _of_speed(self, values: Sequence[float]) -> Floats:
        return np.asarray(np.array(values, dtype=np.float64)[self.run.pace.speed[self.rows]])


def moves_of(
    solved_run: SolvedRun,
    robot: Robot,
    speeds: Mapping[str, Speed],
    blends: Mapping[str, Blend],
) -> Moves:
    """The linear and circular moves of a solved run; speeds, blends: named ones, by lower case.

    A move whose tool or frame is not that of the move before begins at no known place.
    """
    run = solved_run.run
    p, q = _with_start(run, robot)
    unit = q / norms(q)[:, None]
    before = run.before if run.joined else np.full(len(robot.axes), np.nan)
    joints = np.concatenate([before[None], solved_run.joints])
    kinds = run.kinds
    rows = np.flatnonzero((kinds == Kind.LINEAR) | (kinds == Kind.END))
    arc = (kinds[rows] == Kind.END) & (rows > 0)
    arc &= kinds[np.maximum(rows - 1, 0)] == Kind.VIA
    starts = np.where(arc, rows - 2, rows - 1)
    same = np.append(run.mounting.unchanged(), True)
    same[0] = True  # the start was put into the tool and frame of the first row
    known = same[rows] & np.where(arc, same[rows - 1], True)
    known &= all_of(np.isfinite(joints[rows + 1])) & all_of(np.isfinite(joints[starts + 1]))
    known &= all_of(np.isfinite(p[starts + 1])) & all_of(np.isfinite(p[rows + 1]))
    nothing = Speed(np.nan, np.nan)
    rows, starts, arc = rows[known], starts[known], arc[known]
    return Moves(
        solved_run=solved_run,
        robot=robot,
        rows=rows,
        starts=starts,
        vias=np.where(arc, rows - 1, -1),
        positions=p,
        quaternions=unit,
        joints=joints,
        speeds=tuple(
            speeds.get(s.name.lower(), nothing) if isinstance(s, Name) else s
            for s in run.pace.speeds
        ),
        radii=np.array([_blend_radius(blend, blends) for blend in run.pace.blends]),
    )


def _with_start(run: Run, robot: Robot) -> tuple[Floats, Floats]:
    """Targets (n + 1, 3), (n + 1, 4), the first being where the robot stands before the run."""
    p, q = run.targets(slice(None))
    here = np.full(7, np.nan)
    if run.joined:
        position, quaternion = robot.fk(run.before)
        pose = run.mounting.from_flange(Pose.of(position[0], quaternion[0]), 0)
        here = np.array([*pose.position, *pose.quaternion])
    return np.concatenate([here[None, :3], p]), np.concatenate([here[None, 3:], q])


def _blend_radius(blend: Blend | Name, named: Mapping[str, Blend]) -> float:
    """Mm before the target at which the path may leave it, 0 for a stop, NaN if not known."""
    known = named.get(blend.name.lower()) if isinstance(blend, Name) else blend
    if known is None:
        return np.nan
    return 0.0 if known.radius is None else known.radius
