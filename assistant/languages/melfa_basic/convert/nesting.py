"""Lines of a program as blocks inside one another, and back."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import closed, divided, opened

DEEPEST: Final = 50
"""Blocks inside one another that are converted; controllers stop at 16."""

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


def opens(statement: s.Statement | None) -> Kind | None:
    """The kind of block that a statement begins, None for none."""
    return "Function" if isinstance(statement, s.Function) else opened(statement)


def closes(statement: s.Statement | None) -> tuple[Kind, ...]:
    """The kinds of the blocks that a statement ends, the inner one first."""
    return ("Function",) if statement == s.Command("FEnd") else closed(statement)


def nested(items: Sequence[s.Item]) -> list[Node] | None:
    """The blocks of a program; None if they are not opened and closed in order, or too deep."""
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
            if len(stack) > DEEPEST:
                return None
            block = Block(kind, [Part(item)])
            inside().append(block)
            stack.append(block)
        elif kind := divided(statement):
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
