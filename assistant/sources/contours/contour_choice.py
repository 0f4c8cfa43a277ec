"""Choice of single contours: those that `leave_out` of a process file drops, and groups of them.

A contour is named by a point on it or in it, by its number in the picture of the order, or by the
group that it is in: contours that stand apart from all others, as the views of a part do. Points
are mm of the drawing's world, seen from above, wherever `[placement]` takes them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field
from itertools import groupby
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error, info, warning
from assistant.program.geometry import Pose
from assistant.program.settings_tables import shown
from assistant.sources.contours.chains import Contour
from assistant.sources.contours.contour_order import (
    distance_to_outline,
    group_nestings,
    polygon_outline,
)
from assistant.sources.contours.contour_shapes import ContourShape, contour_shapes
from assistant.sources.contours.curves import sample
from assistant.sources.contours.work_words import edge_kind
from assistant.sources.process import DEFAULT_MOTION, Layer, LeftOut, Process

if TYPE_CHECKING:
    from shapely import STRtree

GROUPS = info(
    "CT229",
    "the contours stand in {count} groups far apart: {what}",
    "leave out what is another view of the same part: leave_out = [{{group = 2}}] at the top of the"
    " process file",
)
_NO_CONTOUR_AT = error(
    "CT230",
    "`{entry}` under leave_out names no contour: there is none at that point{near}",
    "give a point on the contour or in it, as the drawing has it, in mm",
)
_SEVERAL_AT = info(
    "CT231",
    "`{entry}` under leave_out is in {count} contours; the innermost is left out: {what}",
    "for another one, give a point on its line",
)
_BETWEEN = error(
    "CT232",
    "`{entry}` under leave_out is on the lines of two contours",
    "give a point that is nearer to the one that is meant, or its `layer`",
)
_NO_NUMBER = error(
    "CT233",
    "`{entry}` under leave_out names no contour: the order has {count}{where}",
    "take the number from the picture of the order without that entry, or give `at`",
)
_NUMBERED = warning(
    "CT234",
    "`{entry}` leaves out {what}; contours are counted anew without it, and after each change of"
    " the order",
    "name it by a place, which stays: leave_out = [{instead}]",
)
_NO_GROUP = error(
    "CT235",
    "`{entry}` under leave_out names no group: the contours stand in {count}",
    "take the number from this list, or leave the entry out: {what}",
)

_LEFT_OUT = info("CT240", "`{entry}` under leave_out leaves out {what}", "")
_LEFT_AROUND_OTHERS = warning(
    "CT241",
    "`{entry}` leaves out {what}; {count} that {lie} in it {are} followed without it",
    "leave those out as well, unless it is a frame around the work",
)
_AROUND_OTHERS = error(
    "CT242",
    "`{entry}` under leave_out is on no line, but in {what}, which holds {count} that would be"
    " followed without it{near}",
    "name the one that is meant by a point on its line; this one is {instead}",
)

_ON_LINE: Final = 0.5
"""mm from a contour within which a point is on it, as by a click."""
_AS_NEAR: Final = 0.01
"""mm by which one contour has to be nearer than another to be the one that is meant."""
_FAR_PART: Final = 0.06
"""Part of the size of all contours by which groups are apart."""
_FEWEST_CURVES: Final = 4
"""Curves of a group that may be a view although none of its contours is closed."""
_MOST_GROUPS: Final = 8
"""Groups over which they are a pattern, not views."""
_SAME_SIZE: Final = 0.02
"""Part by which copies of a part may differ in size."""
_MOST_LISTED: Final = 8
_MOST_SIDES: Final = 16
"""Sides of a contour that are tried for a point that names it."""
_DECIMALS: Final = 3
"""Decimals of mm of that point."""
_BOX_PARTS: Final = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Parts of a curve that are looked at for its box; exact for lines, near enough for the rest."""

Row = tuple[int, int]
"""A layer by its place among those that are followed, and a contour of it by its own."""


@dataclass(slots=True)
class ContourGroup:
    """Contours near each other. low, high: (2,) mm of the box around them."""

    low: Floats
    high: Floats
    rows: list[Row]
    curves: int
    closed: int

    @property
    def size(self) -> Floats:
        return self.high - self.low

    @property
    def may_be_view(self) -> bool:
        return self.closed > 0 or self.curves >= _FEWEST_CURVES

    def text(self, number: int) -> str:
        width, height = self.size.tolist()
        x, y = self.low.tolist()
        what = f"{_counted(len(self.rows))}, {width:.1f} x {height:.1f} mm"
        return f"{number}: {what} from [{x + 0.0:.1f}, {y + 0.0:.1f}]"


@dataclass(slots=True)
class ContourChoice:
    """Which contours of the layers that are followed are left out.

    layers: contours of each. back: from where they are placed to the drawing's world. left: rows
    that are left out, with the entries of leave_out that name them. findings: about these, and
    groups.
    """

    layers: Sequence[Sequence[Contour]]
    back: Pose
    tolerance: float
    left: dict[Row, list[LeftOut]] = field(default_factory=dict)
    findings: list[Diagnostic] = field(default_factory=list)
    _outlines: dict[Row, Floats] = field(default_factory=dict)
    _trees: dict[int, STRtree] = field(default_factory=dict)
    _around_point: list[tuple[LeftOut, Row, tuple[float, float], int]] = field(default_factory=list)
    """Entries whose point is in a contour, on no line, with how many contours hold it."""

    @staticmethod
    def of(
        layers: Sequence[Sequence[Contour]], process: Process, order: Callable[[], Sequence[Row]]
    ) -> ContourChoice:
        """order: rows in the order in which contours are followed if no entry has a number."""
        back = Pose() if process.placement is None else process.placement.inverse()
        choice = ContourChoice(layers, back, process.tolerance)
        entries = [one for one in process.left_out if one.line_type is None and one.block is None]
        groups = list(choice.groups()) if any(layers) else []
        for one in entries:
            if one.at is not None:
                choice._leave_out_at(one, one.at)
            elif one.group is not None:
                choice._leave_out_group(one, one.group, groups)
        numbered = [one for one in entries if one.number is not None]
        if numbered:
            rows = order()
            for one in numbered:
                choice._leave_out_number(one, rows)
        choice._name_left(entries, process)
        if not any(one.group is not None for one in entries):
            choice._note_groups(groups)
        return choice

    def kept(self, layer: int) -> list[Row]:
        """The contours of a layer that are not left out."""
        rows = ((layer, k) for k in range(len(self.layers[layer])))
        return [row for row in rows if row not in self.left]

    def rows(self) -> Iterator[tuple[Row, Contour]]:
        for i, contours in enumerate(self.layers):
            for k, contour in enumerate(contours):
                yield (i, k), contour

    def outline(self, row: Row) -> Floats:
        """Corners (n, 2) of a contour in the drawing, its start again if it is closed."""
        if row not in self._outlines:
            contour = self.layers[row[0]][row[1]]
            points = self.back.moved(polygon_outline(contour, self.tolerance))[:, :2]
            if contour.closed:
                points = np.vstack([points, points[:1]])
            self._outlines[row] = points
        return self._outlines[row]

    def naming_point(self, row: Row) -> tuple[float, float] | None:
        """Return a point (mm in the drawing's world) that names a contour in an entry with its
        layer, None if others run along all of it.

        The middle of a side belongs to one contour also where two of them meet.
        """
        import shapely

        tree = self._trees.get(row[0])
        if tree is None:
            lines = [self.outline((row[0], k)) for k in range(len(self.layers[row[0]]))]
            tree = self._trees[row[0]] = shapely.STRtree([*map(shapely.LineString, lines)])
        outline = self.outline(row)
        sizes = np.linalg.norm(np.diff(outline, axis=0), axis=1)
        for side in np.argsort(-sizes, kind="stable")[:_MOST_SIDES].tolist():
            x, y = (0.5 * (outline[side] + outline[side + 1])).round(_DECIMALS).tolist()
            around = tree.query(shapely.Point(x, y), "dwithin", 2.0 * _AS_NEAR)
            if around.tolist() == [row[1]]:
                return x + 0.0, y + 0.0
        return None

    def _leave_out(self, entry: LeftOut, row: Row) -> None:
        self.left.setdefault(row, []).append(entry)

    def _leave_out_at(self, entry: LeftOut, at: tuple[float, float]) -> None:
        rows = [(row, one) for row, one in self.rows() if entry.concerns(one.layer)]
        near = [(distance_to_outline(at, self.outline(row)), row) for row, _ in rows]
        near.sort()
        if near and near[0][0] <= _ON_LINE:
            if len(near) > 1 and near[1][0] - near[0][0] < _AS_NEAR:
                self.findings.append(_BETWEEN(entry=entry.text))
            else:
                self._leave_out(entry, near[0][1])
            return
        import shapely

        around = [
            (shapely.Polygon(self.outline(row)), row)
            for row, one in rows
            if one.closed and len(self.outline(row)) > 3
        ]
        place = shapely.Point(at)
        inside = sorted(
            (area.area, row) for area, row in around if shapely.make_valid(area).contains(place)
        )
        if not inside:
            said = "" if near else "; on that layer none is followed"
            if near:
                distance, row = near[0]
                said = f"; the nearest is {self._text(row)}, {distance:.1f} mm away"
            self.findings.append(_NO_CONTOUR_AT(entry=entry.text, near=said))
            return
        row = inside[0][1]
        self._leave_out(entry, row)
        self._around_point.append((entry, row, at, len(inside)))

    def _name_left(self, entries: Sequence[LeftOut], process: Process) -> None:
        """Report which contour each entry leaves out, and refuse points that may mean another.

        A point between a hole and the outline, which missed the hole, would leave out the outline
        and follow the holes. Of a frame, on its line, that is wanted.
        """
        named = [one for one in entries if one.at is not None or one.number is not None]
        if not (named and self.left):
            return
        rows = [row for row, _ in self.rows()]
        texts = self.shapes(process, rows)

        def what(row: Row) -> str:
            layer = shown(self.layers[row[0]][row[1]].layer)
            shape = texts[row]
            return f"{'' if shape.kind else 'the line of '}{shape.text} on layer {layer!r}"

        for entry, row, at, count in self._around_point:
            held = [one for one in self._held(row) if entry.concerns(self._layer(one))]
            if held:
                distance, near = min((distance_to_outline(at, self.outline(k)), k) for k in held)
                instead = LeftOut(self._layer(row), at=self.naming_point(row) or at).text
                self.findings.append(
                    _AROUND_OTHERS(
                        entry=entry.text,
                        what=what(row),
                        count=_counted(len(held)),
                        near=f", the nearest {what(near)}, {distance:.1f} mm away",
                        instead=instead,
                    )
                )
                self.left[row].remove(entry)
            elif count > 1:
                self.findings.append(_SEVERAL_AT(entry=entry.text, count=count, what=what(row)))
        said = {entry for entry, *_, count in self._around_point if count > 1}
        self.left = {row: by for row, by in self.left.items() if by}
        for row, by in self.left.items():
            for entry in (one for one in by if one in named):
                if held := self._held(row):
                    many = len(held) > 1
                    self.findings.append(
                        _LEFT_AROUND_OTHERS(
                            entry=entry.text,
                            what=what(row),
                            count=_counted(len(held)),
                            lie="lie" if many else "lies",
                            are="are" if many else "is",
                        )
                    )
                elif entry.number is None and entry not in said:
                    self.findings.append(_LEFT_OUT(entry=entry.text, what=what(row)))

    def _held(self, row: Row) -> list[Row]:
        """Return the contours inside one that are followed."""
        import shapely

        if not self.layers[row[0]][row[1]].closed or len(self.outline(row)) < 4:
            return []
        area = shapely.make_valid(shapely.Polygon(self.outline(row)))
        others = [one for one, _ in self.rows() if one not in self.left]
        if not others:
            return []
        points = np.array([self.outline(one)[0] for one in others])
        inside = shapely.contains_xy(area, points[:, 0], points[:, 1])
        return [one for one, within in zip(others, inside.tolist(), strict=True) if within]

    def shapes(self, process: Process, rows: Sequence[Row]) -> dict[Row, ContourShape]:
        """Return the shapes of some contours, as if the drawing had no others."""
        known = {name.casefold(): layer for name, layer in process.layers.items()}
        usual = Layer("", DEFAULT_MOTION.motion)
        groups = []
        for contours in self.layers:
            layer = known.get(contours[0].layer.casefold(), usual)
            kind = edge_kind(contours[0].layer, layer)
            groups.append((process.placed(layer.direction), kind, list[Contour]()))
        for i, k in rows:
            groups[i][2].append(self.layers[i][k])
        by_layer = [
            iter(contour_shapes(contours, nesting, direction, process.placement, process.tolerance))
            for (direction, _, contours), nesting in zip(
                groups, group_nestings(groups, process.tolerance), strict=True
            )
        ]
        return {row: next(by_layer[row[0]]) for row in rows}

    def _layer(self, row: Row) -> str:
        return self.layers[row[0]][row[1]].layer

    def _leave_out_number(self, entry: LeftOut, rows: Sequence[Row]) -> None:
        number = entry.number or 0
        row = rows[number - 1] if number <= len(rows) else None
        layer = "" if row is None else self.layers[row[0]][row[1]].layer
        if row is None or not entry.concerns(layer):
            where = "" if row is None else f", and that one is on layer {shown(layer)!r}"
            self.findings.append(_NO_NUMBER(entry=entry.text, count=len(rows), where=where))
            return
        self._leave_out(entry, row)
        outline = self.outline(row)
        x, y = (0.5 * (outline[0] + outline[1])).tolist()
        # Where others run along all of it, no entry names it alone: this one is refused as well.
        instead = LeftOut(layer, at=self.naming_point(row) or (x, y)).text
        self.findings.append(_NUMBERED(entry=entry.text, what=self._text(row), instead=instead))

    def _leave_out_group(self, entry: LeftOut, number: int, groups: Sequence[ContourGroup]) -> None:
        if number > len(groups):
            what = _listed(groups) or "there are no contours"
            self.findings.append(_NO_GROUP(entry=entry.text, count=len(groups), what=what))
        else:
            for row in groups[number - 1].rows:
                self._leave_out(entry, row)

    def _text(self, row: Row) -> str:
        """A contour in words."""
        contour = self.layers[row[0]][row[1]]
        outline = self.outline(row)
        low, high = outline.min(axis=0), outline.max(axis=0)
        x, y = ((low + high) / 2.0).tolist()
        width, height = (high - low).tolist()
        kind = "closed" if contour.closed else "open"
        return (
            f"the {kind} contour of {width:.1f} x {height:.1f} mm around [{x + 0.0:.1f},"
            f" {y + 0.0:.1f}] on layer {shown(contour.layer)!r}"
        )

    def _note_groups(self, groups: Sequence[ContourGroup]) -> None:
        if not _are_views(groups) or any(self.left.keys() >= set(one.rows) for one in groups):
            return
        self.findings.append(GROUPS(count=len(groups), what=_listed(groups)))

    def views(self) -> list[ContourGroup]:
        """Return the groups that may be views of a part, the largest first; empty if none may."""
        groups = list(self.groups())
        return groups if _are_views(groups) else []

    def groups(self) -> Iterator[ContourGroup]:
        """Contours that stand together, the largest group first."""
        rows = [row for row, _ in self.rows()]
        if not rows:
            return
        lows, highs = self._boxes()
        apart = _FAR_PART * float((highs.max(axis=0) - lows.min(axis=0)).max())
        found: list[ContourGroup] = []
        for row, low, high in zip(rows, lows, highs, strict=True):
            contour = self.layers[row[0]][row[1]]
            new = ContourGroup(low, high, [row], len(contour.curves), int(contour.closed))
            # A group that grows may reach another one, so it is compared again.
            while near := [one for one in found if _gap(one, new) <= apart]:
                found = [one for one in found if all(one is not other for other in near)]
                for one in near:
                    one.rows.extend(new.rows)  # a copy for each contour would be too much
                    new = ContourGroup(
                        np.minimum(one.low, new.low),
                        np.maximum(one.high, new.high),
                        one.rows,
                        one.curves + new.curves,
                        one.closed + new.closed,
                    )
            found.append(new)
        found.sort(key=lambda one: (-float(one.size.prod()), *one.low.tolist()))
        yield from found

    def _boxes(self) -> tuple[Floats, Floats]:
        """Corners (n, 2) of the boxes around all contours."""
        curves = [(n, c) for n, (_, one) in enumerate(self.rows()) for c in one.curves]
        points = sample([curve for _, curve in curves], _BOX_PARTS)
        flat = self.back.moved(points.reshape(-1, 3))[:, :2].reshape(len(curves), -1, 2)
        low, high = flat.min(axis=1), flat.max(axis=1)
        starts = [
            next(iter(group))[0]
            for _, group in groupby(enumerate(n for n, _ in curves), key=lambda pair: pair[1])
        ]
        return np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)


def _are_views(groups: Sequence[ContourGroup]) -> bool:
    """True if groups may be views of a part: a few of different sizes; copies are work."""
    views = [one for one in groups if one.may_be_view]
    if not 2 <= len(groups) <= _MOST_GROUPS or len(views) < 2:
        return False
    sizes = np.array([one.size for one in groups])
    return bool(np.ptp(sizes, axis=0).max() > _SAME_SIZE * sizes.max())


def _counted(count: int) -> str:
    return f"{count} contour{'s' * (count != 1)}"


def _gap(one: ContourGroup, other: ContourGroup) -> float:
    """Mm between the boxes of two groups, along the axis where they are farther apart."""
    return float(np.maximum(one.low - other.high, other.low - one.high).max())


def _listed(groups: Sequence[ContourGroup]) -> str:
    rows = [one.text(number) for number, one in enumerate(groups, 1)]
    more = f"; and {len(rows) - _MOST_LISTED} more" if len(rows) > _MOST_LISTED else ""
    return "; ".join(rows[:_MOST_LISTED]) + more
