"""How near a way of the tool comes to the contours that it must not cut into."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Points
from assistant.sources.contours.flat import CHORD_TOLERANCE, Piece, polyline
from assistant.sources.contours.offsets import OffsetRing, contour_polygon

LEAST_DISTANCE_PART: Final = 0.5
"""Part of an offset that a way has to keep away at least, however large the tolerance is."""


@dataclass(frozen=True, slots=True)
class ClearRoom:
    """contours: their lines by what they are known by; tree: of the same lines."""

    keys: tuple[tuple[int, int], ...]
    tree: Any
    tolerance: float

    @staticmethod
    def of(
        contours: Sequence[tuple[tuple[int, int], Sequence[Piece], bool]], tolerance: float
    ) -> ClearRoom:
        """Contours by their keys, as (key, pieces, whether closed)."""
        import shapely

        lines = []
        for _, pieces, closed in contours:
            points = polyline(pieces, tolerance * CHORD_TOLERANCE, closed=closed)
            lines.append(
                shapely.LineString(np.concatenate([points, points[:1]] if closed else [points]))
            )
        return ClearRoom(tuple(key for key, *_ in contours), shapely.STRtree(lines), tolerance)

    def nearest(self, points: Points) -> Iterator[tuple[Points, tuple[int, int], float]]:
        """For each point (m, 3) the contour that is nearest to it, and the mm between them."""
        import shapely

        if self.keys and len(points):
            made = shapely.points(points[:, :2])
            rows = self.tree.nearest(made)
            far = shapely.distance(made, self.tree.geometries[rows])
            for point, row, apart in zip(points, rows.tolist(), far.tolist(), strict=True):
                yield point, self.keys[row], apart

    def too_near(self, ring: OffsetRing, offset: float) -> float | None:
        """The mm that a way beside a contour comes near to any; None if that is enough."""
        line = self._line(ring.pieces)
        away = self._away(offset)
        rows = self.tree.query(line, predicate="dwithin", distance=away)
        apart = [line.distance(self.tree.geometries[row]) for row in rows.tolist()]
        return min(apart) if apart else None

    def beside(
        self, key: tuple[int, int], own: OffsetRing, offset: float
    ) -> Callable[[Sequence[Piece]], bool]:
        """Whether pieces have room that lead onto a contour or off it. own: as it was drawn."""
        if offset > 0.0:
            away = self._away(offset)
            return lambda pieces: (
                not len(self.tree.query(self._line(pieces), predicate="dwithin", distance=away))
            )
        kept = self._kept(own)
        number = self.keys.index(key)

        def free(pieces: Sequence[Piece]) -> bool:
            line = self._line(pieces)
            rows = self.tree.query(line, predicate="dwithin", distance=self.tolerance)
            return set(rows.tolist()) <= {number} and kept(line)

        return free

    def away(self, offset: float) -> Callable[[Vector], bool]:
        """True if a point is clearly farther from all contours than the offset."""
        import shapely

        far = offset + 2.0 * self.tolerance
        return lambda point: (
            not len(self.tree.query(shapely.Point(point[:2]), predicate="dwithin", distance=far))
        )

    def _kept(self, own: OffsetRing) -> Callable[[Any], bool]:
        """Whether a line that begins or ends on a contour stays on the side of the tool."""
        import shapely

        if own.closed:
            around = contour_polygon(own.pieces, self.tolerance)
            if own.encloses:
                inner = around.buffer(-self.tolerance)
                return lambda line: not line.intersects(inner)
            outer = around.buffer(self.tolerance)
            return lambda line: bool(line.within(outer))
        drawn = self._line(own.pieces)
        ends = shapely.MultiPoint([own.pieces[0].start[:2], own.pieces[-1].end[:2]])
        away = drawn.difference(ends.buffer(2.0 * self.tolerance))
        return lambda line: not line.intersects(away)

    def _away(self, offset: float) -> float:
        return max(offset - self.tolerance, LEAST_DISTANCE_PART * offset)

    def _line(self, pieces: Sequence[Piece]) -> Any:
        import shapely

        return shapely.LineString(polyline(pieces, self.tolerance * CHORD_TOLERANCE, closed=False))
