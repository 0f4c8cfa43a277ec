"""A run: moves that follow each other without a branch of the program, in columns.

Moves and paths of a program are gathered into one run, with one table of tools, frames, speeds and
blends for all of its rows.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, norms
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Goal, Neighbours, PathRow, Several, SomeTargets
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import UNSTATED, Blend, Kind, Path, Speed, configuration_row
from assistant.program.statements import Motion
from assistant.robots.configurations import BACK
from assistant.robots.program_values import Place

_MOST_NAMED_ROWS: Final = 3
"""Largest number of rows, or ranges of rows, that a finding names before it counts the rest."""
_LEAST_NAMED_RANGE: Final = 4
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
        """Return the tip on the flange at a row; the identity for a stationary tool."""
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
    """Speeds of the rows and blends at their corners.

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
            for part in np.flatnonzero(np.diff(ends))[:_MOST_NAMED_ROWS]
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
        for group in np.split(rows, cuts[:_MOST_NAMED_ROWS])[:_MOST_NAMED_ROWS]:
            first, last = self.label(int(group[0])), self.label(int(group[-1]))
            if len(group) < _LEAST_NAMED_RANGE:
                group = group[: _MOST_NAMED_ROWS - len(said)]
                said += [self.label(int(row)) for row in group]
            else:
                said.append(Neighbours(first, last))
            count += len(group)
            if len(said) >= _MOST_NAMED_ROWS:
                break
        return SomeTargets(self.names[part], len(rows), whole, tuple(said), len(rows) - count)


def continued(run: Run) -> bool:
    """True if the first move continues from the position of the arm without a joint move."""
    return run.joined and bool(run.kinds[0] != Kind.JOINT)


def to_flange(
    positions: Floats, quaternions: Floats, tool: Tool, frame: Frame
) -> tuple[Floats, Floats]:
    """Convert targets of a tool in a frame to poses of the flange in the base of the robot.

    Carried tool: flange = frame · target · tip⁻¹. Stationary tool and a work piece that the robot
    carries: flange = tip · (frame · target)⁻¹.
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


Configurations = NDArray[np.int8]
S = TypeVar("S", bound=np.generic)
V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class SingleMove:
    """One row of a run. place: the target and where it is from there."""

    kind: Kind
    place: Place
    tool: Tool
    frame: Frame
    motion: Motion
    label: Goal


@dataclass(frozen=True, slots=True)
class RunPart:
    """A path, or separate moves, n rows of either.

    keys: ids of the owners of the configurations: of the path, or of the target of each row. exact:
    see `Run`.
    """

    name: str
    is_path: bool
    keys: tuple[int, ...]
    kinds: NDArray[np.uint8]
    positions: Floats
    quaternions: Floats
    configurations: Configurations
    external: Floats
    mounting: Mounting
    pace: SpeedsAndBlends
    exact: Truths
    label: Callable[[int], Goal]

    def __len__(self) -> int:
        return len(self.kinds)


def path_part(
    path: Path, configurations: Configurations, tools: Sequence[Tool], frames: Sequence[Frame]
) -> RunPart:
    """A path with the tools and frames that its tables name."""
    return RunPart(
        name=path.name,
        is_path=True,
        keys=(id(path),),
        kinds=path.kinds,
        positions=path.positions,
        quaternions=path.quaternions,
        configurations=configurations,
        external=path.external,
        mounting=Mounting(path.tool, path.frame, tools, frames),
        pace=SpeedsAndBlends(path.speed, path.blend, path.speeds, path.blends),
        exact=np.broadcast_to(np.True_, (len(path),)),
        label=lambda row: PathRow(path.name, row + 1, original=path.row_name(row)),
    )


def moves_part(name: str, moves: Sequence[SingleMove], done: dict[int, Configurations]) -> RunPart:
    """Moves of the procedure `name`; done: id of a target → its configuration, if it has one."""
    tools, frames = _ValueTable[Tool](), _ValueTable[Frame]()
    speeds, blends = _ValueTable[Speed | Name](), _ValueTable[Blend | Name]()
    targets = [move.place.target for move in moves]
    rows = [done.get(id(target), configuration_row(target.configuration)) for target in targets]
    labels = [move.label for move in moves]
    tool = np.array([tools.row(move.tool) for move in moves], dtype=np.int32)
    frame = np.array([frames.row(move.frame) for move in moves], dtype=np.int32)
    speed = np.array([speeds.row(move.motion.fixed[0]) for move in moves], dtype=np.int32)
    blend = np.array([blends.row(move.motion.fixed[1]) for move in moves], dtype=np.int32)
    return RunPart(
        name=name,
        is_path=False,
        keys=tuple(id(target) for target in targets),
        kinds=np.array([move.kind for move in moves], dtype=np.uint8),
        positions=np.array([move.place.pose.position for move in moves], dtype=np.float64),
        quaternions=np.array([move.place.pose.quaternion for move in moves], dtype=np.float64),
        configurations=np.array(rows, dtype=np.int8),
        external=np.array([target.external for target in targets], dtype=np.float64),
        mounting=Mounting(tool, frame, tools.values, frames.values),
        pace=SpeedsAndBlends(speed, blend, speeds.values, blends.values),
        exact=np.array([not move.place.moved for move in moves]),
        label=labels.__getitem__,
    )


def run_of_parts(parts: Sequence[RunPart], before: Floats, joined: bool) -> Run:
    """The parts, one after the other, as one run; a lone part keeps its own columns."""
    starts = np.cumsum([0, *(len(part) for part in parts)])
    position = _joined([part.positions for part in parts])
    quaternion = _joined([part.quaternions for part in parts])
    firsts = starts[:-1].tolist()

    def label(row: int) -> Goal:
        part = bisect_right(firsts, row) - 1
        return parts[part].label(row - firsts[part])

    return Run(
        names=tuple(part.name for part in parts),
        starts=starts,
        kinds=_joined([part.kinds for part in parts]),
        targets=lambda rows: (position[rows], quaternion[rows]),
        mounting=_joined_mountings([part.mounting for part in parts]),
        pace=_joined_speeds([part.pace for part in parts]),
        configurations=_joined([part.configurations for part in parts]),
        external=_joined([part.external for part in parts]),
        before=before,
        joined=joined,
        label=label,
        exact=_joined([part.exact for part in parts]),
    )


def first_configurations(
    parts: Sequence[RunPart], configurations: Configurations
) -> Configurations:
    """The configurations (n, 6), with those of the first place for what is met in several.

    A place that is only computed from a target speaks for it where the target itself is not met.
    """
    out = configurations
    seen: dict[int, Configurations] = {}
    at = 0
    for part in parts:
        if not part.is_path:
            rows = configurations[at : at + len(part)]
            for met in np.flatnonzero(part.exact & (rows[:, BACK] != UNSTATED)):
                seen.setdefault(part.keys[met], rows[met])
        at += len(part)
    at = 0
    for part in parts:
        rows = out[at : at + len(part)]
        if part.is_path:
            first = seen.setdefault(part.keys[0], rows)
            if not np.array_equal(first, rows):
                out = out.copy()
                out[at : at + len(part)] = first
        else:
            for i, key in enumerate(part.keys):
                if rows[i, BACK] == UNSTATED:
                    continue
                first = seen.setdefault(key, rows[i])
                if not np.array_equal(first, rows[i]):
                    out = out.copy() if out is configurations else out
                    out[at + i] = first
        at += len(part)
    return out


def _joined(columns: Sequence[NDArray[S]]) -> NDArray[S]:
    return columns[0] if len(columns) == 1 else np.concatenate(columns)


def _joined_mountings(mountings: Sequence[Mounting]) -> Mounting:
    """One mounting with the tables of all."""
    if len(mountings) == 1:
        return mountings[0]
    tools, frames = _ValueTable[Tool](), _ValueTable[Frame]()
    tool, frame = [], []
    for mounting in mountings:
        tool.append(np.array([tools.row(t) for t in mounting.tools], np.int32)[mounting.tool])
        frame.append(np.array([frames.row(f) for f in mounting.frames], np.int32)[mounting.frame])
    return Mounting(np.concatenate(tool), np.concatenate(frame), tools.values, frames.values)


def _joined_speeds(paces: Sequence[SpeedsAndBlends]) -> SpeedsAndBlends:
    """One pace with the tables of all."""
    if len(paces) == 1:
        return paces[0]
    speeds, blends = _ValueTable[Speed | Name](), _ValueTable[Blend | Name]()
    speed, blend = [], []
    for pace in paces:
        speed.append(np.array([speeds.row(s) for s in pace.speeds], np.int32)[pace.speed])
        blend.append(np.array([blends.row(b) for b in pace.blends], np.int32)[pace.blend])
    return SpeedsAndBlends(
        np.concatenate(speed), np.concatenate(blend), speeds.values, blends.values
    )


class _ValueTable(Generic[V]):
    """Values, each once, by the order in which they came."""

    def __init__(self) -> None:
        self.values: list[V] = []
        self.rows: dict[int, int] = {}

    def row(self, value: V) -> int:
        if id(value) not in self.rows:
            self.rows[id(value)] = len(self.values)
            self.values.append(value)
        return self.rows[id(value)]
