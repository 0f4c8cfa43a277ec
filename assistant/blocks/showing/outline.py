"""A diagram as boxes in columns and wires between them; ours and those of bdsim."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any


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
        """Whether a wire leads back, or stays in its column."""
        return self.boxes[wire.end].column <= self.boxes[wire.start].column


def lay_out(diagram: Any) -> Outline:
    """Of a `Diagram`, or of a block diagram of bdsim; blocks in the order in which signals go."""
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
