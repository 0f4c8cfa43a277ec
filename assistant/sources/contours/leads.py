"""Ways onto a contour and off it, and the place where both have room."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from assistant.program.geometry import Vector
from assistant.sources.contours.curves import Arc, Line, Points, vector
from assistant.sources.contours.flat import Piece, first_stretch, started_at, tangent
from assistant.sources.contours.offsets import OffsetRing
from assistant.sources.contours.origins import SAME_POINT
from assistant.sources.process.shaping import Lead, Shaping

MOST_STARTS_TRIED: Final = 24
"""Places of a contour that are looked at as its start."""
LEAD_QUARTERS: Final = (0.0, 0.25, 0.5, 0.75)


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


def with_leads(ring: OffsetRing, shaping: Shaping) -> tuple[Piece, ...]:
    """The pieces of a ring from its start on, with overlap and leads."""
    pieces = ring.pieces
    if ring.closed and shaping.overlap:
        pieces = (*pieces, *first_stretch(pieces, shaping.overlap))
    into = [lead_in(shaping.lead_in, pieces, left=ring.left)] if shaping.lead_in else []
    out = [lead_out(shaping.lead_out, pieces, left=ring.left)] if shaping.lead_out else []
    return (*into, *pieces, *out)


def starts_with_room(
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
        made = with_leads(replace(ring, pieces=started_at(ring.pieces, at, part)), shaping)
        ways = [made[:1]] if shaping.lead_in else []
        ways += [made[-1:]] if shaping.lead_out else []
        if all(room(way) for way in ways):
            found.append((at, part))
            ends = [made[0].start] if shaping.lead_in else []
            ends += [made[-1].end] if shaping.lead_out else []
            if all(away(end) for end in ends):
                better.append((at, part))
    return tuple(better or found)


def starts_of(
    ring: OffsetRing, shaping: Shaping, mark: Points | None
) -> tuple[tuple[int, float], ...]:
    """Where a closed ring may start as the process says; anywhere if it has no such place."""
    pieces = ring.pieces
    if shaping.start == "point" and mark is not None:
        return (nearest_place(pieces, mark),)
    if shaping.start == "longest":
        rows = range(len(pieces))
        lines = [i for i in rows if isinstance(pieces[i], Line)] or rows
        return ((max(lines, key=lambda i: round(pieces[i].length, 3)), 0.5),)
    if shaping.start == "corner" and ring.corners:
        return _some_places(ring.corners)
    if len(pieces) == 1:
        return tuple((0, part) for part in LEAD_QUARTERS)
    joints = [(i, 0.0) for i in range(len(pieces))]
    return _some_places([*joints, *((i, 0.5) for i, _ in joints)] if shaping.leads else joints)


def _some_places(places: Sequence[tuple[int, float]]) -> tuple[tuple[int, float], ...]:
    """At most so many of them, from all of the way, the first among them."""
    ordered, count = sorted(places), len(places)
    tried = min(count, MOST_STARTS_TRIED)
    return tuple(ordered[i * count // tried] for i in range(tried))


def nearest_place(pieces: Sequence[Piece], point: Points) -> tuple[int, float]:
    """The place (piece, part) of closed pieces that is nearest to a point, seen along the tool."""
    best, found = np.inf, (0, 0.0)
    for i, piece in enumerate(pieces):
        part = _nearest_part(piece, point)
        part = round(part) if min(part, 1.0 - part) * piece.length < SAME_POINT else part
        apart = float(np.linalg.norm(piece.at([part])[0, :2] - point[:2]))
        if apart < best - 1e-9:
            best, found = apart, (i, part)
    i, part = found
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
    if turned <= piece.sweep:
        return float(turned / piece.sweep)
    return 1.0 if turned - piece.sweep < 360.0 - turned else 0.0
