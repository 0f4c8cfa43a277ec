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

from assistant.program.arrays import Floats, Truths

ROUNDS: Final = 6
"""Of leaving out what does not lie on the cone."""
LEAST: Final = 8
"""Rays of an outline from which a cone is told."""
SCATTER: Final = 3.0
"""Times the usual distance from the cone beyond which a ray is not of the outline."""


@dataclass(frozen=True, slots=True, eq=False)
class Cone:
    """direction: (3,) unit vector to the centre. angle: α in radians.

    on: (n,) which rays lie on it. scatter: radians, root mean square of those.
    """

    direction: Floats
    angle: float
    on: Truths
    scatter: float


def cone_of(rays: Floats, least_scatter: float) -> Cone | None:
    """The cone of unit rays (n, 3), or None where they tell none.

    least_scatter: radians that a ray may always be off, before it is left out.
    """
    on = np.isfinite(rays).all(axis=1)
    normal: Floats = np.zeros(3)
    off: Floats = np.full(len(rays), np.nan)
    for _ in range(ROUNDS):
        if on.sum() < LEAST:
            return None
        normal = np.asarray(np.linalg.lstsq(rays[on], np.ones(on.sum()), rcond=None)[0], float)
        length = float(np.linalg.norm(normal))
        if not length > 1.0:
            return None
        angle = float(np.arccos(1.0 / length))
        off = np.arccos(np.clip(rays @ normal / length, -1.0, 1.0)) - angle
        usual = 1.4826 * float(np.nanmedian(np.abs(off[np.isfinite(off)])))
        keeps = np.abs(off) <= max(SCATTER * usual, least_scatter)
        if (keeps == on).all():
            break
        on = keeps
    scatter = float(np.sqrt(np.mean(off[on] ** 2)))
    return Cone(normal / length, angle, np.asarray(on), scatter)
