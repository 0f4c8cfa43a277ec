"""Lines of a program as blocks inside one another, and back."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from assistant.languages.melfa_basic import syntax as s

Kind = Literal["If", "For", "While", "Select", "Function"]


@dataclass(slots=True)
class Part:
    """A line that begins a part of a block (`If`, `ElseIf`, `Case` …), and what it holds."""

    head: s.Line
    body: list[Node] = field(default_factory=list)


@dataclass(slots=True)
class Block:
    """end: None for a loop inside another one that the same `Next` closes."""

    kind: Kind
    parts: list[Part]
    end: s.Line | None = None


Node = s.Item | Block

CLOSING: Final[dict[str, Kind]] = {
    "EndIf": "If", "WEnd": "While", "End Select": "Select", "FEnd": "Function",
}  # fmt: skip
MIDDLE: Final[dict[str, Kind]] = {"Else": "If", "Default": "Select"}


def opens(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement begins."""
    match statement:
        case s.If(then=None):
            return "If"
        case s.For():
            return "For"
        case s.Select():
            return "Select"
        case s.Function():
            return "Function"
        case s.Command(keyword="While"):
            return "While"
    return None


def divides(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement begins a further part of."""
    match statement:
        case s.ElseIf():
            return "If"
        case s.Case():
            return "Select"
        case s.Command(keyword=word):
            return MIDDLE.get(word)
    return None


def closes(statement: s.Statement | None) -> tuple[Kind, ...]:
    """The kinds of the blocks that a statement ends, the inner one first."""
    match statement:
        case s.Next(variables=variables):
            loops: list[Kind] = ["For"] * max(1, len(variables))
            return tuple(loops)
        case s.Command(keyword=word) if word in CLOSING:
            return (CLOSING[word],)
    return ()


def nested(items: Sequence[s.Item]) -> list[Node] | None:
    """The blocks of a program; None if they are not opened and closed in order."""
    outer: list[Node] = []
    stack: list[Block] = []

    def inside() -> list[Node]:
        return stack[-1].parts[-1].body if stack else outer

    for item in items:
        statement = item.statement if isinstance(item, s.Line) else None
        if not isinstance(item, s.Line) or statement is None:
            inside().append(item)
            continue
        if kind := opens(statement):
            block = Block(kind, [Part(item)])
            inside().append(block)
            stack.append(block)
        elif kind := divides(statement):
            if not stack or stack[-1].kind != kind:
                return None
            stack[-1].parts.append(Part(item))
        elif ended := closes(statement):
            if len(stack) < len(ended) or any(
                block.kind != kind for block, kind in zip(stack[::-1], ended, strict=False)
            ):
                return None
            for _ in ended:
                last = stack.pop()
            last.end = item
        else:
            inside().append(item)
    return None if stack else outer


def flat(nodes: Iterable[Node]) -> list[s.Item]:
    """The lines of blocks, in order."""
    lines: list[s.Item] = []
    for node in nodes:
        if not isinstance(node, Block):
            lines.append(node)
            continue
        for part in node.parts:
            lines += [part.head, *flat(part.body)]
        if node.end is not None:
            lines.append(node.end)
    return lines
