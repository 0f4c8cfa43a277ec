"""What the arm does between the targets of linear moves that are far apart.

The angles at both ends of a move do not tell how often an axis turned on the way, nor
whether the line leaves the reach of the arm; poses on the line do.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.program.diagnostics import Diagnostic
from assistant.program.path import Kind
from assistant.robots import findings as rules
from assistant.robots.arms.arm import CLOSING
from assistant.robots.robot import CHUNK, LIMIT_TOLERANCE, Robot
from assistant.robots.run import Run

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

WIDE: Final = 20.0
"""degrees or mm that an axis moves in one move from which on the line is looked at."""
JUMP: Final = 1.0
"""degrees or mm between joints that are not the same solution."""
SAMPLES: Final = 12
"""Poses on such a line."""


@dataclass(frozen=True, slots=True)
class Lines:
    """winding: (n, a) whole turns that an axis makes on the way to a row beyond the shorter
    way from the row before. findings: what cannot be done on the way to which rows.
    """

    winding: NDArray[np.int64]
    findings: tuple[Diagnostic, ...]
    rows: Rows


def lines(run: Run, robot: Robot, joints: Floats, branch: Rows) -> Lines:
    """Looks at the linear moves of a run whose joints (n, a) deg are up to whole turns.

    branch: (n,) of each row, -1 where there is none.
    """
    n, axes = joints.shape
    winding = np.zeros((n, axes), dtype=np.int64)
    step = np.zeros((n, axes))
    step[1:] = robot.wound(np.diff(joints, axis=0))
    with np.errstate(invalid="ignore"):
        wide = (np.abs(step) > WIDE).any(axis=1)
    wide &= (run.kinds == Kind.LINEAR) & run.mounting.unchanged()
    wide[1:] &= (branch[1:] == branch[:-1]) & (branch[1:] >= 0)
    rows = np.flatnonzero(wide & np.isfinite(step).all(axis=1))
    bad: list[tuple[int, str]] = []
    many = max(CHUNK // SAMPLES, 1)
    for start in range(0, len(rows), many):
        some = rows[start : start + many]
        for one in np.unique(branch[some]):
            here = some[branch[some] == one]
            found, excess = _on_the_way(run, robot, here, int(one), joints[here - 1])
            between = np.concatenate(
                [joints[here - 1][:, None], found, joints[here][:, None]], axis=1
            )
            swept = robot.wound(np.diff(between, axis=1)).sum(axis=1)
            winding[here] = np.round((swept - step[here]) / 360.0)
            bad += _bad(robot, here, found, excess)
            if not robot.arm.named:
                bad += _jumps(run, robot, here, found[:, -1], joints[here])
    bad.sort()
    if not bad:
        return Lines(winding, (), np.empty(0, np.intp))
    over = np.array([row for row, _ in bad], dtype=np.intp)
    row, reason = bad[0]
    where = run.label(row)
    place = run.what(over)
    finding = rules.ON_THE_WAY(place=place, robot=robot.title, reason=reason, where=where)
    return Lines(winding, (finding,), over)


def _on_the_way(
    run: Run, robot: Robot, rows: Rows, branch: int, before: Floats
) -> tuple[Floats, Floats]:
    """Joints (m, s, a) deg and excess of the reach (m, s) mm on the lines to some rows.

    before: (m, a) deg where the lines begin.
    """
    p0, q0 = run.targets(rows - 1)
    p1, q1 = run.targets(rows)
    part = (np.arange(1, SAMPLES + 1) / (SAMPLES + 1))[None, :, None]
    p = p0[:, None] + part * (p1 - p0)[:, None]
    q = _turned(q0, q1, part[..., 0])
    p, q = run.mounting.to_flange(p.reshape(-1, 3), q.reshape(-1, 4), np.repeat(rows, SAMPLES))
    shape = (len(rows), SAMPLES)
    if not robot.arm.named:
        return robot.follow(before, p.reshape(*shape, 3), q.reshape(*shape, 4))
    found, excess = robot.solve(p, q, (branch,))
    return found[:, 0].T.reshape(*shape, len(robot.axes)), excess[0].reshape(shape)


def _turned(first: Floats, last: Floats, part: Floats) -> Floats:
    """Quaternions (m, s, 4) on the shorter turn between two columns (m, 4), at parts (1, s)."""
    first = first / np.linalg.norm(first, axis=1, keepdims=True)
    last = last / np.linalg.norm(last, axis=1, keepdims=True)
    cosine = np.einsum("ij,ij->i", first, last)
    last = np.where(cosine[:, None] < 0.0, -last, last)
    angle = np.arctan2(np.linalg.norm(last - first, axis=1), np.linalg.norm(last + first, axis=1))
    angle = 2.0 * angle[:, None]
    sine = np.maximum(np.sin(angle), 1e-12)
    near = angle < 1e-6
    one = np.where(near, 1.0 - part, np.sin((1.0 - part) * angle) / sine)
    two = np.where(near, part, np.sin(part * angle) / sine)
    return np.asarray(one[..., None] * first[:, None] + two[..., None] * last[:, None])


def _jumps(
    run: Run, robot: Robot, rows: Rows, last: Floats, joints: Floats
) -> list[tuple[int, str]]:
    """Rows whose joints (m, a) deg are not those that the last ones on the way (m, a) lead to: an
    arm whose branches have no names may have several solutions in one.
    """
    p, q = run.flange(rows)
    led, _ = robot.follow(last, p[:, None], q[:, None])
    off = np.abs(robot.wound(joints - led[:, 0]))
    out = []
    for i in np.flatnonzero(off.max(axis=1) > JUMP):
        axis = int(off[i].argmax())
        name, unit = robot.axes[axis], robot.units[axis]
        out.append((int(rows[i]), f"would have {name} jump by {off[i, axis]:.1f} {unit}"))
    return out


def _bad(robot: Robot, rows: Rows, found: Floats, excess: Floats) -> list[tuple[int, str]]:
    low, high = robot.limits.T
    beyond = np.maximum(low - found, found - high)
    short = excess.max(axis=1)
    over = beyond.max(axis=(1, 2))
    out = []
    for i in np.flatnonzero((short >= CLOSING) | (over > LIMIT_TOLERANCE)):
        if short[i] >= CLOSING:
            out.append((int(rows[i]), f"is up to {short[i]:.1f} mm out of reach"))
            continue
        sample, axis = np.unravel_index(beyond[i].argmax(), beyond[i].shape)
        angle = found[i, sample, axis]
        limit = low[axis] if angle < low[axis] else high[axis]
        reason = (
            f"would have {robot.axes[axis]} at {angle:.2f} {robot.units[axis]}, limit {limit:g}"
        )
        out.append((int(rows[i]), reason))
    return out
