"""From the contours of layers to the ways of a tool beside them, as the process shapes them.

Contours are seen along the tool. A contour that nothing shapes stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.program.settings_tables import shown
from assistant.sources.contours import shaping_rules as rules
from assistant.sources.contours.beside import ContourOffsets
from assistant.sources.contours.chaining import Contour
from assistant.sources.contours.curves import Arc, Line, Points
from assistant.sources.contours.flat import Piece, lowered, started_at
from assistant.sources.contours.leads import with_leads
from assistant.sources.contours.moves import ContourPieces, as_pieces
from assistant.sources.contours.nesting import NO_HOLDER, holders
from assistant.sources.contours.offsets import OffsetRing, crosses_itself
from assistant.sources.contours.room import ClearRoom
from assistant.sources.contours.seen import ToolView
from assistant.sources.process import Layer
from assistant.sources.process.shaping import Shaping

ContourKey = tuple[int, int]
"""Row of a layer, row of its contour."""


@dataclass(frozen=True, slots=True)
class ToolPath:
    """What is followed at once: a contour with leads and all, `below` mm under the drawing."""

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
        """What is followed, in order. contour: `main`, as it was put in order."""
        if self.view is None:
            yield ToolPath(contour)
            return
        pieces = self.view.of([c for c in contour.curves if isinstance(c, Piece)])
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
                made = with_leads(turned, shaping)
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

    rooms: by the direction of the tool. depths: how many contours are around one. held: rows of
    the layers whose contours lie inside those of a layer. known: contours as lines and arcs.
    """

    layers: Sequence[tuple[Layer, Sequence[Contour]]]
    tolerance: float
    findings: list[Diagnostic] = field(default_factory=list)
    rooms: dict[tuple[float, ...], ClearRoom] = field(default_factory=dict)
    depths: dict[ContourKey, int] = field(default_factory=dict)
    held: dict[int, set[int]] = field(default_factory=dict)
    known: dict[ContourKey, ContourPieces] = field(default_factory=dict)

    def __post_init__(self) -> None:
        alike: dict[tuple[float, ...], list[tuple[ContourKey, Contour]]] = {}
        for i, (layer, contours) in enumerate(self.layers):
            if layer.shaping.sided:
                them = [((i, k), contour) for k, contour in enumerate(contours)]
                alike.setdefault(layer.direction, []).extend(them)
        for direction, members in alike.items():
            x, y, z = direction
            around = holders([c for _, c in members], (x, y, z), self.tolerance)
            view = ToolView.along((x, y, z))
            lines = []
            for row, (key, contour) in enumerate(members):
                self.depths[key] = _holder_count(row, around)
                if around[row] != NO_HOLDER:
                    (outer, _), _ = members[around[row]]
                    self.held.setdefault(outer, set()).add(key[0])
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
        left, order = list(range(len(self.layers))), list[int]()
        while left:
            free = (row for row in left if not self._waits_for(row) & (set(left) - {row}))
            row = next(free, None)
            if row is None:
                row = left[0]
                name = shown(self.layers[row][1][0].layer)
                self.findings.append(rules.LAYERS_MINGLED(layer=name))
            left.remove(row)
            order.append(row)
        return order

    def _waits_for(self, row: int) -> set[int]:
        return self.held.get(row, set()) if self.layers[row][0].inside_first else set()

    def shaped(self, row: int, marks: Points) -> list[ShapedContour | None]:
        """The contours of a layer, in their order; None for one that is left out.

        marks: (m, 3) points of the layer.
        """
        layer, contours = self.layers[row]
        shaping = layer.shaping
        if not shaping.sided:
            self._tell_crossings(row)
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
            one = ContourOffsets(
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
                k,
            )
            found = (given.deviation, given.fitted, given.dropped)
            made.append(ShapedContour(stands, view, rounds, *found))
        if shaping.sided and shaping.side == "nesting" and sides:
            outside = sum(sides)
            self.findings.append(
                rules.SIDES_CHOSEN(
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
                self.findings.append(
                    rules.CONTOUR_CROSSING(place=place, layer=shown(contour.layer))
                )

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
            self.findings.append(rules.START_MARKS(what="; ".join(said), layer=name))
        return {k: mark for k, (_, mark) in found.items()}


def _holder_count(row: int, around: Sequence[int]) -> int:
    """How many contours are around one."""
    depth = 0
    while around[row] != NO_HOLDER:
        row, depth = around[row], depth + 1
    return depth
