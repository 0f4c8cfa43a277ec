"""The cone in which a sphere is seen: from the rays of its outline to the ray of its centre.

The outline of a sphere in a picture is nearly an ellipse, and the middle of that ellipse is not
where the sphere's centre is seen: it lies farther from the middle of the picture, by up to half
a pixel for a ball of 40 mm at 1 m. The rays of the outline form a round cone about the ray of the
centre, whatever the lens does. For a ray u of it and the direction d of the centre, u · d = cos α,
where sin α = radius / distance: with n = d / cos α that is linear, u · n = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.base.arrays import Floats, Truths

CONE_ROUNDS: Final = 6
"""Of leaving out what does not lie on the cone."""
FEWEST_RAYS: Final = 8
"""Rays of an outline from which a cone is told."""
CONE_SAMPLES: Final = 120
"""Cones through three rays each that are tried."""


@dataclass(frozen=True, slots=True, eq=False)
class Cone:
    """direction: (3,) unit vector to the centre. angle: α in radians.

    on: (n,) which rays lie on it. scatter: radians, root mean square of those.
    """

    direction: Floats
    angle: float
    on: Truths
    scatter: float


def fit_cone(rays: Floats, off: float) -> Cone | None:
    """The cone that most of some unit rays (n, 3) lie on, or None where they tell none.

    off: radians that a ray of it may be off. Where half of a ball is hidden, the others are those
    of what hides it: of cones through three rays each the one is taken that most others lie on
    (Fischler and Bolles, 1981; Torr and Zisserman, MLESAC, 2000, for how they are counted), and
    then made exact by all that do.
    """
    good = np.flatnonzero(np.isfinite(rays).all(axis=1))
    if len(good) < FEWEST_RAYS:
        return None
    normal = _best_sampled_cone(rays[good], off)
    on = np.zeros(len(rays), dtype=bool)
    away: Floats = np.full(len(rays), np.nan)
    for _ in range(CONE_ROUNDS):
        if not np.linalg.norm(normal) > 1.0:
            return None
        away = _angles_outside(rays, normal[None])[0]
        before, on = on, np.abs(away) <= off
        if on.sum() < FEWEST_RAYS:
            return None
        if (on == before).all():
            break
        normal = np.asarray(np.linalg.lstsq(rays[on], np.ones(on.sum()), rcond=None)[0], float)
    length = float(np.linalg.norm(normal))
    scatter = float(np.sqrt(np.mean(away[on] ** 2)))
    return Cone(normal / length, float(np.arccos(1.0 / length)), np.asarray(on), scatter)


def _angles_outside(rays: Floats, normals: Floats) -> Floats:
    """(k, n) radians by which rays (n, 3) are outside of cones (k, 3)."""
    lengths = np.linalg.norm(normals, axis=1)[:, None]
    cosines = np.clip(normals @ rays.T / lengths, -1.0, 1.0)
    return np.asarray(np.arccos(cosines) - np.arccos(1.0 / lengths))


def _best_sampled_cone(rays: Floats, off: float) -> Floats:
    """The cone through three of some rays (n, 3) that the others are nearest to."""
    chosen = (
        np.random.default_rng(0).random((CONE_SAMPLES, len(rays))).argpartition(2, axis=1)[:, :3]
    )
    three = rays[chosen]
    with np.errstate(divide="ignore", invalid="ignore"):
        sound = np.abs(np.linalg.det(three)) > 1e-12
        normals = np.zeros((CONE_SAMPLES, 3))
        normals[sound] = np.linalg.solve(three[sound], np.ones((sound.sum(), 3, 1)))[..., 0]
        sound &= np.linalg.norm(normals, axis=1) > 1.0
    if not sound.any():
        return np.zeros(3)
    missed = np.minimum(_angles_outside(rays, normals[sound]) ** 2, off**2).sum(axis=1)
    return np.asarray(normals[sound][np.argmin(missed)])
