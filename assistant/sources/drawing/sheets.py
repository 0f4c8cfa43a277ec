"""Find sheets of paper in a drawing: borders and title blocks on layers of the work, by shape.

A rectangle of four lines is the border of a sheet if a title block is in its corner: lines that
end on its sides and on each other, with texts between them. To the border belong the edge of the
paper around it, the marks between the two, and everything in the cells of the title block. Few
lines or texts are a title block only if the rectangle has the size of paper, or of paper within
margins; in another rectangle they may be labelled pieces of a plate, which only the user can tell.

A rectangle without a title block is a candidate only if it has the size of a sheet, encloses all
that is drawn, touches none of it, and if the drawing has texts or dimensions. It is the edge of a
sheet if a border runs along it, or if parts with holes are in it: if it were a part, these would be
loose in its holes. Otherwise only the user can tell whether it is a plate. A sheet at another scale
has no such size; it is known by two frames in the proportion of a sheet with the same margin all
around, or a wider one for binding, and by marks between them or parts with holes inside.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence, Set
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.program.geometry import Pose
from assistant.sources.contours.chains import chain_curves
from assistant.sources.contours.contour_order import NO_HOLDER, holders
from assistant.sources.contours.curves import Arc, Curve, Line, sample

_SIZES: Final = {
    "A4": (210.0, 297.0),
    "A3": (297.0, 420.0),
    "A2": (420.0, 594.0),
    "A1": (594.0, 841.0),
    "A0": (841.0, 1189.0),
    "ANSI A": (215.9, 279.4),
    "ANSI B": (279.4, 431.8),
    "ANSI C": (431.8, 558.8),
    "ANSI D": (558.8, 863.6),
    "ANSI E": (863.6, 1117.6),
}
"""Sheets of ISO 216 and of ANSI Y14.1: mm of the short and of the long side."""
_SIZE_PART: Final = 0.005
"""Relative difference between a side and that of a sheet; inches have one decimal."""
_MARGINS: Final = (
    *((10.0, 10.0), (20.0, 20.0), (40.0, 40.0)),
    *((25.0, 10.0), (30.0, 20.0), (30.0, 10.0), (35.0, 20.0)),
)
"""Both margins of a sheet together, mm along one side and along the other: of one width all around,
or wider for binding (DIN 6771, ISO 5457, GB/T 14689)."""
_MARGINS_IN_INCHES: Final = (
    *((0.5, 0.5), (1.0, 1.0), (0.76, 0.5), (1.24, 0.76)),
    *((1.5, 1.0), (2.0, 1.0), (1.0, 0.5)),
)
"""The same in inches, of sheets of ANSI Y14.1."""
_MARGIN_OFF: Final = 0.3
"""mm by which both margins together may be others; inches have two decimals."""
_PROPORTIONS: Final = (2.0**0.5, 11.0 / 8.5, 17.0 / 11.0)
"""Long by short side of sheets, at any scale."""
_PROPORTION_PART: Final = 0.015
"""Relative difference from it: margins of one width change it."""
_EVEN_PART: Final = 0.02
"""Relative difference between margins of the same width."""
_TOUCH: Final = 0.05
"""mm within which lines meet."""
_SHIFT: Final = 0.0373
"""mm by which coordinates are shifted before rounding: round ones are in the middle of a step."""
_SHORTEST_SIDE: Final = 90.0
"""mm of a border's short side: half of an A4 sheet's."""
_WIDEST_PROPORTION: Final = 1.7
"""Long by short side of a border, at most; A4 within margins of GB/T 14689 has 1.59."""
_MARGIN_PART: Final = 0.15
"""Distance of the edge of the paper by the border's short side, at most; 25 mm on A4."""
_BLOCK_PART: Final = 0.4
"""Area of a title block by that of its border, at most."""
_LINES: Final = 5
"""Lines from which on a block is a title block in any rectangle."""
_TEXTS: Final = 3
"""Texts of it, at least."""
_FEWEST_LINES: Final = 2
"""Lines of a block that may be a title block, at least: two sides, as two are the border's."""
_SMALL_LINES: Final = 3
"""Lines from which on it is one in a rectangle as large as paper within margins."""
_SMALL_TEXTS: Final = 2
"""Texts of it, at least."""
_LOOSE_LINES: Final = 3
"""Lines of a title block that touches no border, at least, along each axis: sides and another."""
_LOOSE_CELLS: Final = 3
"""Its cells with texts, at least."""
_LOW_CELL: Final = 30.0
"""mm of their short side, at most."""
_TEXTS_OF_TABLE: Final = 20
"""Texts from which on a block of any size is a table, such as a list of parts."""
_SMALL_BLOCK_PART: Final = 0.25
"""Area of a block by that of its border up to which all in it belongs to it, such as a logo."""
_CELL_PART: Final = 0.04
"""The same for a single cell of a larger block."""
_SHORT_OF: Final = 1.0
"""mm by which lines of a title block may end short of the border."""
_BESIDE: Final = 0.5
"""mm that curves in a cell may project over its lines, as those drawn by hand do."""
_MARK_PART: Final = 0.1
"""Length of a mark by the border's short side, at most."""
_MOST_LINES: Final = 50_000
"""Lines along the axes up to which sheets are searched for."""
_BOX_PARTS: Final = (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0)
"""Parts of a curve at which it is sampled for its box."""
_DOWN: Final = (0.0, 0.0, -1.0)

_Ids = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Sheet:
    """Border of a sheet.

    rows: of its curves and those of the title block. size: mm of the rectangle. what: what shows
    that it is a sheet, in words. sure: False if it may be a part as well. ending: rows of further
    lines that end on the border.
    """

    rows: frozenset[int]
    size: tuple[float, float]
    what: str
    sure: bool = True
    ending: frozenset[int] = frozenset()

    @property
    def text(self) -> str:
        """Size in words: `390 x 277`."""
        return " x ".join(f"{length:.5g}" for length in self.size)


def find_sheets(
    curves: Sequence[Curve], aside: Sequence[Curve], texts: Floats, back: Pose, *, annotated: bool
) -> list[Sheet]:
    """Return the sheets of paper that curves draw.

    aside: further curves, drafting by their names; their rows come after those of `curves`. texts:
    (n, 2) positions of texts, mm in the drawing's world. back: from the frame of the curves to that
    world. annotated: True if the drawing has texts, dimensions or leaders.
    """
    page = _Page.of([*curves, *aside], back)
    if page is None:
        return []
    found: list[Sheet] = []
    taken: set[int] = set()
    known: list[_Rectangle] = []
    doubtful: list[tuple[_Rectangle, set[int]]] = []
    rectangles = sorted(page.rectangles(), key=lambda one: one.area)
    for border in rectangles:
        if border.rows & taken:
            continue
        rows, sure = _with_title_block(page, border, rectangles, texts)
        if not rows:
            continue
        rows |= _around(page, border, rectangles)
        if not sure:
            doubtful.append((border, rows))
            continue
        taken |= rows
        known.append(border)
        ending = _ending(page, border, rows)
        found.append(Sheet(frozenset(rows), border.size, "with a title block", ending=ending))
    if not found and annotated:
        # The edge of the paper comes before a border inside it.
        for edge in reversed(rectangles):
            if (_paper(edge) or _framed(edge) or _has_proportion(edge)) and page.holds_all(edge):
                found = list(_bare_sheet(page, edge, rectangles, len(curves)))
                known += [edge] if found else []
                break
    # What is drawn in a sheet, or in a rectangle that is asked about, is asked about no more.
    for border, rows in reversed(doubtful):
        if not any(one.holds(border) for one in known):
            known.append(border)
            found.append(Sheet(frozenset(rows), border.size, _DOUBTFUL, sure=False))
    taken = {row for one in found for row in one.rows}
    return [*found, *_loose_tables(page, taken, texts)]


_DOUBTFUL: Final = "lines in its corner, as of a title block"
_LOOSE_TABLE: Final = "low cells with texts, as of a title block"


@dataclass(frozen=True, slots=True)
class _Rectangle:
    """Rectangle along the axes. low, high: mm of two corners. rows: of the curves of its sides."""

    low: tuple[float, float]
    high: tuple[float, float]
    rows: frozenset[int]

    @property
    def size(self) -> tuple[float, float]:
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def area(self) -> float:
        width, height = self.size
        return width * height

    def margins(self, inner: _Rectangle) -> tuple[float, ...]:
        """Return the distances (mm) from its sides to those of a rectangle inside it."""
        return (
            *(b - a for a, b in zip(self.low, inner.low, strict=True)),
            *(a - b for a, b in zip(self.high, inner.high, strict=True)),
        )

    def holds(self, inner: _Rectangle) -> bool:
        """True if another one is inside it or on its sides."""
        return min(self.margins(inner)) >= -_TOUCH

    def is_edge_of(self, border: _Rectangle) -> bool:
        """True if it encloses a border within the margins of paper."""
        margins = self.margins(border)
        return min(margins) > _TOUCH and max(margins) <= _MARGIN_PART * min(border.size)


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Line along an axis, of curves that follow each other.

    upright: True if along y. at: its other coordinate, mm. low, high: its ends, mm. rows: of the
    curves.
    """

    upright: bool
    at: float
    low: float
    high: float
    rows: frozenset[int]

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        if self.upright:
            return (self.at, self.low), (self.at, self.high)
        return (self.low, self.at), (self.high, self.at)

    def has(self, point: tuple[float, float]) -> bool:
        across, along = point if self.upright else point[::-1]
        return abs(across - self.at) <= _TOUCH and self.low - _TOUCH <= along <= self.high + _TOUCH

    def meets(self, other: _Stretch) -> bool:
        """True if an end of one is on the other; lines that only cross do not meet."""
        return any(map(self.has, other.ends)) or any(map(other.has, self.ends))


@dataclass(slots=True)
class _Page:
    """Curves of a drawing. low, high: (n, 2) mm of their boxes. stretches: lines along the axes."""

    curves: Sequence[Curve]
    low: Floats
    high: Floats
    stretches: list[_Stretch]

    @staticmethod
    def of(curves: Sequence[Curve], back: Pose) -> _Page | None:
        """Return the page of curves, None if they cannot draw a sheet. back: see `find_sheets`."""
        if len(curves) < 4:
            return None
        points = sample(curves, _BOX_PARTS)
        flat = back.moved(points.reshape(-1, 3))[:, :2].reshape(len(curves), -1, 2)
        low, high = flat.min(axis=1), flat.max(axis=1)
        straight = np.array([isinstance(curve, Line) for curve in curves])
        thin = (high - low) <= _TOUCH
        along = straight & (thin.sum(axis=1) == 1) & np.isfinite(low + high).all(axis=1)
        long = (high - low).max(axis=1) >= _SHORTEST_SIDE / 10.0
        if not 4 <= int(along.sum()) <= _MOST_LINES or not bool((along & long).any()):
            return None
        stretches: list[_Stretch] = []
        for upright in (False, True):
            rows = np.flatnonzero(along & thin[:, 0 if upright else 1])
            stretches += _merged(rows, low, high, upright=upright)
        return _Page(curves, low, high, stretches)

    def rectangles(self) -> Iterator[_Rectangle]:
        """Yield rectangles in the proportion of sheets, of four lines that end at the corners."""
        sides = [one for one in self.stretches if one.high - one.low >= _SHORTEST_SIDE]
        level = {_keys(one): one for one in sides if not one.upright}
        upright = {_keys(one): one for one in sides if one.upright}
        above: dict[tuple[int, int], list[_Stretch]] = defaultdict(list)
        for one in upright.values():
            above[_key(one.ends[0])].append(one)
        for bottom in level.values():
            for left in above.get(_key(bottom.ends[0]), ()):
                right = upright.get(_keys(_moved(left, bottom.high)))
                top = level.get(_keys(_moved(bottom, left.high)))
                if right is None or top is None:
                    continue
                rows = bottom.rows | left.rows | right.rows | top.rows
                made = _Rectangle((left.at, bottom.at), (right.at, top.at), rows)
                short, long = sorted(made.size)
                if short >= _SHORTEST_SIDE and long <= _WIDEST_PROPORTION * short:
                    yield made

    def inside(self, box: _Rectangle, off: float = _TOUCH) -> NDArray[np.bool_]:
        """Return a flag for each curve: True if it is in a rectangle or on its sides."""
        return np.asarray(
            (self.low >= np.array(box.low) - off).all(axis=1)
            & (self.high <= np.array(box.high) + off).all(axis=1)
        )

    def beyond(self, box: _Rectangle) -> NDArray[np.bool_]:
        """Return a flag for each curve: True if it is outside a rectangle or on its sides."""
        low, high = np.array(box.low) + _TOUCH, np.array(box.high) - _TOUCH
        return np.asarray((self.high <= low).any(axis=1) | (self.low >= high).any(axis=1))

    def crossing(self, box: _Rectangle) -> list[int]:
        """Return the rows of curves that are partly in a rectangle and partly outside."""
        return np.flatnonzero(~(self.inside(box) | self.beyond(box))).tolist()

    def holds_all(self, box: _Rectangle) -> bool:
        """True if all other curves are in a rectangle, and only marks touch its sides."""
        others = np.ones(len(self.curves), dtype=bool)
        others[list(box.rows)] = False
        touching = np.flatnonzero(others & ~self.inside(box, -_TOUCH)).tolist()
        return (
            bool(others.any())
            and bool(self.inside(box)[touching].all())
            and all(self.is_short(row, _MARK_PART * min(box.size)) for row in touching)
        )

    def is_short(self, row: int, most: float) -> bool:
        """True if a curve is a line along an axis, at most `most` mm long."""
        size = self.high[row] - self.low[row]
        straight = isinstance(self.curves[row], Line)
        return straight and float(size.min()) <= _TOUCH and float(size.max()) <= most


def _merged(rows: _Ids, low: Floats, high: Floats, *, upright: bool) -> Iterator[_Stretch]:
    """Yield lines of one direction; those that follow each other or overlap are one."""
    along, across = (1, 0) if upright else (0, 1)
    at = low[rows, across]
    order = np.lexsort((low[rows, along], np.round((at + _SHIFT) / (4.0 * _TOUCH))))
    group: list[int] = []
    end = 0.0
    for row in rows[order].tolist():
        starts = group and (
            abs(low[row, across] - low[group[0], across]) > _TOUCH or low[row, along] > end + _TOUCH
        )
        if starts:
            yield _stretch(group, low, high, end, upright=upright)
            group = []
        end = max(end, float(high[row, along])) if group else float(high[row, along])
        group.append(row)
    if group:
        yield _stretch(group, low, high, end, upright=upright)


def _stretch(
    rows: Sequence[int], low: Floats, high: Floats, end: float, *, upright: bool
) -> _Stretch:
    along, across = (1, 0) if upright else (0, 1)
    first = rows[0]
    at = 0.5 * float(low[first, across] + high[first, across])
    return _Stretch(upright, at, float(low[first, along]), end, frozenset(rows))


def _moved(side: _Stretch, at: float) -> _Stretch:
    """Return a side moved across to another coordinate, without curves."""
    return _Stretch(side.upright, at, side.low, side.high, frozenset())


def _key(point: tuple[float, float]) -> tuple[int, int]:
    """Return a key that points which meet within rounding have in common."""
    x, y = (round((part + _SHIFT) / (4.0 * _TOUCH)) for part in point)
    return x, y


def _keys(side: _Stretch) -> tuple[int, ...]:
    """Return the keys of both ends of a line."""
    first, last = side.ends
    return (*_key(first), *_key(last))


def _with_title_block(
    page: _Page, border: _Rectangle, rectangles: Sequence[_Rectangle], texts: Floats
) -> tuple[set[int], bool]:
    """Return the rows of a border and its title block, and if it is one for sure.

    There are none if it has no title block.
    """
    most = _MARK_PART * min(border.size)
    marks = page.crossing(border)
    if not all(page.is_short(row, most) for row in marks):
        return set(), False
    edges = [one for one in rectangles if one.is_edge_of(border)]
    on_paper = any(map(_paper, edges))
    framed = on_paper or bool(_framed(border))
    as_paper = framed or bool(_paper(border))
    blocks = list(_blocks(page, border))
    titles = [
        *(one for one in blocks if _may_be_title_block(one, border, texts, as_paper=as_paper)),
        *(one for one in blocks if as_paper and _is_strip(page, one, border, texts)),
    ]
    if not titles:
        return set(), False
    drawn = framed or any(_has_proportion(one) and _has_even_margins(one, border) for one in edges)
    lines, least = (_SMALL_LINES, _SMALL_TEXTS) if drawn else (_LINES, _TEXTS)
    sure = on_paper or any(
        _is_title_block(block, border, texts, lines, least)
        and (drawn or _labelled_low_cells(block, border, texts) >= least)
        # Lines that only cross each other are several blocks.
        for block in (*titles, [line for each in titles for line in each])
    )
    rows = set(border.rows) | set(marks)
    for block in blocks:
        if block in titles or _is_table(block, border, texts):
            rows |= {row for one in block for row in one.rows}
            rows |= _in_cells(page, block, border) if _texts_in(block, texts) else set()
        elif len(block) == 1 and block[0].high - block[0].low <= most:
            rows |= block[0].rows  # a mark of the middle
    return rows, sure


def _blocks(page: _Page, border: _Rectangle) -> Iterator[list[_Stretch]]:
    """Yield groups of lines inside a border that meet each other and its sides."""
    within = page.inside(border)
    inner = [
        one
        for one in page.stretches
        if not one.rows & border.rows and all(within[row] for row in one.rows)
    ]
    (left, bottom), (right, top) = border.low, border.high
    sides = [
        *(_Stretch(True, x, bottom, top, frozenset()) for x in (left, right)),
        *(_Stretch(False, y, left, right, frozenset()) for y in (bottom, top)),
    ]
    for block in _groups(inner):
        if any(one.meets(side) for one in block for side in sides) or _is_open_near(block, sides):
            yield block


def _is_open_near(block: Sequence[_Stretch], sides: Sequence[_Stretch]) -> bool:
    """True if lines of a block end short of two sides of a border, as those drawn by hand do."""
    reached = set()
    for one in block:
        for end in one.ends:
            at = end[1] if one.upright else end[0]
            near = {
                number
                for number, side in enumerate(sides)
                if side.upright != one.upright and abs(at - side.at) <= _SHORT_OF
            }
            if near and not any(other is not one and other.has(end) for other in block):
                reached |= near
    return len(reached) > 1


def _groups(lines: Sequence[_Stretch]) -> Iterable[list[_Stretch]]:
    """Return groups of lines that meet each other."""
    parent = list(range(len(lines)))

    def root(row: int) -> int:
        while parent[row] != row:
            parent[row] = parent[parent[row]]
            row = parent[row]
        return row

    for a, b in _near_pairs(lines):
        if lines[a].meets(lines[b]):
            parent[root(a)] = root(b)
    groups: dict[int, list[_Stretch]] = defaultdict(list)
    for row, one in enumerate(lines):
        groups[root(row)].append(one)
    return groups.values()


def _ending(page: _Page, border: _Rectangle, rows: Set[int]) -> frozenset[int]:
    """Return the rows of lines that end on the sides of a border, but those of `rows`."""
    blocks = _blocks(page, border)
    return frozenset(row for block in blocks for one in block for row in one.rows) - rows


def _loose_tables(page: _Page, taken: Set[int], texts: Floats) -> Iterator[Sheet]:
    """Yield tables that no border holds: lines with a text in each of some low cells.

    They may be parts beside each other as well, with labels.
    """
    if len(texts) < _LOOSE_CELLS:
        return
    for block in _groups([one for one in page.stretches if not one.rows & taken]):
        ways = [one.upright for one in block]
        # Along one axis they may be lines at which a plate is bent.
        if min(ways.count(True), ways.count(False)) < _LOOSE_LINES:
            continue
        if _texts_in(block, texts) < _LOOSE_CELLS:
            continue
        if _labelled_low_cells(block, None, texts) >= _LOOSE_CELLS:
            rows = frozenset(row for one in block for row in one.rows)
            corner, far = _box(block)
            yield Sheet(rows, tuple((far - corner).tolist()), _LOOSE_TABLE, sure=False)


def _labelled_low_cells(block: Sequence[_Stretch], border: _Rectangle | None, texts: Floats) -> int:
    """Return how many low cells of a block, closed by a border if given, have a text in them."""
    import shapely

    lines = list(shapely.linestrings([one.ends for one in block]))
    if border is not None:
        lines.append(shapely.box(*border.low, *border.high).exterior)
    cells = shapely.get_parts(shapely.polygonize([shapely.union_all(lines, grid_size=_TOUCH)]))
    bounds = shapely.bounds(cells)
    low = (bounds[:, 2:] - bounds[:, :2]).min(axis=1, initial=np.inf) <= _LOW_CELL
    found = shapely.STRtree(shapely.points(texts)).query(cells[low], "intersects")
    return len(np.unique(found[0]))


def _near_pairs(lines: Sequence[_Stretch]) -> Iterable[tuple[int, int]]:
    """Return the pairs of lines whose boxes meet, by their indices."""
    if not lines:
        return ()
    import shapely

    ends = np.array([one.ends for one in lines])
    boxes = shapely.box(*(ends[:, 0] - _TOUCH).T, *(ends[:, 1] + _TOUCH).T)
    first, second = shapely.STRtree(boxes).query(boxes)
    return zip(*(rows[first < second].tolist() for rows in (first, second)), strict=True)


def _box(block: Sequence[_Stretch]) -> tuple[Floats, Floats]:
    ends = np.array([one.ends for one in block])
    return ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)


def _texts_in(block: Sequence[_Stretch], texts: Floats) -> int:
    low, high = _box(block)
    return int(((texts >= low) & (texts <= high)).all(axis=1).sum())


def _is_table(block: Sequence[_Stretch], border: _Rectangle, texts: Floats) -> bool:
    """True if texts are between the lines of a block that leaves room for a part, or very many."""
    low, high = _box(block)
    count = _texts_in(block, texts)
    small = float((high - low).prod()) <= _BLOCK_PART * border.area
    return (small and count >= 2) or count >= max(_TEXTS_OF_TABLE, len(block) // 2)


def _is_title_block(
    block: Sequence[_Stretch], border: _Rectangle, texts: Floats, lines: int, least: int
) -> bool:
    """True if a block is a table in a corner of the border. lines, least: of texts, at least."""
    return (
        len(block) >= lines
        and _is_table(block, border, texts)
        and _is_in_corner(block, border)
        and _texts_in(block, texts) >= least
    )


def _may_be_title_block(
    block: Sequence[_Stretch], border: _Rectangle, texts: Floats, *, as_paper: bool
) -> bool:
    """True if a block in a corner may be a title block. as_paper: the border has a sheet's size."""
    if len(block) < _FEWEST_LINES or not _is_in_corner(block, border):
        return False
    low, high = _box(block)
    if float((high - low).prod()) > _BLOCK_PART * border.area:
        return _is_title_block(block, border, texts, _LINES, _TEXTS)
    count = _texts_in(block, texts)
    return as_paper or count >= _SMALL_TEXTS or (count > 0 and len(block) >= _SMALL_LINES)


def _is_in_corner(block: Sequence[_Stretch], border: _Rectangle) -> bool:
    low, high = _box(block)
    near = [
        np.abs(low - np.array(border.low)) <= _SHORT_OF,
        np.abs(high - np.array(border.high)) <= _SHORT_OF,
    ]
    return bool((near[0] | near[1]).all())


def _is_strip(page: _Page, block: Sequence[_Stretch], border: _Rectangle, texts: Floats) -> bool:
    """True if one line divides a strip off the border in which only texts are."""
    if len(block) > 1:
        return False
    line = block[0]
    across, along = (0, 1) if line.upright else (1, 0)
    if line.high - line.low < border.size[along] - 2.0 * _TOUCH:
        return False
    low, high = list(border.low), list(border.high)
    if line.at - low[across] < high[across] - line.at:
        high[across] = line.at
    else:
        low[across] = line.at
    strip = _Rectangle((low[0], low[1]), (high[0], high[1]), frozenset())
    count = int(((texts >= strip.low) & (texts <= strip.high)).all(axis=1).sum())
    filled = page.inside(strip) & ~page.beyond(strip)
    return (
        strip.area <= _SMALL_BLOCK_PART * border.area and count >= _SMALL_TEXTS and not filled.any()
    )


def _in_cells(page: _Page, block: Sequence[_Stretch], border: _Rectangle) -> set[int]:
    """Return the rows of curves in small cells of a block."""
    import shapely

    (left, bottom), (right, top) = border.low, border.high
    around = shapely.box(left, bottom, right, top).exterior
    low, high = _box(block)
    ends = np.array([one.ends for one in block])
    # Lines that end short of the border are taken to it.
    for at, side in ((0, left), (0, right), (1, bottom), (1, top)):
        near = np.abs(ends[:, :, at] - side) <= _SHORT_OF
        ends[:, :, at][near] = side
    lines = shapely.union_all([*shapely.linestrings(ends), around], grid_size=_TOUCH)
    small = float((high - low).prod()) <= _SMALL_BLOCK_PART * border.area
    # The room for the part is no cell of the block: it is outside the block's box.
    within = shapely.box(*(low - _TOUCH), *(high + _TOUCH))
    cells = [
        one
        for one in shapely.polygonize([lines]).geoms
        if one.area <= _CELL_PART * border.area or (small and within.covers(one))
    ]
    if not cells:
        return set()
    room = shapely.union_all(cells).buffer(_BESIDE, join_style="mitre")
    rows = np.flatnonzero(page.inside(border))
    boxes = shapely.box(*page.low[rows].T, *page.high[rows].T)
    shapely.prepare(room)
    return set(rows[shapely.covers(room, boxes)].tolist())


def _around(page: _Page, border: _Rectangle, rectangles: Sequence[_Rectangle]) -> set[int]:
    """Return the rows of the edges of the paper around a border, and of the curves between."""
    rows: set[int] = set()
    edge = border
    for one in rectangles:
        if one.is_edge_of(border) and all(
            page.is_short(row, _MARK_PART * min(border.size)) for row in page.crossing(one)
        ):
            rows |= one.rows
            edge = one
    if edge is not border:
        return rows | set(np.flatnonzero(page.inside(edge) & page.beyond(border)).tolist())
    # Marks for cutting the paper: lines at the corners of a rectangle that is not drawn.
    far = _MARGIN_PART * min(border.size)
    room = page.inside(border, far) & page.beyond(border) & ~page.inside(border)
    lines = [row for row in np.flatnonzero(room).tolist() if page.is_short(row, np.inf)]
    if not lines:
        return rows
    low, high = page.low[lines].min(axis=0), page.high[lines].max(axis=0)
    paper = _Rectangle((low[0], low[1]), (high[0], high[1]), frozenset())
    if not paper.is_edge_of(border):
        return rows
    on_edge = (page.high[lines] <= low + _TOUCH) | (page.low[lines] >= high - _TOUCH)
    return rows | set(lines) if bool(on_edge.any(axis=1).all()) else rows


def _paper(box: _Rectangle) -> str:
    """Return the name of the sheet that has the size of a rectangle, empty if none has it."""
    short, long = sorted(box.size)
    for name, (width, height) in _SIZES.items():
        if abs(short - width) <= _SIZE_PART * width and abs(long - height) <= _SIZE_PART * height:
            return name
    return ""


def _framed(box: _Rectangle) -> str:
    """Return the name of the sheet that has a rectangle within its margins, empty if none has."""
    short, long = sorted(box.size)
    for name, (width, height) in _SIZES.items():
        inches = name.startswith("ANSI")
        for margins in _MARGINS_IN_INCHES if inches else _MARGINS:
            for first, second in (margins, margins[::-1]):
                unit = 25.4 if inches else 1.0
                off = (width - first * unit - short, height - second * unit - long)
                if max(map(abs, off)) <= _MARGIN_OFF:
                    return f"{name} within margins"
    return ""


def _has_proportion(box: _Rectangle) -> bool:
    """True if a rectangle has the proportion of sheets of ISO 216 or of ANSI Y14.1."""
    short, long = sorted(box.size)
    return any(abs(long / short - one) <= _PROPORTION_PART * one for one in _PROPORTIONS)


def _has_even_margins(edge: _Rectangle, border: _Rectangle) -> bool:
    """True if a border is as far from each side of an edge, or farther from one for binding."""
    first, _, third, _ = sorted(edge.margins(border))
    return third - first <= _EVEN_PART * first


def _bare_sheet(
    page: _Page, edge: _Rectangle, rectangles: Sequence[_Rectangle], work: int
) -> Iterator[Sheet]:
    """Yield the one sheet without a title block, if an edge is one.

    work: number of curves that are not drafting by their names; these come first.
    """
    inside = [row for row in range(len(page.curves)) if row not in edge.rows]
    name = _paper(edge)
    for border in rectangles:
        if edge.is_edge_of(border) and not page.crossing(border):
            if not name and not _has_even_margins(edge, border):
                continue
            between = set(np.flatnonzero(page.beyond(border)).tolist()) - edge.rows
            marks = between - border.rows
            left = [row for row in inside if row not in between and row not in border.rows]
            if left and all(page.is_short(row, np.inf) for row in marks):
                rows = edge.rows | border.rows | between
                what = f"{name} with a border" if name else "two frames of a sheet"
                ending = _ending(page, border, rows)
                # A plate may have any proportion, and an even rim.
                sure = bool(name or marks) or _holds_parts(page, left, work, bored=True)
                yield Sheet(frozenset(rows), edge.size, what, sure=sure, ending=ending)
                return
    name = name or _framed(edge)
    if not name:
        return
    nested = _holds_parts(page, inside, work)
    what = f"{name} around parts with holes" if nested else name
    yield Sheet(edge.rows, edge.size, what, sure=nested)


def _holds_parts(page: _Page, rows: Sequence[int], work: int, *, bored: bool = False) -> bool:
    """True if some contours are parts with holes: they would be loose in a part around them.

    bored: a circle around others may be a counterbore instead.
    """
    contours = chain_curves([page.curves[row] for row in rows if row < work], _TOUCH)[0]
    around = (contours[row] for row in holders(contours, _DOWN, _TOUCH) if row != NO_HOLDER)
    return any(not bored or not _is_circle(one.curves) for one in around)


def _is_circle(curves: Sequence[Curve]) -> bool:
    return len(curves) == 1 and isinstance(curves[0], Arc)
