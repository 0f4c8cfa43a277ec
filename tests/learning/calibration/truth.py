"""Arms that are a little off, by Denavit and Hartenberg's matrices written out here: no code of
ours says where they are.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

QUARTER = np.pi / 2.0
NOMINAL = {
    # d1, a1, a2, a3, d4, d6 and the angles of a standing arm where the maker's are 0
    "rv-2aj": ({"d1": 300.0, "a2": 250.0, "d4": 160.0, "d6": 72.0}, [0.0] * 5),
    "irb1200-5-0.9": (
        {"d1": 399.1, "a1": 0.0, "a2": 448.0, "a3": -42.0, "d4": 451.0, "d6": 82.0},
        [0.0, 0.0, 90.0, 0.0, 0.0, 0.0],
    ),
}
SPANS = {
    "rv-2aj": [(-120, 120), (-40, 90), (-20, 110), (-80, 80), (-170, 170)],
    "irb1200-5-0.9": [(-120, 120), (-50, 80), (-90, 50), (-150, 150), (-100, 100), (-180, 180)],
}


@dataclass(frozen=True)
class Truth:
    """lengths: off by mm. zeros: off by degrees. tilts: degrees by which each twist is off.
    base: (4, 4), tool: (4, 4) mm.
    """

    name: str
    lengths: dict[str, float] = field(default_factory=dict)
    zeros: np.ndarray = field(default_factory=lambda: np.zeros(6))
    tilts: np.ndarray = field(default_factory=lambda: np.zeros(6))
    base: np.ndarray = field(default_factory=lambda: np.eye(4))
    tool: np.ndarray = field(default_factory=lambda: np.eye(4))

    def flange(self, joints):
        """Joints (n, a) degrees → (n, 4, 4) mm, of the base."""
        nominal, zero = NOMINAL[self.name]
        one = {key: value + self.lengths.get(key, 0.0) for key, value in nominal.items()}
        count = len(zero)
        angles = np.radians(joints + np.array(zero) + self.zeros[:count])
        tilt = np.radians(self.tilts)
        if count == 5:
            rows = [
                (0.0, one["d1"], -QUARTER, 0.0),
                (one["a2"], 0.0, 0.0, -QUARTER),
                (one["d4"], 0.0, 0.0, 0.0),
                (0.0, 0.0, QUARTER, QUARTER),
                (0.0, one["d6"], 0.0, 0.0),
            ]
        else:
            rows = [
                (one["a1"], one["d1"], -QUARTER, 0.0),
                (one["a2"], 0.0, 0.0, -QUARTER),
                (one["a3"], 0.0, QUARTER, QUARTER),
                (0.0, one["d4"], -QUARTER, 0.0),
                (0.0, 0.0, QUARTER, 0.0),
                (0.0, one["d6"], 0.0, 0.0),
            ]
        pose = np.tile(np.eye(4), (len(joints), 1, 1))
        for i, (a, d, alpha, theta) in enumerate(rows):
            pose = pose @ denavit(angles[:, i] + theta, a, d, alpha + tilt[i])
        return pose

    def measured(self, joints):
        """(n, 4, 4) of the tool in the measuring frame."""
        return self.base @ self.flange(joints) @ self.tool


def denavit(theta, a, d, alpha):
    """(n, 4, 4) of Rz(theta)·Tz(d)·Tx(a)·Rx(alpha)."""
    c, s = np.cos(theta), np.sin(theta)
    ca, sa = np.cos(alpha), np.sin(alpha)
    out = np.zeros((len(theta), 4, 4))
    out[:, 0] = np.stack([c, -s * ca, s * sa, a * c], axis=1)
    out[:, 1] = np.stack([s, c * ca, -c * sa, a * s], axis=1)
    out[:, 2, 1], out[:, 2, 2], out[:, 2, 3], out[:, 3, 3] = sa, ca, d, 1.0
    return out


def turned(axis, degrees):
    """(4, 4) by Rodrigues' formula."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    out = np.eye(4)
    out[:3, :3] += np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
    return out


def placed(position, axis=(0, 0, 1), degrees=0.0):
    """(4, 4)."""
    out = turned(axis, degrees)
    out[:3, 3] = position
    return out


def drawn(name, seed, *, tilts=0.0):
    """An arm with lengths off by up to 2 mm and zeros by up to 1 degree, somewhere."""
    random = np.random.default_rng(seed)
    lengths = {key: random.uniform(-2.0, 2.0) for key in NOMINAL[name][0]}
    return Truth(
        name,
        lengths,
        random.uniform(-1.0, 1.0, 6),
        random.uniform(-tilts, tilts, 6),
        placed(random.uniform(-1500, 1500, 3), random.normal(size=3), random.uniform(0, 180)),
        placed([*random.uniform(20, 60, 2), random.uniform(60, 150)], random.normal(size=3), 50.0),
    )


def joints_of(name, count, seed=0):
    low, high = np.array(SPANS[name], dtype=float).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


def points_of(truth, joints, noise=0.05, seed=1):
    """(n, 3) mm with noise along each axis."""
    points = truth.measured(joints)[:, :3, 3]
    return points + np.random.default_rng(seed).normal(0.0, noise, points.shape)


def quaternions_of(truth, joints, noise=0.0, seed=2):
    """(n, 4), turned by noise in degrees about each axis."""
    random = np.random.default_rng(seed)
    out = []
    for pose in truth.measured(joints):
        turn = random.normal(0.0, max(noise, 1e-12), 3)
        out.append(quaternion((turned(turn, np.linalg.norm(turn)) @ pose)[:3, :3]))
    return np.array(out)


def quaternion(matrix):
    """Of a rotation matrix, as the eigenvector of Bar-Itzhack (2000)."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)],
        ]
    )
    x, y, z, w = np.linalg.eigh(k + np.tril(k, -1).T)[1][:, -1]
    return np.array([w, x, y, z])


__all__ = ["Truth", "drawn", "joints_of", "placed", "points_of", "quaternions_of"]
