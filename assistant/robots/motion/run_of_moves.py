"""Moves and paths that follow each other, gathered into one run."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Goal, PathRow
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Tool
from assistant.program.motion import UNSTATED, Blend, Kind, Path, Speed, configuration_row
from assistant.program.statements import Motion
from assistant.robots.configurations import BACK
from assistant.robots.motion.run import Mounting, Run, SpeedsAndBlends
from assistant.robots.target_lookup import Place

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
    """A path, or moves that stand by themselves, n rows of either.

    keys: ids of what the configurations belong to: of the path, or of the target of each row.
    exact: see `Run`.
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
