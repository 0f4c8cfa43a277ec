"""Contour moments: how large a shape is, where its middle is, how it is stretched and turned."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats

if TYPE_CHECKING:
    from types import ModuleType

ROUND_DIFFERENCE: Final = 0.03
"""Difference of the two radii of gyration, as a part of the larger, below which no direction is
told by them."""


@dataclass(frozen=True, slots=True, eq=False)
class ContourMoments:
    """Of a shape in a plane. area: mm²; middle: (2,) mm; radii: of gyration along both main axes,
    the longer one first; turn: radians of that axis, in [0, π); hu: the seven invariants of Hu
    (1962), which neither place, turn nor size change.
    """

    area: float
    middle: Floats
    radii: tuple[float, float]
    turn: float
    hu: Floats

    @property
    def round(self) -> bool:
        return self.radii[0] - self.radii[1] < ROUND_DIFFERENCE * self.radii[0]

    def like(self, other: ContourMoments, part: float = 0.06) -> bool:
        """Whether size and stretch differ by that part at most."""
        if abs(self.area - other.area) > 2.0 * part * other.area:
            return False
        pairs = zip(self.radii, other.radii, strict=True)
        return all(abs(one - two) <= part * two for one, two in pairs)


def contour_moments(cv: ModuleType, rings: tuple[Floats, ...]) -> ContourMoments | None:
    """Of closed polygons (n, 2), the first about the shape, the others about its holes.

    By Green's formula over the polygons; None of a shape without area.
    """
    total: dict[str, float] = {}
    origin = rings[0].mean(axis=0)
    for number, ring in enumerate(rings):
        sign = -1.0 if number else 1.0
        for key, value in cv.moments((ring - origin).astype(np.float32)[:, None]).items():
            if key.startswith("m"):
                # OpenCV gives a polygon's area without the sign of its direction.
                total[key] = total.get(key, 0.0) + sign * value
    area = total["m00"]
    if area <= 0.0:
        return None
    x, y = total["m10"] / area, total["m01"] / area
    xx = total["m20"] / area - x * x
    yy = total["m02"] / area - y * y
    xy = total["m11"] / area - x * y
    (low, high), axes = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
    turn = float(np.arctan2(axes[1, 1], axes[0, 1]) % np.pi)
    radii = (float(np.sqrt(max(high, 0.0))), float(np.sqrt(max(low, 0.0))))
    central = _central_moments(total, x, y)
    hu = np.asarray(cv.HuMoments({**total, **central})).ravel()
    return ContourMoments(area, origin + np.array([x, y]), radii, turn, hu)


def _central_moments(m: dict[str, float], x: float, y: float) -> dict[str, float]:
    """Central and normalised moments up to the third order, as OpenCV names them."""
    mu = {
        "mu20": m["m20"] - x * m["m10"],
        "mu11": m["m11"] - x * m["m01"],
        "mu02": m["m02"] - y * m["m01"],
        "mu30": m["m30"] - 3 * x * m["m20"] + 2 * x * x * m["m10"],
        "mu21": m["m21"] - 2 * x * m["m11"] - y * m["m20"] + 2 * x * x * m["m01"],
        "mu12": m["m12"] - 2 * y * m["m11"] - x * m["m02"] + 2 * y * y * m["m10"],
        "mu03": m["m03"] - 3 * y * m["m02"] + 2 * y * y * m["m01"],
    }
    nu = {
        "n" + key[1:]: value / m["m00"] ** (1.0 + (int(key[2]) + int(key[3])) / 2.0)
        for key, value in mu.items()
    }
    return {**mu, **nu}
