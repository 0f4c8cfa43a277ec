"""Poses as controllers print them, and the joints that come nearest to one: own arithmetic."""

from __future__ import annotations

import numpy as np

from assistant import robots
from assistant.base import rotations
from assistant.program.motion import Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Follow
from assistant.robots.arms.closed_form import from_ab, to_ab


def printed(arm, positions, quaternions):
    """As RAPID or MELFA-BASIC states them, and by how many mm and degrees that moves a pose."""
    p = np.round(positions, 2)
    place = 0.005 * np.sqrt(3.0)
    if arm.counts == "quadrants":
        q = np.round(quaternions, 6)
        return p, q / np.linalg.norm(q, axis=1, keepdims=True), (place, np.degrees(2e-6))
    turn = 0.005 * np.sqrt(5.0)
    if arm.five_axis:
        return p, from_ab(p, np.round(to_ab(positions, quaternions), 2)), (place, turn)
    return p, rotations.from_euler(np.round(rotations.to_euler(quaternions), 2)), (place, turn)


def solve_program(arm, positions, quaternions, configurations, kinds=Kind.JOINT):
    path = Path.of(
        "seam",
        positions,
        quaternions,
        configurations=configurations,
        kinds=np.full(len(positions), kinds, dtype=np.uint8) if np.isscalar(kinds) else kinds,
        speeds=[Speed(100.0)],
    )
    return robots.solve_program(Program("p", (Procedure("main", (Follow(path),)),)), arm)


def missed(arm, joints, positions, quaternions, rounding):
    """(n, 6) what joints (n, a) miss poses by, in shares of the rounding."""
    p, q = arm.fk(joints)
    difference = rotations.multiply(quaternions, rotations.conjugate(q))
    difference *= np.where(difference[:, :1] < 0.0, -1.0, 1.0)
    turn = 2.0 * np.degrees(difference[:, 1:])  # of small angles
    return np.hstack([(positions - p) / rounding[0], turn / rounding[1]])


def nearest(arm, joints, positions, quaternions, rounding):
    """(n,) by what joints inside the limits, near to joints (n, a), miss poses at least.

    The larger of both shares of the rounding. Beside a straight wrist axes 4 and 6 are tried all
    round.
    """
    rows = np.flatnonzero(np.abs(joints[:, 4]) < 5.0) if arm.arm.spherical else np.zeros(0, int)
    round_ = np.arange(-180.0, 180.0, 20.0)[:, None, None] * np.array([0, 0, 0, 1.0, 0, -1.0])
    turned = (joints[rows] + round_).reshape(-1, joints.shape[1]) if len(rows) else joints[:0]
    turned = turned - 360.0 * np.round((turned - arm.limits.mean(axis=1)) / 360.0)
    again = np.tile(rows, len(turned) // max(len(rows), 1))
    which = np.concatenate([np.arange(len(joints)), again])
    tried = np.vstack([joints, turned])
    found = _nearest(arm, tried, positions[which], quaternions[which], rounding)
    best = np.full(len(joints), np.inf)
    np.minimum.at(best, which, found)
    return best


def _nearest(arm, joints, positions, quaternions, rounding):
    """Steps of Gauss and Newton, put back between the limits, the axes that leave them held."""
    low, high = arm.limits.T
    found = np.clip(joints, low, high)
    every = missed(arm, found, positions, quaternions, rounding)
    damping, busy = np.full(len(joints), 1e-3), np.arange(len(joints))
    for _ in range(200):
        here, off, p, q = found[busy], every[busy], positions[busy], quaternions[busy]
        slopes = np.stack(
            [
                (missed(arm, here + step, p, q, rounding) - off) / 1e-5
                for step in 1e-5 * np.eye(len(low))
            ],
            axis=2,
        )
        pull = -np.einsum("nka,nk->na", slopes, off)
        held = ((here <= low) & (pull < 0.0)) | ((here >= high) & (pull > 0.0))
        free = np.where(held[:, None], 0.0, slopes)
        normal = np.einsum("nka,nkb->nab", free, free)
        own = np.einsum("naa->na", normal)
        normal += np.eye(len(low)) * (damping[busy, None] * own + 1e-9)[:, None]
        step = np.linalg.solve(normal, -np.einsum("nka,nk->na", free, off)[..., None])[..., 0]
        tried = np.clip(here + step, low, high)
        there = missed(arm, tried, p, q, rounding)
        before, after = (off**2).sum(axis=1), (there**2).sum(axis=1)
        better = after < before
        found[busy] = np.where(better[:, None], tried, here)
        every[busy] = np.where(better[:, None], there, off)
        damping[busy] *= np.where(better, 0.2, 5.0)
        still = (damping[busy] < 1e6) & ~(better & (after > (1.0 - 1e-5) * before))
        busy = busy[still]
        if not len(busy):
            break
    off = every
    place, turn = (np.linalg.norm(part, axis=1) for part in (off[:, :3], off[:, 3:]))
    return np.maximum(place, turn)
