"""A program in another cell: its text with the tools and frames that stand elsewhere there."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from assistant.base.diagnostics import Span
from assistant.base.source_text import SourceText
from assistant.languages.rapid.tree import syntax as rapid
from assistant.languages.rapid.tree.literals import carrying_unit, still_frame_name
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.geometry import Frame, Pose


@dataclass(frozen=True, slots=True)
class Cell:
    """tools: their tips, by name in lower case. frames: of work pieces. standing: of what
    mechanical units carry, which stand still.
    """

    tools: Mapping[str, Pose] = field(default_factory=dict)
    frames: Mapping[str, Frame] = field(default_factory=dict)
    standing: Mapping[str, Pose] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.tools or self.frames or self.standing)


def with_equipment(family: str, tree: object, cell: Cell) -> tuple[SourceText, set[str]]:
    """The text of a file with the values of a cell, and the names of those that it declares."""
    assert isinstance(tree, rapid.File) or hasattr(tree, "source")
    source = getattr(tree, "source", None) or SourceText("")
    changes, found = _FAMILIES[family](tree, source.text, cell)
    text = source.text
    for span, value in sorted(changes, key=lambda change: -change[0].start):
        text = text[: span.start] + value + text[span.end :]
    return replace(source, text=text), found


Change = tuple[Span, str]


def _unchanged_text(value: rapid.Expression) -> str:
    """A value that is written out, as text."""
    match value:
        case rapid.AggregateNode(items):
            return f"[{','.join(map(_unchanged_text, items))}]"
        case rapid.Prefix(operator, operand):
            return operator + _unchanged_text(operand)
        case rapid.BoolLiteral(truth):
            return str(truth).upper()
        case rapid.StringLiteral(text):
            return f'"{text}"'
        case rapid.NumberLiteral(number):
            return number
    raise AssertionError(value)


def _equip_rapid(tree: object, text: str, cell: Cell) -> tuple[list[Change], set[str]]:
    """The second part of a tool is its tip, the last two of a work object are its frames."""
    changes: list[Change] = []
    found: set[str] = set()
    for node in nodes(tree.parts if isinstance(tree, rapid.File) else ()):
        stands = cell.standing.get(still_frame_name(carrying_unit(node)).lower())
        if stands is not None and isinstance(node, rapid.AggregateNode):
            values = zip(node.items[1:4], ("TRUE", '""', _listed_numbers(stands)), strict=True)
            changes += ((item.span, value) for item, value in values if item.span is not None)
        if not isinstance(node, rapid.Data) or not isinstance(node.value, rapid.AggregateNode):
            continue
        name, items = node.name.lower(), node.value.items
        given: list[tuple[int, Pose]] = []
        if node.type.lower() == "tooldata" and name in cell.tools and len(items) == 3:
            given = [(1, cell.tools[name])]
        elif node.type.lower() == "wobjdata" and name in cell.frames and len(items) == 5:
            given = [(3, cell.frames[name].user), (4, cell.frames[name].object)]
        if node.value.span is None and node.span is not None:  # the cell file alone states it
            parts = [_unchanged_text(item) for item in items]
            for place, pose in given:
                parts[place] = _listed_numbers(pose)
                found.add(name)
            end = node.span.end - text[node.span.start : node.span.end].endswith(";")
            changes.append((Span(end, end), f":=[{','.join(parts)}]"))
            continue
        for place, pose in given:
            span = items[place].span
            if span is not None:
                changes.append((span, _listed_numbers(pose)))
                found.add(name)
    return changes, found


def _listed_numbers(pose: Pose) -> str:
    position, turned = (
        ",".join(map(_number_text, part)) for part in (pose.position, pose.quaternion)
    )
    return f"[[{position}],[{turned}]]"


def _number_text(value: float) -> str:
    return f"{value:.12f}".rstrip("0").rstrip(".")


TOOL_PARAMETER: Final = re.compile(r"wk\d+cord|mextl\d+", re.IGNORECASE)
"""Names of parameters, whose values stand in positions with a P before the name."""


def _equip_melfa(tree: object, text: str, cell: Cell) -> tuple[list[Change], set[str]]:  # noqa: ARG001
    """A frame is a base, from which the robot is seen, or a factor of positions."""
    from assistant.virtual.melfa.poses import position_of

    short = {name.lower(): own for own, name in re.findall(r"(\w+) = (\w+)", text)}
    changes: list[Change] = []
    found: set[str] = set()
    for name in (*cell.tools, *cell.frames):
        own = short.get(name, f"P?{name}" if TOOL_PARAMETER.fullmatch(name) else name)
        pose = cell.tools[name] if name in cell.tools else cell.frames[name].pose
        if name not in cell.tools and re.search(rf"(?i)\bBase\s+{own}\b", text):
            pose = pose.inverse()
        values = ",".join(f"{v:+.9f}" for v in position_of(pose).values[:6] if v is not None)
        for match in re.finditer(rf"(?im)^\s*{own}\s*=\s*\(((?:[^,()]*,){{5}}[^,()]*)", text):
            changes.append((Span(match.start(1), match.end(1)), values))
            found.add(name)
    return changes, found


_FAMILIES: Final[Mapping[str, Callable[[object, str, Cell], tuple[list[Change], set[str]]]]] = {
    "RA": _equip_rapid,
    "MB": _equip_melfa,
}
"""By the family of a language."""
