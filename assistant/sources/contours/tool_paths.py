"""Tool paths beside the contours of layers: sides, offsets, starts, leads, overlaps and passes.

Contours are seen along the tool (`ToolView`). A contour that its layer does not shape stays as it
is. `_ContourOffsets` finds the paths beside one contour; leads go onto the contour and off it at a
start where both have room.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, info, warning
from assistant.program.geometry import Vector
from assistant.program.settings_tables import shown
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import GroupNesting, holders, nesting_depths
from assistant.sources.contours.curves import (
    CHORD_TOLERANCE,
    Arc,
    Line,
    Piece,
    PlanePoints,
    Points,
    cross,
    first_stretch,
    height_range,
    lowered,
    places_after_start,
    polyline,
    signed_area,
    started_at,
    tangent,
    vector,
)
from assistant.sources.contours.moves import ContourPieces, as_pieces, level_x_axis
from assistant.sources.contours.offset_bands import SAME_POINT
from assistant.sources.contours.offsets import (
    ClearRoom,
    OffsetRing,
    corner_joints,
    crosses_itself,
    offset_closed,
    offset_open,
)
from assistant.sources.process import Layer, Lead, Shaping

if TYPE_CHECKING:
    from shapely import STRtree


_MOST_STARTS_TRIED: Final = 24
"""Largest number of points of a contour that are tried as its start."""
_LEAD_QUARTERS: Final = (0.0, 0.25, 0.5, 0.75)


def lead_in(lead: Lead, pieces: Sequence[Piece], *, left: bool) -> Piece:
    """Onto the start of the pieces, from the left of them or from the right."""
    return _lead_piece(lead, pieces[0], 0.0, left=left, into=True)


def lead_out(lead: Lead, pieces: Sequence[Piece], *, left: bool) -> Piece:
    """From the end of the pieces, to the left of them or to the right."""
    return _lead_piece(lead, pieces[-1], 1.0, left=left, into=False)


def _lead_piece(lead: Lead, piece: Piece, part: float, *, left: bool, into: bool) -> Piece:
    hand, way = (1.0 if left else -1.0), (-1.0 if into else 1.0)
    at = np.asarray(piece.end if part else piece.start)
    along = np.append(tangent(piece, part), 0.0)
    across = hand * np.array([-along[1], along[0], 0.0])
    if lead.kind == "line":
        angle = np.radians(lead.angle)
        away = at + lead.size * (way * np.cos(angle) * along + np.sin(angle) * across)
        ends = vector(at), vector(away)
        start, end = reversed(ends) if into else ends
        return Line(start, end, piece.layer, piece.handle)
    centre, up = at + lead.size * across, (0.0, 0.0, way * hand)
    arc = Arc.about(centre, up, at, lead.angle, piece.layer, piece.handle)
    return arc.reversed() if into else arc


def _with_leads(ring: OffsetRing, shaping: Shaping) -> tuple[Piece, ...]:
    """The pieces of a ring from its start on, with overlap and leads."""
    pieces = ring.pieces
    if ring.closed and shaping.overlap:
        pieces = (*pieces, *first_stretch(pieces, shaping.overlap))
    into = [lead_in(shaping.lead_in, pieces, left=ring.left)] if shaping.lead_in else []
    out = [lead_out(shaping.lead_out, pieces, left=ring.left)] if shaping.lead_out else []
    return (*into, *pieces, *out)


def _starts_with_room(
    ring: OffsetRing,
    starts: Sequence[tuple[int, float]],
    shaping: Shaping,
    room: Callable[[Sequence[Piece]], bool],
    away: Callable[[Vector], bool],
) -> tuple[tuple[int, float], ...]:
    """Those starts at which the leads have room, of them those whose leads end away if there are.

    room: of one piece that leads in or out. away: of the outer end of one, farther from all
    contours than the way itself.
    """
    if not shaping.leads:
        return tuple(starts)
    found, better = [], []
    for at, part in starts:
        made = _with_leads(replace(ring, pieces=started_at(ring.pieces, at, part)), shaping)
        ways = [made[:1]] if shaping.lead_in else []
        ways += [made[-1:]] if shaping.lead_out else []
        if all(room(way) for way in ways):
            found.append((at, part))
            ends = [made[0].start] if shaping.lead_in else []
            ends += [made[-1].end] if shaping.lead_out else []
            if all(away(end) for end in ends):
                better.append((at, part))
    return tuple(better or found)


def _starts_of(
    ring: OffsetRing, shaping: Shaping, mark: Points | None
) -> tuple[tuple[int, float], ...]:
    """Return the points at which a closed ring may start by the process; any points if it has no
    such point.
    """
    pieces = ring.pieces
    if shaping.start == "point" and mark is not None:
        return (_nearest_place(pieces, mark),)
    if shaping.start == "longest":
        rows = range(len(pieces))
        lines = [i for i in rows if isinstance(pieces[i], Line)] or rows
        # Rounded, so that sides that are equal but for rounding have the first of them chosen.
        return ((max(lines, key=lambda i: round(pieces[i].length, 3)), 0.5),)
    if shaping.start == "corner" and ring.corners:
        return _some_places(ring.corners)
    if len(pieces) == 1:
        # A full circle has no joints.
        return tuple((0, part) for part in _LEAD_QUARTERS)
    joints = [(i, 0.0) for i in range(len(pieces))]
    return _some_places([*joints, *((i, 0.5) for i, _ in joints)] if shaping.leads else joints)


def _some_places(places: Sequence[tuple[int, float]]) -> tuple[tuple[int, float], ...]:
    """At most so many of them, from all of the way, the first among them."""
    ordered, count = sorted(places), len(places)
    tried = min(count, _MOST_STARTS_TRIED)
    return tuple(ordered[i * count // tried] for i in range(tried))


def _nearest_place(pieces: Sequence[Piece], point: Points) -> tuple[int, float]:
    """The place (piece, part) of closed pieces that is nearest to a point, seen along the tool."""
    best, found = np.inf, (0, 0.0)
    for i, piece in enumerate(pieces):
        part = _nearest_part(piece, point)
        # A start next to a joint is the joint: no piece without length is cut off.
        part = round(part) if min(part, 1.0 - part) * piece.length < SAME_POINT else part
        apart = float(np.linalg.norm(piece.at([part])[0, :2] - point[:2]))
        if apart < best - 1e-9:
            best, found = apart, (i, part)
    i, part = found
    # The end of a piece is the start of the next one.
    return found if part < 1.0 else ((i + 1) % len(pieces), 0.0)


def _nearest_part(piece: Piece, point: Points) -> float:
    """The part of a piece, 0 to 1, that is nearest to a point."""
    p, start = point[:2], np.asarray(piece.start[:2])
    if isinstance(piece, Line):
        way = np.asarray(piece.end[:2]) - start
        return float(np.clip((p - start) @ way / (way @ way), 0.0, 1.0))
    centre, sign = np.asarray(piece.centre[:2]), np.sign(piece.normal[2])
    (x0, y0), (x, y) = start - centre, p - centre
    turned = np.degrees(np.arctan2(y, x) - np.arctan2(y0, x0)) * sign % 360.0
    # Beyond the arc, the nearer of its two ends counts.
    if turned <= piece.sweep:
        return float(turned / piece.sweep)
    return 1.0 if turned - piece.sweep < 360.0 - turned else 0.0


_CONTOUR_CROSSING: Final = warning(
    "CT109",
    "a closed contour on layer {layer!r} crosses or touches itself and is followed as drawn",
    "redraw it if it is an outline",
)
_OPEN_CONTOUR: Final = error(
    "CT210",
    "an open contour on layer {layer!r} has no inside or outside for the tool to be on",
    'give the layer side = "left" or "right", as it is drawn; closed contours of other sides go to '
    "a layer of their own",
)
_NOT_FLAT: Final = error(
    "CT211",
    "a contour on layer {layer!r} is not flat as seen along the tool: its heights are "
    "{apart:.3f} mm apart",
    "draw it flat, give `direction`, or leave out offset, side and leads",
)
_CROSSES_ITSELF: Final = error(
    "CT212",
    "a contour on layer {layer!r} crosses or touches itself and has no inside",
    "redraw it so that it does not",
)
_OFFSET_COLLAPSED: Final = warning(
    "CT213",
    "a contour on layer {layer!r} is too narrow for an offset of {offset:g} mm: {what} left out",
    "use a narrower tool and a smaller `offset`, or take the contour to another layer",
)
_OFFSET_SPLIT: Final = warning(
    "CT214",
    "a contour on layer {layer!r} is too narrow in places for an offset of {offset:g} mm and "
    "falls into {count} ways; the necks between them are left out",
    "use a narrower tool and a smaller `offset`",
)
_MATERIAL_LEFT: Final = warning(
    "CT215",
    "the tool comes no nearer than {left:.2f} mm to a place of a contour on layer {layer!r}: "
    "that is too tight for an offset of {offset:g} mm and left out",
    "use a narrower tool and a smaller `offset`",
)
_CUTS_INTO: Final = error(
    "CT216",
    "the way beside a contour on layer {layer!r} comes within {apart:.2f} mm of another contour, "
    "and the tool needs {offset:g} mm",
    "move them apart, or use a narrower tool and a smaller `offset`",
)
_NO_ROOM: Final = error(
    "CT217",
    "there is no room for the leads of a contour on layer {layer!r}{where}: they would cut into it "
    "or into another one",
    "give shorter ones as `lead_in` and `lead_out`{cure}",
)
_SIDES_CHOSEN: Final = info(
    "CT218",
    "the tool is outside of {outside} and inside of {inside} closed contours of layer {layer!r}, "
    "{offset:g} mm away",
    "give `side` if that is not where it should be",
)
_START_MARKS: Final = warning(
    "CT219", "{what} on layer {layer!r}", "draw one POINT on each closed contour of the layer"
)
_OVERLAP_TOO_LONG: Final = error(
    "CT333",
    "an overlap of {overlap:g} mm is longer than a contour on layer {layer!r}, of {length:.2f} mm",
    "give a smaller `overlap`",
)
_LAYERS_MINGLED: Final = warning(
    "CT334",
    "layer {layer!r} is worked before {count} contours of layer {inner!r} that lie inside its own,"
    " as some of its own lie inside those of other layers; what is cut out falls before its holes"
    " are done",
    "draw them on one layer, or say inside_first = false for {layer!r}",
)
_LAYER_LATER: Final = info(
    "CT335",
    "layer {layer!r} comes first in the drawing, but is worked after layer {inner!r}, of which"
    " {count} contours lie inside its own",
    "say inside_first = false for {layer!r} to keep the order of the drawing",
)


_NARROW_OFFSETS: Final = 2.0
"""Offsets from a place of a contour to the tool's centre over which the place is left out; in a
right angle it is 1.41, at 60 degrees 2."""

_RingRounds = tuple[tuple[OffsetRing, ...], ...]


@dataclass(slots=True)
class _ContourOffsets:
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
        """True if an open contour must not be run backwards."""
        return self.sided or self.shaping.way_round == "drawn"

    @property
    def on_left(self) -> bool:
        """True if the tool is on the left of an open contour, as it is drawn."""
        return self.shaping.side == "left"

    @property
    def anticlockwise(self) -> bool:
        return _anticlockwise(self.pieces, self.tolerance)

    @property
    def outside(self) -> bool:
        """True if the tool is outside of a closed contour."""
        side = self.shaping.side
        if side == "nesting":
            return self.depth % 2 == 0
        if side in ("left", "right"):
            return (side == "right") == self.anticlockwise
        return side == "outside"

    def rounds(self, mark: Points | None) -> _RingRounds:
        """The ways for each allowance; none if the contour is left out, as the findings tell."""
        shaping = self.shaping
        level = 0.0
        if self.sided or shaping.leads:
            low, high = height_range(self.pieces)
            # The drawing's height, to which offsets made in the plane are put back.
            level = 0.5 * (low + high)
            if high - low > self.tolerance:
                return self._none(_NOT_FLAT, apart=high - low)
        if self.sided and not self.contour.closed and shaping.side not in ("left", "right"):
            return self._none(_OPEN_CONTOUR)
        closed = self.sided and self.contour.closed
        if closed and crosses_itself(self.pieces, self.tolerance):
            return self._none(_CROSSES_ITSELF)
        made = []
        for allowance in shaping.allowances:
            offset = shaping.offset + allowance
            rings = [self._turned(ring) for ring in self._rings(offset, level)]
            if not rings:
                last = allowance == shaping.allowances[-1]
                what = "it is" if last else "this way around it is"
                self._say(_OFFSET_COLLAPSED, offset=offset, what=what)
                continue
            made.append(rings)
        if not rings:
            return ()
        self._tell_what_is_left(made[-1])
        placed = tuple(tuple(self._placed(ring, mark) for ring in rings) for rings in made)
        return () if any(f.severity == "error" for f in self.findings) else placed

    def _rings(self, offset: float, level: float) -> list[OffsetRing]:
        """The ways at an offset, each as it comes."""
        closed, left = self.contour.closed, self.on_left
        if not offset:
            # Without an offset the contour is its own path.
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
        """Return the ring with its possible starts, rotated to the first of them; report leads
        without room.
        """
        shaping, length = self.shaping, ring.length
        # An overlap past one round would cut the same stretch three times.
        if ring.closed and shaping.overlap > length:
            self._say(_OVERLAP_TOO_LONG, overlap=shaping.overlap, length=length)
            return ring
        starts = _starts_of(ring, shaping, mark) if ring.closed else ((0, 0.0),)
        if self.sided and self.room is not None:
            near = self.room.too_near(ring, shaping.offset) if shaping.offset else None
            if near is not None:
                self._say(_CUTS_INTO, apart=near, offset=shaping.offset)
                return ring
            # Leads are checked against the contour as drawn, not against the path beside it.
            own = OffsetRing(self.pieces, ring.closed, ring.closed and self.outside)
            free = self.room.beside(self.key, own, shaping.offset)
            away = self.room.away(shaping.offset)
            starts = _starts_with_room(ring, starts, shaping, free, away)
        if not starts:
            places = {"corner": "its corners", "longest": "the middle of its longest side"}
            places["point"] = "its mark"
            where = places.get(shaping.start) if ring.closed else None
            self._say(
                _NO_ROOM,
                where=f" that starts at {where}" if where else "",
                cure=', or start = "nearest"' if where else "",
            )
            return ring
        if not ring.closed:
            return ring
        first, rest = starts[0], places_after_start(starts, ring.pieces, *starts[0])
        return replace(ring, pieces=started_at(ring.pieces, *first), starts=rest)

    def _tell_what_is_left(self, rings: Sequence[OffsetRing]) -> None:
        """Report the material that the tool does not reach on its last round."""
        import shapely

        # Earlier rounds leave their allowance on purpose: only the last one counts.
        offset = self.shaping.offset + self.shaping.allowances[-1]
        if not offset:
            return
        if len(rings) > 1:
            self._say(_OFFSET_SPLIT, offset=offset, count=len(rings))
            return
        bare = rings[0].bare
        if bare is None or not len(bare):
            return
        way = _drawn_outline(
            rings[0].pieces, self.tolerance * CHORD_TOLERANCE, closed=rings[0].closed
        )
        ways = shapely.STRtree(shapely.linestrings(np.stack([way[:-1], way[1:]], axis=1)))
        points, enough = shapely.points(bare), _NARROW_OFFSETS * offset + self.tolerance
        far = np.ones(len(points), dtype=np.bool_)
        far[ways.query(points, predicate="dwithin", distance=enough)[0]] = False
        if far.any():
            left = _largest_distance(ways, bare[far])
            self._say(_MATERIAL_LEFT, left=left - offset, offset=offset)

    def _none(self, rule: Rule, **fields: Any) -> _RingRounds:
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
    # From coarse to fine: a stride leaves only points that may be farther than the best so far.
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


@dataclass(frozen=True, slots=True)
class ToolView:
    """axes: (3, 3), rows x, y and up, which is against the tool; x and y are as one sees them who
    looks along the tool.
    """

    axes: Points

    @staticmethod
    def along(direction: Vector) -> ToolView:
        up = -np.asarray(direction, dtype=np.float64)
        x = level_x_axis(direction)
        return ToolView(np.stack([x, cross(up, x), up]))

    def of(self, pieces: Sequence[Piece]) -> tuple[Piece, ...]:
        return _in_view(pieces, self.axes)

    def back(self, pieces: Sequence[Piece]) -> tuple[Piece, ...]:
        return _in_view(pieces, self.axes.T)


def _in_view(pieces: Sequence[Piece], axes: Points) -> tuple[Piece, ...]:
    if np.array_equal(axes, np.eye(3)):
        return tuple(pieces)
    return tuple(_piece_in_view(piece, axes) for piece in pieces)


def _piece_in_view(piece: Piece, axes: Points) -> Piece:
    start, end = vector(axes @ piece.start), vector(axes @ piece.end)
    if isinstance(piece, Line):
        return replace(piece, start=start, end=end)
    via, centre, normal = (vector(axes @ v) for v in (piece.via, piece.centre, piece.normal))
    return replace(piece, start=start, via=via, end=end, centre=centre, normal=normal)


ContourKey = tuple[int, int]
"""Row of a layer, row of its contour."""


@dataclass(frozen=True, slots=True)
class ToolPath:
    """One continuous tool path: a contour including its leads, `below` mm under the drawing."""

    contour: Contour
    below: float = 0.0

    def lower(self, layer: Layer) -> Layer:
        """The layer with ways in and out that begin and end where those of the drawing do."""
        if not self.below:
            return layer
        approach, retract = layer.approach + self.below, layer.retract + self.below
        return replace(layer, approach=approach, retract=retract)


@dataclass(frozen=True, slots=True)
class ShapedContour:
    """A drawn contour as one thing to be put in order.

    main: what stands for it. rounds: for each allowance its ways, seen along the tool; the first
    of the last is `main`. deviation, fitted, dropped: as of `Moves`, of curves that are arcs and
    lines now.
    """

    main: Contour
    view: ToolView | None = None
    rounds: tuple[tuple[OffsetRing, ...], ...] = ()
    deviation: float = 0.0
    fitted: int = 0
    dropped: int = 0

    def ways(self, contour: Contour, shaping: Shaping) -> Iterator[ToolPath]:
        """Yield the tool paths in order. contour: `main`, after ordering."""
        if self.view is None:
            yield ToolPath(contour)
            return
        pieces = self.view.of([c for c in contour.curves if isinstance(c, Piece)])
        # The other rings start as near as they can to the start that the ordering has chosen.
        begin = np.asarray(pieces[0].start)
        last = self.rounds[-1][0]
        for rings in self.rounds:
            for ring in rings:
                if ring is last:
                    turned = replace(ring, pieces=pieces)
                else:
                    turned = replace(
                        ring, pieces=started_at(ring.pieces, *_nearest_start(ring, begin))
                    )
                made = _with_leads(turned, shaping)
                # Leads and overlap open a closed ring.
                closed = ring.closed and len(made) == len(turned.pieces)
                for below in shaping.depths:
                    curves = self.view.back(lowered(made, below))
                    yield ToolPath(Contour(curves, closed, contour.layer), below)


def _nearest_start(ring: OffsetRing, begin: Points) -> tuple[int, float]:
    """The start of a ring that is nearest to a point."""

    def far(start: tuple[int, float]) -> float:
        i, part = start
        return float(np.linalg.norm(ring.pieces[i].at([part])[0] - begin))

    return min(ring.starts, key=far) if ring.closed else (0, 0.0)


@dataclass(slots=True)
class PathShaper:
    """layers: those that are followed, each with its contours. Of these it knows which lie inside
    which, over all layers on which sides matter, and how near they are to each other.

    nestings: of the layers. rooms: by the direction of the tool. depths: how many contours are
    around one. known: contours as lines and arcs.
    """

    layers: Sequence[tuple[Layer, Sequence[Contour]]]
    nestings: Sequence[GroupNesting]
    tolerance: float
    findings: list[Diagnostic] = field(default_factory=list)
    rooms: dict[tuple[float, ...], ClearRoom] = field(default_factory=dict)
    depths: dict[ContourKey, int] = field(default_factory=dict)
    known: dict[ContourKey, ContourPieces] = field(default_factory=dict)

    def __post_init__(self) -> None:
        alike: dict[tuple[float, ...], list[tuple[ContourKey, Contour]]] = {}
        for i, (layer, contours) in enumerate(self.layers):
            if layer.shaping.sided:
                # Sides matter only between contours that are seen in the same direction.
                them = [((i, k), contour) for k, contour in enumerate(contours)]
                alike.setdefault(layer.direction, []).extend(them)
        for direction, members in alike.items():
            x, y, z = direction
            around = holders([c for _, c in members], (x, y, z), self.tolerance)
            depths = nesting_depths(around)
            view = ToolView.along((x, y, z))
            lines = []
            for row, (key, contour) in enumerate(members):
                self.depths[key] = depths[row]
                pieces = self._pieces(key, contour).pieces
                if pieces:
                    lines.append((key, view.of(pieces), contour.closed))
            self.rooms[direction] = ClearRoom.of(lines, self.tolerance)

    def _pieces(self, key: ContourKey, contour: Contour) -> ContourPieces:
        """A contour as lines and arcs, worked out once."""
        if key not in self.known:
            self.known[key] = as_pieces(contour, self.tolerance)
        return self.known[key]

    def order(self) -> list[int]:
        """The rows of the layers: those whose contours lie inside others' come before them."""
        left, order = dict.fromkeys(range(len(self.layers))), list[int]()
        while left:
            row = next((row for row in left if not self._waits_for(row, left)), next(iter(left)))
            # Layers that wait for each other in a circle: the first one is taken, with a finding.
            for inner, count in self._waits_for(row, left).items():
                name, other = (shown(self.layers[k][1][0].layer) for k in (row, inner))
                self.findings.append(_LAYERS_MINGLED(layer=name, inner=other, count=count))
            for earlier in left:
                within = self._waits_for(earlier, left).get(row)
                if earlier < row and within:
                    name, other = (shown(self.layers[k][1][0].layer) for k in (earlier, row))
                    self.findings.append(_LAYER_LATER(layer=name, inner=other, count=within))
            del left[row]
            order.append(row)
        return order

    def _waits_for(self, row: int, left: Container[int]) -> dict[int, int]:
        """Count the contours inside those of a layer, by the layers that are not yet ordered."""
        inner = self.nestings[row].around if self.layers[row][0].inside_first else {}
        return {other: count for other, count in inner.items() if other in left}

    def shaped(self, row: int, marks: Points) -> list[ShapedContour | None]:
        """The contours of a layer, in their order; None for one that is left out.

        marks: (m, 3) points of the layer.
        """
        layer, contours = self.layers[row]
        shaping = layer.shaping
        if not shaping.sided:
            self._tell_crossings(row)
        # Nothing shapes the contours: their curves stay as drawn.
        if shaping == Shaping(depth=shaping.depth, passes=shaping.passes) and not shaping.depth:
            return [ShapedContour(replace(c, number=k)) for k, c in enumerate(contours)]
        view = ToolView.along(layer.direction)
        marked = self._marked(row, marks @ view.axes.T, view)
        room = self.rooms.get(layer.direction)
        made: list[ShapedContour | None] = []
        sides: list[bool] = []
        for k, contour in enumerate(contours):
            given = self._pieces((row, k), contour)
            if not (given.pieces and given.within):
                made.append(ShapedContour(replace(contour, number=k)))
                continue
            depth = self.depths.get((row, k), 0)
            one = _ContourOffsets(
                (row, k), contour, view.of(given.pieces), shaping, self.tolerance, room, depth
            )
            rounds = one.rounds(marked.get(k))
            self.findings += one.findings
            if contour.closed:
                sides.append(one.outside)
            if not rounds:
                made.append(None)
                continue
            main = rounds[-1][0]
            stands = Contour(
                view.back(main.pieces),
                main.closed,
                contour.layer,
                main.starts if main.closed else (),
                not main.closed and one.fixed,
                not main.closed and main.left != one.on_left,
                k,
            )
            found = (given.deviation, given.fitted, given.dropped)
            made.append(ShapedContour(stands, view, rounds, *found))
        if shaping.sided and shaping.side == "nesting" and sides:
            outside = sum(sides)
            self.findings.append(
                _SIDES_CHOSEN(
                    layer=shown(contours[0].layer),
                    offset=shaping.offset,
                    outside=outside,
                    inside=len(sides) - outside,
                )
            )
        return made

    def _tell_crossings(self, row: int) -> None:
        """A finding for each closed contour of a layer that crosses itself; with sides it is one
        that nothing follows.
        """
        for k, contour in enumerate(self.layers[row][1]):
            only = contour.curves[0]
            if not contour.closed or (len(contour.curves) < 4 and isinstance(only, Line | Arc)):
                continue
            given = self._pieces((row, k), contour)
            view = ToolView.along(self.layers[row][0].direction)
            if given.pieces and crosses_itself(view.of(given.pieces), self.tolerance):
                handle = next((c.handle for c in contour.curves if c.handle), "")
                place = f"entity {handle}" if handle else None
                self.findings.append(_CONTOUR_CROSSING(place=place, layer=shown(contour.layer)))

    def _marked(self, row: int, marks: Points, view: ToolView) -> Mapping[int, Points]:
        """The mark of each closed contour of a layer, where starts are marked."""
        layer, contours = self.layers[row]
        closed = [k for k, contour in enumerate(contours) if contour.closed]
        if layer.shaping.start != "point" or not closed:
            return {}
        given = ((k, self._pieces((row, k), contours[k]).pieces) for k in closed)
        flat = [((row, k), view.of(pieces), True) for k, pieces in given if pieces]
        found: dict[int, tuple[float, Points]] = {}
        for mark, (_, k), far in ClearRoom.of(flat, self.tolerance).nearest(marks):
            if k not in found or far < found[k][0]:
                found[k] = (far, mark)
        missing, unused = len(closed) - len(found), len(marks) - len(found)
        said = []
        if missing:
            said.append(f"{missing} of {len(closed)} closed contours have no POINT as their start")
        if unused:
            said.append(f"{unused} of {len(marks)} POINTs mark no start: another one is nearer")
        if said:
            name = shown(contours[0].layer)
            self.findings.append(_START_MARKS(what="; ".join(said), layer=name))
        return {k: mark for k, (_, mark) in found.items()}
