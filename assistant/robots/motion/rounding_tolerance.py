"""Tolerance for targets that are just out of reach because their numbers were printed rounded.

Makers print a taught position with two decimals of a millimetre, ABB its quaternion with six
and Mitsubishi its angles with two. The taught pose lies within that rounding; numbers with more
decimals were computed and are taken as they are.

A rounded target at a limit, at the border of a quadrant or of a turn, with a straight wrist or a
stretched arm may have joints beyond it: by little in general, by any angle near a singularity.
Such a target is accepted if joints inside the limits meet it within its rounding.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths, max_abs, norms
from assistant.base.data_classes import dataclass
from assistant.base.rotations import to_euler
from assistant.robots.arms.arm import CLOSING
from assistant.robots.arms.closed_form import to_ab
from assistant.robots.arms.nearest_pose import least_squares_joints

if TYPE_CHECKING:
    from assistant.robots.robot import Robot


_POSITION_DECIMALS: Final = (2, 3, 4)
"""Decimals of positions. A position of fewer is no coarser one: 300 is written for 300.00."""
_QUATERNION_DECIMALS: Final = (4, 5, 6, 7)
"""Decimals of quaternions."""
_TYPED_QUATERNION_UNIT: Final = 1e-6
"""Unit of a quaternion of fewer decimals, which is typed (0.5, 0.7071) and no less meant."""
_ANGLE_DECIMALS: Final = (2, 3, 4)
_SAME_DECIMAL: Final = 1e-3
"""Tolerance, as a share of the last decimal, within which a number counts as printed with so many
decimals.
"""


def roundings(robot: Robot, positions: Floats, quaternions: Floats) -> Floats:
    """(n, 2) mm and degrees that targets (n, 3), (n, 4) may be off, as its maker prints them.

    The lengths of what half a unit in the last place of each number adds up to; never less than
    `CLOSING`, which is all for numbers of more decimals.
    """
    out = np.empty((len(positions), 2))
    out[:, 0] = 0.5 * np.sqrt(3.0) * _unit(_POSITION_DECIMALS, positions)
    if robot.counts == "quadrants":
        # Half a unit of four parts, and a turn moves the unit quaternion by half its angle.
        unit = np.minimum(
            _unit(_QUATERNION_DECIMALS, quaternions, scaled=True), _TYPED_QUATERNION_UNIT
        )
        out[:, 1] = np.degrees(2.0) * unit
    else:
        angles = to_ab(positions, quaternions) if robot.five_axis else to_euler(quaternions)
        # Two of the three axes may lie in line, where their rounding adds up.
        out[:, 1] = 0.5 * np.sqrt(5.0) * _unit(_ANGLE_DECIMALS, angles)
    if robot.five_axis:  # whose tool lies in the plane from axis 1 through the position
        away = np.maximum(np.hypot(positions[:, 0], positions[:, 1]), CLOSING)
        out[:, 1] += np.degrees(np.minimum(out[:, 0] / away, 1.0))
    return np.maximum(out, CLOSING)


def _unit(decimals: tuple[int, ...], values: Floats, *, scaled: bool = False) -> Floats:
    """(n,) of what place the last decimals of values (n, k) are, 0 where of none of them.

    scaled: the values were made unit length behind the rounding.
    """
    out = np.zeros(len(values))
    rows = np.arange(len(values))
    largest = np.abs(values).argmax(axis=1)[:, None]
    for places in reversed(decimals):
        units = values * 10.0**places
        off = max_abs(units - np.round(units))
        if scaled:
            # The largest part was a whole number of units, a few of which are tried.
            longest = np.take_along_axis(units, largest, axis=1)
            for other in (-1.0, 0.0, 1.0):
                with np.errstate(invalid="ignore", divide="ignore"):
                    stretched = units * ((np.round(longest) + other) / longest)
                off = np.fmin(off, max_abs(stretched - np.round(stretched)))
        out[rows[off < _SAME_DECIMAL]] = 10.0**-places
    return out


_MET_COST: Final = 2.0
"""Cost of joints that meet a target: the squares of what is missing of the position and of the
orientation, each as a share of its rounding. What was meant costs no more, and what is missed by
more than one and a half times its rounding costs more."""
MOST_STEPS: Final = 60
MOST_SHIFT: Final = 3.0
"""degrees or mm that rounding moves an axis by at most, but for axes 4 and 6 beside a straight
wrist, whose axis 5 is within so many degrees of it."""
MOST_REGULAR_SHIFT: Final = 0.2
"""degrees or mm that rounding moves an axis by at most away from every singularity."""
_REGULAR_LEVER: Final = 200.0
"""mm of the wrist from axis 1 from which on it counts as away from that singularity."""
_BRANCHES_MEET: Final = 1e-3
"""Sine of axis 5 or of the elbow, or of the wrist from axis 1 in `_REGULAR_LEVER`, up to which it
is open in which of two branches an arm is.
"""
_OVER_AXIS: Final = 1.0
"""mm of the wrist from axis 1 within which rounding may turn axis 1 by any angle."""
_DIRECTIONS_AROUND: Final = 2.0 * np.pi * np.arange(48) / 48.0
"""Directions in which poses beside a printed one are tried there, at half and at all of its
rounding by turns."""


@dataclass(frozen=True, slots=True)
class RoundedPoses:
    """Poses of the flange (k, 3), (k, 4) with what they may be off.

    arms: (k, 3) mm from the flange to the tip. rounding: (k, 2) mm of the tip and degrees.
    """

    positions: Floats
    quaternions: Floats
    arms: Floats
    rounding: Floats

    def of(self, rows: Rows) -> RoundedPoses:
        return RoundedPoses(
            self.positions[rows], self.quaternions[rows], self.arms[rows], self.rounding[rows]
        )

    @property
    def play(self) -> Floats:
        """(k,) degrees or mm that rounding moves an axis by at most away from singularities."""
        place, turn = self.rounding.T
        place = place + np.radians(turn) * norms(self.arms)
        return np.asarray(5.0 * (turn + np.degrees(place / _REGULAR_LEVER)))

    def missing(self, robot: Robot, joints: Floats, which: Rows) -> Floats:
        """(m, s, 6) of joints (m, s, a) deg: what is missing in shares of the rounding."""
        flat, tries = joints.reshape(-1, joints.shape[2]), joints.shape[1]
        each = np.repeat(which, tries)
        p, q = robot.flange_poses(flat)
        turn = rotations.turns(q, self.quaternions[each])
        off = self.positions[each] - p + np.cross(turn, self.arms[each])
        rounding = self.rounding[each]
        out = np.hstack([off / rounding[:, :1], np.degrees(turn) / rounding[:, 1:]])
        return out.reshape(len(which), tries, 6)


def joints_within_rounding(
    robot: Robot,
    wanted: RoundedPoses,
    branches: Rows,
    joints: Floats,
    limits: tuple[Floats, Floats],
) -> tuple[Floats, Truths]:
    """Joints (k, a) deg between limits (k, a) each that meet k poses, and whether they do (k,).

    joints: (k, a) of the poses as they are printed in their branches (k,), any turns.
    """
    low, high = _bent(robot, joints, limits) if robot.arm.spherical else limits
    out, met = joints.copy(), np.zeros(len(joints), dtype=bool)
    rows = np.flatnonzero((low <= high).all(axis=1) & np.isfinite(joints).all(axis=1))
    _store_found(robot, wanted, rows, (joints[rows], low, high), (out, met))
    met &= _same_branch(robot, out, branches)
    if robot.arm.spherical:
        rows = rows[~met[rows]]
        line = rows[np.abs(joints[rows, 4]) < MOST_SHIFT]
        rolled = _rolled(robot, joints, low, high)[line]
        _store_found(robot, wanted, line, (rolled, low, high), (out, met))
        met &= _same_branch(robot, out, branches)
        rows = rows[~met[rows]]
        over = _over_axis(robot, joints[rows])
        rows = rows[over]
        if not len(rows):
            return out, met
        beside = _beside(robot, wanted.of(rows), branches[rows], (low[rows], high[rows]))
        _store_found(robot, wanted, rows, (beside, low, high), (out, met))
        met &= _same_branch(robot, out, branches)
    return out, met


def _store_found(
    robot: Robot,
    wanted: RoundedPoses,
    rows: Rows,
    given: tuple[Floats, Floats, Floats],
    into: tuple[Floats, Truths],
) -> None:
    """Puts what is found for some rows (m,) into the columns of all.

    given: joints (m, a) of these rows, limits (k, a) of all. into: joints (k, a), met (k,).
    """
    joints, low, high = given
    low, high = low[rows], high[rows]
    start = _placed_within(robot, joints, low, high)
    near = _near(robot, wanted.of(rows), start, joints)
    rows, start, low, high = rows[near], start[near], low[near], high[near]
    here = wanted.of(rows)

    def missing(tried: Floats, which: Rows) -> Floats:
        return here.missing(robot, tried, which)

    found, cost = least_squares_joints(missing, start, low, high, MOST_STEPS, _MET_COST / 4.0)
    good = cost <= _MET_COST
    into[0][rows[good]] = found[good]
    into[1][rows[good]] = True


def _bent(robot: Robot, joints: Floats, limits: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Limits (k, a) each, of axis 5 to the side to which the wrist of joints (k, a) is bent, so
    that no search goes through a straight wrist into another branch.
    """
    low, high = (limit.copy() for limit in limits)
    bend, straight = robot.chained(joints)[:, 4], -robot.zero[4]
    low[bend > 0.0, 4] = np.maximum(low[bend > 0.0, 4], straight)
    high[bend < 0.0, 4] = np.minimum(high[bend < 0.0, 4], straight)
    return low, high


def _rolled(robot: Robot, joints: Floats, low: Floats, high: Floats) -> Floats:
    """Joints (k, a) with axis 4 in the middle of its limits, axis 6 taking up the turn: what is
    nearest to where axis 4 is may lie at a limit that keeps the others from what was meant.
    """
    out = joints.copy()
    out[:, 3] = (low[:, 3] + high[:, 3]) / 2.0
    out[:, 5] += robot.arm.rolls * (joints[:, 3] - out[:, 3])
    return out


def _near(robot: Robot, wanted: RoundedPoses, start: Floats, joints: Floats) -> Truths:
    """(k,) whether rounding may be what puts joints (k, a) away from start (k, a)."""
    off = np.abs(robot.wound(start - joints))
    if robot.arm.spherical:
        off[np.abs(start[:, 4]) < MOST_SHIFT, 3::2] = 0.0
    near = off.max(axis=1) <= wanted.play * looseness(robot, joints)
    return np.asarray(near | _over_axis(robot, joints))


def _same_branch(robot: Robot, joints: Floats, branches: Rows) -> Truths:
    """(k,) whether joints (k, a) are in their branches (k,), or where two of them meet."""
    same = np.asarray(robot.branch_of(robot.configuration(joints)) == branches)
    rest = np.flatnonzero(~same)
    if len(rest):
        chain = robot.chained(joints[rest])
        elbow, ahead = robot.arm.elbow(chain), robot.arm.wrist(chain)
        meet = np.zeros(len(rest), dtype=bool)
        if robot.arm.spherical:
            meet |= np.abs(np.sin(chain[:, 4])) < _BRANCHES_MEET
        if elbow is not None:
            meet |= np.abs(np.sin(elbow)) < _BRANCHES_MEET
        if ahead is not None:
            meet |= np.abs(ahead) < _BRANCHES_MEET * _REGULAR_LEVER
        same[rest] = meet
    return same


def looseness(robot: Robot, joints: Floats) -> Floats:
    """(k,) how many times further rounding moves an axis of joints (k, a) than away from every
    singularity, about.
    """
    chain = robot.chained(joints)
    firm = np.ones(len(joints))
    if robot.arm.spherical:
        firm *= np.abs(np.sin(chain[:, 4]))
    elbow, ahead = robot.arm.elbow(chain), robot.arm.wrist(chain)
    if elbow is not None:
        firm *= np.abs(np.sin(elbow))
    if ahead is not None:
        firm *= np.minimum(np.abs(ahead) / _REGULAR_LEVER, 1.0)
    return np.asarray(1.0 / np.maximum(firm, 1e-9))


def _over_axis(robot: Robot, joints: Floats) -> Truths:
    """(k,) whether the wrist of joints (k, a) is over axis 1."""
    ahead = robot.arm.wrist(robot.chained(joints))
    if ahead is None:
        return np.zeros(len(joints), dtype=bool)
    return np.asarray(np.abs(ahead) < _OVER_AXIS)


def _placed_within(robot: Robot, joints: Floats, low: Floats, high: Floats) -> Floats:
    """Return joints (k, a) moved between low and high (k, a): by whole turns, then axes 4 and 6 of
    a straight wrist together, then each axis alone.
    """
    out = joints.copy()
    middle = (low + high) / 2.0
    for axis in robot.winding():
        out[:, axis] += 360.0 * np.round((middle[:, axis] - out[:, axis]) / 360.0)
    if robot.arm.spherical:
        off = (out < low) | (out > high)
        rows = np.flatnonzero((np.abs(out[:, 4]) < MOST_SHIFT) & (off[:, 3] | off[:, 5]))
        out[rows, 3], out[rows, 5] = split_wrist_roll(
            out[rows, 3] + robot.arm.rolls * out[rows, 5],
            out[rows, 3],
            (low[rows], high[rows]),
            robot.arm.rolls,
        )
    return np.clip(out, low, high)


def split_wrist_roll(
    roll: Floats, held: Floats, limits: tuple[Floats, Floats], rolls: float
) -> tuple[Floats, Floats]:
    """Axes 4 and 6 (k,) deg in line that turn the tool by `roll` (k,) together, axis 4 as near to
    `held` (k,) as the limits of all axes, (k, 6) each, allow, or beyond them by as little.

    rolls: 1 where both axes count to the same side in line, else -1.
    """
    low, high = limits
    six = np.sort(rolls * np.stack([low[:, 5], high[:, 5]]), axis=0)
    turns = np.round(roll / 360.0)
    best = np.full(len(roll), np.inf)
    four, whole = held.copy(), roll.copy()
    for turn in range(-4, 5):
        wound = roll + 360.0 * (turn - turns)
        least = np.maximum(low[:, 3], wound - six[1])
        most = np.minimum(high[:, 3], wound - six[0])
        there = np.clip(held, np.minimum(least, most), np.maximum(least, most))
        away = 1e6 * np.maximum(least - most, 0.0) + np.abs(there - held)
        nearer = away < best
        best = np.where(nearer, away, best)
        four, whole = np.where(nearer, there, four), np.where(nearer, wound, whole)
    return four, rolls * (whole - four)


def _beside(
    robot: Robot, wanted: RoundedPoses, branches: Rows, limits: tuple[Floats, Floats]
) -> Floats:
    """(k, a) the joints of a pose beside each of k whose wrist is over axis 1, those of several
    that meet it best between the limits.
    """
    k, many = len(branches), len(_DIRECTIONS_AROUND)
    far = wanted.rounding[:, :1] * np.where(np.arange(many) % 2, 0.5, 1.0)
    off = np.stack(
        [far * np.cos(_DIRECTIONS_AROUND), far * np.sin(_DIRECTIONS_AROUND), 0.0 * far], axis=-1
    )
    p = wanted.positions[:, None] + off
    found, _ = robot.solve(p.reshape(-1, 3), np.repeat(wanted.quaternions, many, axis=0))
    each = np.repeat(branches, many)
    joints = found[:, each, np.arange(k * many)].T
    low, high = (np.repeat(limit, many, axis=0) for limit in limits)
    tried = _placed_within(robot, joints, low, high).reshape(k, many, -1)
    costs = (wanted.missing(robot, tried, np.arange(k)) ** 2).sum(axis=2)
    return np.asarray(tried[np.arange(k), costs.argmin(axis=1)])
