"""How deep each line of a program stands in its blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import Block, blocks_of, divided, statement_of

_DEEPER: Final = {"Select": 2}
"""Levels that a block's inside is deeper, if not one: `Case` stands one level in."""


def levels(items: Sequence[s.Item]) -> list[int]:
    """The level of each item, from 0; what is closed but was never opened is passed over."""
    blocks = blocks_of(items, range(len(items)))
    made: list[int] = []
    function = 0
    selects = False
    for at, item in enumerate(items):
        statement = statement_of(item)
        if isinstance(statement, s.Function) or statement == s.Command("FEnd"):
            function = 0
        level = function + _inside(blocks.around[at], at)
        if isinstance(statement, s.Function):
            function = 1
        if divided(statement):
            level = max(level - 1, 0)
        elif is_comment(item):
            level -= selects  # before the first `Case` it is that one's
        if isinstance(item, s.Line) and not is_comment(item):
            selects = isinstance(statement, s.Select)
        made.append(level)
    return made


def _inside(block: Block | None, at: int) -> int:
    chain = block.chain if block is not None else ()
    return sum(_DEEPER.get(b.kind, 1) for b in chain if b.crossed is None or at < b.crossed)


def is_comment(item: s.Item) -> bool:
    """Whether an item is a comment and nothing else."""
    return (
        isinstance(item, s.Line)
        and item.statement is None
        and item.label is None
        and item.comment is not None
    )
