"""The moves of a straight piece of program in columns: where each leads, and how it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, norms
from assistant.program.expressions import Name
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.motion import FINE, Blend, Speed
from assistant.robots.motion.run import SpeedsAndBlends, from_flange, to_flange
from assistant.robots.robot import Robot

UNKNOWN_SPEED: Final = Speed(np.nan)


@dataclass(frozen=True, slots=True)
class Mount:
    """A tool in a frame."""

    tool: Tool
    frame: Frame

    def to_flange(self, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
        """Poses (n, 3), (n, 4) of the tool as `tip` gives them → of the flange."""
        return to_flange(positions, quaternions, self.tool, Frame(held=self.frame.held))

    def tip(self, robot: Robot, joints: Floats) -> tuple[Floats, Floats]:
        """Joints (n, a) → the tool's tip in the base, or in a work piece's holder if the arm
        carries the work piece: (n, 3), (n, 4).
        """
        return from_flange(*robot.fk(joints), self.tool, Frame(held=self.frame.held))


@dataclass(frozen=True, slots=True, eq=False)
class Moves:
    """n moves, each from where the one before ends.

    kinds: (n,) `Kind`. joints: (n, a) at their ends. positions, quaternions: (n, 3), (n, 4) of
    the tool at their ends, as `Mount.tip` gives them. mount: (n,) rows of the table mounts.
    tcp: (n,) mm/s. rotation: (n,) deg/s. percent: (n,) of the joints' speed, NaN if not stated.
    override: (n,) factor of the speeds. acceleration, deceleration: (n,) factors.
    entry, leaving: (n,) mm before and after the end where the path may be left; 0 to stop there.
    """

    kinds: NDArray[np.uint8]
    joints: Floats
    positions: Floats
    quaternions: Floats
    mount: NDArray[np.int32]
    mounts: tuple[Mount, ...]
    tcp: Floats
    rotation: Floats
    percent: Floats
    override: Floats
    acceleration: Floats
    deceleration: Floats
    entry: Floats
    leaving: Floats

    def __len__(self) -> int:
        return len(self.kinds)

    def rest(self, first: int) -> Moves:
        """Those from a row on."""
        return Moves(
            **{
                f.name: value if f.name == "mounts" else value[first:]
                for f in fields(self)
                for value in (getattr(self, f.name),)
            }
        )


def join_moves(parts: Sequence[Moves]) -> Moves:
    """Parts, one after the other, with one table of mounts."""
    if len(parts) == 1:
        return parts[0]
    mounts: list[Mount] = []
    columns = []
    for part in parts:
        mounts += [mount for mount in part.mounts if mount not in mounts]
        columns.append(np.array([mounts.index(m) for m in part.mounts], np.int32)[part.mount])
    whole = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts])
        for f in fields(Moves)
        if f.name not in ("mount", "mounts")
    }
    return Moves(mount=np.concatenate(columns), mounts=tuple(mounts), **whole)


@dataclass(frozen=True, slots=True)
class Settings:
    """What statements before a move say of it: factors of its speed and accelerations."""

    override: float = 1.0
    acceleration: float = 1.0
    deceleration: float = 1.0


def moves_of(
    kinds: NDArray[np.uint8],
    joints: Floats,
    poses: tuple[Floats, Floats],
    mount: tuple[NDArray[np.int32], tuple[Mount, ...]],
    pace: SpeedsAndBlends,
    rows: slice,
    tables: tuple[Mapping[str, Speed], Mapping[str, Blend]],
    settings: Settings,
) -> Moves:
    """Columns of moves whose speeds and blends are those of some rows of a pace.

    tables: named speeds and blends by their names in lower case. A name that is in none gives
    a speed that is no number, or a stop.
    """
    speeds = [_speed(speed, tables[0]) for speed in pace.speeds]
    blends = [_blend(blend, tables[1]) for blend in pace.blends]
    speed, blend = pace.speed[rows], pace.blend[rows]

    def column(values: list[float], index: NDArray[np.int32]) -> Floats:
        return np.array(values, dtype=np.float64)[index]

    n = len(kinds)
    return Moves(
        kinds=kinds,
        joints=joints,
        positions=poses[0],
        quaternions=poses[1],
        mount=mount[0],
        mounts=mount[1],
        tcp=column([s.tcp for s in speeds], speed),
        rotation=column([s.rotation for s in speeds], speed),
        percent=column([np.nan if s.joint is None else s.joint for s in speeds], speed),
        override=np.full(n, settings.override),
        acceleration=np.full(n, settings.acceleration),
        deceleration=np.full(n, settings.deceleration),
        entry=column([b.radius or 0.0 for b in blends], blend),
        leaving=column([_leaving(b) for b in blends], blend),
    )


def targets_out_of_frames(
    frames: Sequence[Pose], frame: NDArray[np.int32], p: Floats, q: Floats
) -> tuple[Floats, Floats]:
    """Targets (n, 3), (n, 4) in frames → in what the frames are in.

    frame: (n,) rows of the table frames.
    """
    q = q / norms(q)[:, None]
    if all(pose == Pose() for pose in frames):
        return p, q
    turn = np.array([pose.quaternion for pose in frames])
    shift = np.array([pose.position for pose in frames])
    if len(frames) == 1:
        return rotations.rotate(turn[0], p) + shift[0], rotations.multiply(turn[0], q)
    return rotations.rotate(turn[frame], p) + shift[frame], rotations.multiply(turn[frame], q)


def _speed(speed: Speed | Name, table: Mapping[str, Speed]) -> Speed:
    return table.get(speed.name.lower(), UNKNOWN_SPEED) if isinstance(speed, Name) else speed


def _blend(blend: Blend | Name, table: Mapping[str, Blend]) -> Blend:
    return table.get(blend.name.lower(), FINE) if isinstance(blend, Name) else blend


def _leaving(blend: Blend) -> float:
    return blend.radius or 0.0 if blend.exit is None else blend.exit
