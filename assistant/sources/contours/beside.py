"""One contour, and the ways of the tool beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.diagnostics import Diagnostic, Rule
from assistant.program.settings_tables import shown
from assistant.sources.contours import shaping_rules as rules
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import Points
from assistant.sources.contours.flat import (
    CHORD_TOLERANCE,
    Piece,
    PlanePoints,
    height_range,
    lowered,
    places_after_start,
    polyline,
    signed_area,
    started_at,
)
from assistant.sources.contours.leads import starts_of, starts_with_room
from assistant.sources.contours.offsets import (
    OffsetRing,
    corner_joints,
    crosses_itself,
    offset_closed,
    offset_open,
)
from assistant.sources.contours.room import ClearRoom
from assistant.sources.process.shaping import Shaping

if TYPE_CHECKING:
    from shapely import STRtree

NARROW_OFFSETS: Final = 2.0
"""Offsets from a place of a contour to the tool's centre over which the place is left out; in a
right angle it is 1.41, at 60 degrees 2."""

RingRounds = tuple[tuple[OffsetRing, ...], ...]


@dataclass(slots=True)
class ContourOffsets:
    """pieces: of the contour, seen along the tool. room: of all contours on which sides matter.
    depth: how many of them are around it.
    """

    key: tuple[int, int]
    contour: Contour
    pieces: tuple[Piece, ...]
    shaping: Shaping
    tolerance: float
    room: ClearRoom | None
    depth: int
    findings: list[Diagnostic] = field(default_factory=list)

    @property
    def sided(self) -> bool:
        return self.shaping.sided if self.contour.closed else self.shaping.sided_open

    @property
    def fixed(self) -> bool:
        """Of an open contour: whether it is not to be run backwards."""
        return self.sided or self.shaping.way_round == "drawn"

    @property
    def anticlockwise(self) -> bool:
        return _anticlockwise(self.pieces, self.tolerance)

    @property
    def outside(self) -> bool:
        """Of a closed contour: whether the tool is outside of it."""
        side = self.shaping.side
        if side == "nesting":
            return self.depth % 2 == 0
        if side in ("left", "right"):
            return (side == "right") == self.anticlockwise
        return side == "outside"

    def rounds(self, mark: Points | None) -> RingRounds:
        """The ways for each allowance; none if the contour is left out, as the findings tell."""
        shaping = self.shaping
        level = 0.0
        if self.sided or shaping.leads:
            low, high = height_range(self.pieces)
            level = 0.5 * (low + high)
            if high - low > self.tolerance:
                return self._none(rules.NOT_FLAT, apart=high - low)
        if self.sided and not self.contour.closed and shaping.side not in ("left", "right"):
            return self._none(rules.OPEN_CONTOUR)
        closed = self.sided and self.contour.closed
        if closed and crosses_itself(self.pieces, self.tolerance):
            return self._none(rules.CROSSES_ITSELF)
        made = []
        for allowance in shaping.allowances:
            offset = shaping.offset + allowance
            rings = [self._turned(ring) for ring in self._rings(offset, level)]
            if not rings:
                last = allowance == shaping.allowances[-1]
                what = "it is" if last else "this way around it is"
                self._say(rules.OFFSET_COLLAPSED, offset=offset, what=what)
                continue
            made.append(rings)
        if not rings:
            return ()
        self._tell_what_is_left(made[-1])
        placed = tuple(tuple(self._placed(ring, mark) for ring in rings) for rings in made)
        return () if any(f.severity == "error" for f in self.findings) else placed

    def _rings(self, offset: float, level: float) -> list[OffsetRing]:
        """The ways at an offset, each as it comes."""
        closed, left = self.contour.closed, self.shaping.side == "left"
        if not offset:
            places = corner_joints(self.pieces, closed=closed)
            encloses = closed and self.outside
            rings = [OffsetRing(self.pieces, closed, encloses, places)]
        elif closed:
            begin = self.pieces[0].start
            found = offset_closed(self.pieces, offset, self.tolerance, outside=self.outside)
            rings = [ring.from_near(begin) for ring in found]
        else:
            rings = offset_open(self.pieces, offset, self.tolerance, left=left)
        given = self.contour.curves[0]
        made = []
        for ring in rings:
            pieces = lowered(ring.pieces, -level) if offset else ring.pieces
            named = (replace(p, layer=given.layer, handle=given.handle) for p in pieces)
            hand = left
            if closed:
                hand = _anticlockwise(pieces, self.tolerance) != ring.encloses
            made.append(replace(ring, pieces=tuple(named), left=hand))
        return made

    def _turned(self, ring: OffsetRing) -> OffsetRing:
        """The way round that the process wants."""
        way = self.shaping.way_round
        if way in ("climb", "conventional") and self.sided:
            return ring if ring.left == (way == "climb") else ring.back()
        if not ring.closed:
            return ring
        wanted = ring.left
        if way in ("clockwise", "anticlockwise"):
            wanted = (way == "anticlockwise") != ring.encloses
        elif self.sided:
            wanted = self.anticlockwise != self.outside
        return ring if ring.left == wanted else ring.back()

    def _placed(self, ring: OffsetRing, mark: Points | None) -> OffsetRing:
        """With its starts, the first of which it starts at; where leads have no room it is told."""
        shaping, length = self.shaping, ring.length
        if ring.closed and shaping.overlap > length:
            self._say(rules.OVERLAP_TOO_LONG, overlap=shaping.overlap, length=length)
            return ring
        starts = starts_of(ring, shaping, mark) if ring.closed else ((0, 0.0),)
        if self.sided and self.room is not None:
            near = self.room.too_near(ring, shaping.offset) if shaping.offset else None
            if near is not None:
                self._say(rules.CUTS_INTO, apart=near, offset=shaping.offset)
                return ring
            own = OffsetRing(self.pieces, ring.closed, ring.closed and self.outside)
            free = self.room.beside(self.key, own, shaping.offset)
            away = self.room.away(shaping.offset)
            starts = starts_with_room(ring, starts, shaping, free, away)
        if not starts:
            places = {"corner": "its corners", "longest": "the middle of its longest side"}
            places["point"] = "its mark"
            where = places.get(shaping.start) if ring.closed else None
            self._say(
                rules.NO_ROOM,
                where=f" that starts at {where}" if where else "",
                cure=', or start = "nearest"' if where else "",
            )
            return ring
        if not ring.closed:
            return ring
        first, rest = starts[0], places_after_start(starts, ring.pieces, *starts[0])
        return replace(ring, pieces=started_at(ring.pieces, *first), starts=rest)

    def _tell_what_is_left(self, rings: Sequence[OffsetRing]) -> None:
        """Where the tool, on its last way, does not come to."""
        import shapely

        offset = self.shaping.offset + self.shaping.allowances[-1]
        if not offset:
            return
        if len(rings) > 1:
            self._say(rules.OFFSET_SPLIT, offset=offset, count=len(rings))
            return
        bare = rings[0].bare
        if bare is None or not len(bare):
            return
        way = _drawn_outline(
            rings[0].pieces, self.tolerance * CHORD_TOLERANCE, closed=rings[0].closed
        )
        ways = shapely.STRtree(shapely.linestrings(np.stack([way[:-1], way[1:]], axis=1)))
        points, enough = shapely.points(bare), NARROW_OFFSETS * offset + self.tolerance
        far = np.ones(len(points), dtype=np.bool_)
        far[ways.query(points, predicate="dwithin", distance=enough)[0]] = False
        if far.any():
            left = _largest_distance(ways, bare[far])
            self._say(rules.MATERIAL_LEFT, left=left - offset, offset=offset)

    def _none(self, rule: Rule, **fields: Any) -> RingRounds:
        self._say(rule, **fields)
        return ()

    def _say(self, rule: Rule, **fields: Any) -> None:
        handle = next((c.handle for c in self.contour.curves if c.handle), "")
        place = f"entity {handle}" if handle else None
        self.findings.append(rule(place=place, layer=shown(self.contour.layer), **fields))


def _largest_distance(ways: STRtree, points: PlanePoints) -> float:
    """Return the largest distance in mm from points (k, 2) to the nearest way.

    It changes from point to point by at most their distance, so points near one that is close to a
    way need not be measured.
    """
    import shapely

    most, bounds, every = 0.0, np.full(len(points), np.inf), np.arange(len(points))
    for stride in (16, 4, 1):
        asked = every[::stride]
        asked = asked[bounds[asked] > most]
        if len(asked):
            _, apart = ways.query_nearest(
                shapely.points(points[asked]), all_matches=False, return_distance=True
            )
            bounds[asked], most = apart, max(most, float(np.max(apart)))
        before = every // stride * stride
        for near in (before, np.minimum(before + stride, before[-1])):
            reach = bounds[near] + np.linalg.norm(points - points[near], axis=1)
            bounds = np.minimum(bounds, reach)
    return most


def _anticlockwise(pieces: Sequence[Piece], tolerance: float) -> bool:
    return signed_area(polyline(pieces, tolerance, closed=True)) > 0.0


def _drawn_outline(pieces: Sequence[Piece], off: float, *, closed: bool) -> Points:
    points = polyline(pieces, off, closed=closed)
    return np.concatenate([points, points[:1]]) if closed else points
