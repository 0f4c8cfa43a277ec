"""Pictures and tables of block diagrams and of their runs, for notebooks and pages.

A diagram, ours or of bdsim, is laid out as boxes in columns with wires between them. matplotlib
(extra `plot`) draws it; without it there is no picture.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Protocol

from assistant.base.arrays import Floats
from assistant.base.columns import columns_html
from assistant.base.data_classes import dataclass
from assistant.base.source_text import visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Box:
    """name, kind: of a block. inputs, outputs: names of its ports. column, row: where it is drawn,
    rows of a column from 0 downwards.
    """

    name: str
    kind: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    column: int = 0
    row: float = 0.0


@dataclass(frozen=True, slots=True)
class Wire:
    """start, end: numbers of boxes. output, input: of their ports."""

    start: int
    output: int
    end: int
    input: int


@dataclass(frozen=True, slots=True)
class Outline:
    """boxes, and the wires between them."""

    boxes: tuple[Box, ...]
    wires: tuple[Wire, ...]

    def back(self, wire: Wire) -> bool:
        """True if a wire leads back or stays in its column."""
        return self.boxes[wire.end].column <= self.boxes[wire.start].column


def lay_out(diagram: Any) -> Outline:
    """Lay out a `Diagram` or a block diagram of bdsim, with blocks in the order of the signal
    flow.
    """
    boxes, wires = (
        _boxes_of_bdsim(diagram) if hasattr(diagram, "blocklist") else _boxes_of_ours(diagram)
    )
    columns = _column_numbers(len(boxes), wires)
    rows = _row_positions(columns, wires)
    placed = tuple(
        Box(box.name, box.kind, box.inputs, box.outputs, column, row)
        for box, column, row in zip(boxes, columns, rows, strict=True)
    )
    return Outline(placed, tuple(wires))


def _boxes_of_ours(diagram: Any) -> tuple[list[Box], list[Wire]]:
    number = {block: i for i, block in enumerate(diagram.blocks)}
    boxes = [
        Box(
            block.name,
            type(block).__name__,
            tuple(port.name for port in block.inputs),
            tuple(port.name for port in block.outputs),
        )
        for block in diagram.blocks
    ]
    wires = [
        Wire(number[start], output, number[end], input)
        for (start, output), (end, input) in diagram.wires
    ]
    return boxes, wires


def _boxes_of_bdsim(diagram: Any) -> tuple[list[Box], list[Wire]]:
    number = {id(block): i for i, block in enumerate(diagram.blocklist)}
    boxes = []
    for block in diagram.blocklist:
        inner = getattr(block, "_inner", None)  # of a block of ours
        inputs = [""] * block.nin if inner is None else [port.name for port in inner.inputs]
        outputs = [""] * block.nout if inner is None else [port.name for port in inner.outputs]
        boxes.append(Box(str(block.name), type(block).__name__, tuple(inputs), tuple(outputs)))
    wires = [
        Wire(number[id(one.start.block)], one.start.port, number[id(one.end.block)], one.end.port)
        for one in diagram.wirelist
    ]
    return boxes, wires


def _column_numbers(count: int, wires: Sequence[Wire]) -> list[int]:
    """The longest way to each box from one without inputs, wires that close a loop left out."""
    following: dict[int, list[int]] = {i: [] for i in range(count)}
    fed = set()
    for wire in wires:
        following[wire.start].append(wire.end)
        fed.add(wire.end)
    order: list[int] = []
    state = [0] * count  # 1: on the way to it, 2: done
    forward: dict[int, list[int]] = {i: [] for i in range(count)}
    for root in sorted(range(count), key=lambda i: i in fed):
        _visit(root, following, state, forward, order)
    columns = [0] * count
    for box in reversed(order):
        for after in forward[box]:
            columns[after] = max(columns[after], columns[box] + 1)
    # What has no inputs stands before what it feeds.
    for box in range(count):
        if box not in fed and forward[box]:
            columns[box] = max(0, min(columns[after] for after in forward[box]) - 1)
    return columns


def _visit(
    root: int,
    following: Mapping[int, Sequence[int]],
    state: list[int],
    forward: Mapping[int, list[int]],
    order: list[int],
) -> None:
    if state[root]:
        return
    state[root] = 1
    stack = [(root, iter(following[root]))]
    while stack:
        box, rest = stack[-1]
        after = next(rest, None)
        if after is None:
            state[box] = 2
            order.append(box)
            stack.pop()
            continue
        if state[after] == 1:
            continue
        forward[box].append(after)
        if not state[after]:
            state[after] = 1
            stack.append((after, iter(following[after])))


def _row_positions(columns: Sequence[int], wires: Sequence[Wire]) -> list[float]:
    """Each column about the middle, its boxes in the order of what leads to them."""
    rows = [0.0] * len(columns)
    for column in range(max(columns, default=0) + 1):
        members = [i for i, c in enumerate(columns) if c == column]
        before = {
            i: [
                rows[w.start] + 0.1 * w.output
                for w in wires
                if w.end == i and columns[w.start] < column
            ]
            for i in members
        }
        members.sort(key=lambda i: sum(before[i]) / len(before[i]) if before[i] else 0.0)
        for place, i in enumerate(members):
            rows[i] = place - (len(members) - 1) / 2.0
    return rows


class RecordedSignals(Protocol):
    """seconds: (n,) of the steps. columns: (n, k) by the name of the signal."""

    @property
    def seconds(self) -> Floats: ...

    @property
    def columns(self) -> Mapping[str, Floats]: ...


def signals_html(ran: RecordedSignals) -> str:
    """Signals in columns, below what the run says of itself."""
    return columns_html(repr(ran)[1:-1], {"s": ran.seconds, **ran.columns})


_DPI: Final = 80
_BOX_WIDTH: Final = 1.0
_BOX_HEIGHT: Final = 0.62
_COLUMN_SPACING: Final = 1.75
"""Width and height of a box, and from one column of them to the next; from row to row 1."""
_LINE_COLOUR: Final = "#1f5f8b"
_FILL_COLOUR: Final = "#eef4f8"
_MOST_SIGNALS: Final = 8
_MOST_DRAWN_ROWS: Final = 4000
"""Rows of a run that are drawn; of more rows every second, third … is drawn."""
_MOST_BOXES: Final = 300
"""Blocks of a diagram that is drawn: a picture of more is as wide as a wall, and takes minutes."""


def diagram_png(diagram: Any) -> bytes | None:
    """A diagram of ours or of bdsim; None without matplotlib, and of more than `_MOST_BOXES`."""
    found = lay_out(diagram)
    if len(found.boxes) > _MOST_BOXES:
        return None
    columns = max((box.column for box in found.boxes), default=0) + 1
    figure = _figure(1.6 * columns, 0.9 * _picture_height(found))
    if figure is None:
        return None
    draw_diagram(figure.subplots(), found)
    return _png(figure)


def run_png(ran: RecordedSignals) -> bytes | None:
    """The first signals of a run over time, one below the other; None without matplotlib."""
    names = list(ran.columns)[:_MOST_SIGNALS]
    figure = _figure(8.0, 1.1 * max(len(names), 1) + 0.5)
    if figure is None:
        return None
    if names:
        below = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        draw_signals(list(below), ran, names)
    return _png(figure)


def draw_diagram(axes: Axes, diagram: Any) -> None:
    """Boxes and wires into axes. diagram: an `Outline`, or what `lay_out` takes."""
    found = diagram if isinstance(diagram, Outline) else lay_out(diagram)
    lowest = max((box.row for box in found.boxes), default=0.0)
    for number, wire in enumerate(found.wires):
        _draw_wire(axes, found, wire, lowest + 0.55 + 0.09 * number)
    for box in found.boxes:
        _draw_box(axes, box)
    axes.set_aspect("equal")
    axes.invert_yaxis()
    axes.autoscale_view()
    axes.axis("off")


def draw_signals(all_axes: Sequence[Axes], ran: RecordedSignals, names: Sequence[str]) -> None:
    """Draw each signal of a run over time into separate axes."""
    every = slice(None, None, max(1, len(ran.seconds) // _MOST_DRAWN_ROWS))
    for axes, name in zip(all_axes, names, strict=True):
        axes.plot(ran.seconds[every], ran.columns[name][every], lw=1.1)
        axes.set_title(_escaped_name(name), fontsize=8, loc="left", pad=2)
        axes.tick_params(labelsize=7)
        axes.grid(alpha=0.3)
    if len(all_axes):
        all_axes[-1].set_xlabel("seconds", fontsize=8)


def _figure(width: float, height: float) -> Figure | None:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return None
    return Figure(figsize=(width, height), layout="constrained")


def _png(figure: Figure) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=_DPI, metadata={"Software": None})
    return out.getvalue()


def _escaped_name(name: str) -> str:
    """A name as matplotlib shows it as it is: between dollars it would read a formula."""
    return visible(name).replace("$", r"\$")


def _picture_height(found: Outline) -> float:
    rows = [box.row for box in found.boxes] or [0.0]
    back = sum(found.back(wire) for wire in found.wires)
    return max(rows) - min(rows) + 1.2 + (0.4 if back else 0.0)


def _draw_box(axes: Axes, box: Box) -> None:
    from matplotlib.patches import FancyBboxPatch

    left, top = _COLUMN_SPACING * box.column, box.row - _BOX_HEIGHT / 2.0
    style = "round,pad=0,rounding_size=0.06"
    axes.add_patch(
        FancyBboxPatch(
            (left, top),
            _BOX_WIDTH,
            _BOX_HEIGHT,
            boxstyle=style,
            fc=_FILL_COLOUR,
            ec=_LINE_COLOUR,
            lw=1.2,
            zorder=2,
        )
    )
    middle = left + _BOX_WIDTH / 2.0
    axes.text(
        middle,
        box.row - 0.07,
        _escaped_name(box.name),
        ha="center",
        va="center",
        fontsize=7,
        zorder=3,
    )
    kind = "" if box.kind.lower() == box.name.lower() else _escaped_name(box.kind)
    axes.text(
        middle, box.row + 0.14, kind, ha="center", va="center", fontsize=5.5, color="0.4", zorder=3
    )


def _port_position(box: Box, number: int, *, output: bool) -> tuple[float, float]:
    """Return the position of a port on the edge of its box."""
    count = max(len(box.outputs if output else box.inputs), number + 1)
    y = box.row + _BOX_HEIGHT * ((number + 1) / (count + 1) - 0.5)
    return _COLUMN_SPACING * box.column + (_BOX_WIDTH if output else 0.0), y


def _draw_wire(axes: Axes, found: Outline, wire: Wire, below: float) -> None:
    """Straight to the next box; one that leads back goes below all of them."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    one, other = found.boxes[wire.start], found.boxes[wire.end]
    (x, y), (u, v) = (
        _port_position(one, wire.output, output=True),
        _port_position(other, wire.input, output=False),
    )
    if found.back(wire):
        points = [(x, y), (x + 0.2, y), (x + 0.2, below), (u - 0.2, below), (u - 0.2, v), (u, v)]
        path = Path(points)
    else:
        bend = 0.5 * min(u - x, 1.0)
        codes = [Path.MOVETO, Path.CURVE4, Path.CURVE4, Path.CURVE4]
        path = Path([(x, y), (x + bend, y), (u - bend, v), (u, v)], codes)
    axes.add_patch(PathPatch(path, fill=False, ec="0.35", lw=0.9, zorder=1))
    axes.plot([u], [v], marker=">", color="0.35", ms=3, zorder=3)
    names = one.outputs
    if len(names) > 1 and names[wire.output]:
        axes.text(
            x + 0.04,
            y - 0.03,
            _escaped_name(names[wire.output]),
            fontsize=5,
            color="0.35",
            va="bottom",
        )
