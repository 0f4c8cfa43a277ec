"""How deep each line of a program stands in its blocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.languages.line_blocks import Block
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word, blocks_of, statement_of

_DEEPER: Final = {"Select": 2}
"""Levels that a block's inside is deeper, if not one: `Case` stands one level in."""
_FEND: Final = s.Command("FEnd")


def levels(items: Sequence[s.Item]) -> list[int]:
    """The level of each item, from 0; what is closed but was never opened is passed over."""
    blocks = blocks_of(items)
    made: list[int] = []
    function = 0
    selects = False
    for at, item in enumerate(items):
        statement = statement_of(item)
        bounds = isinstance(statement, s.Function) or statement == _FEND
        if bounds:
            function = 0
        block = blocks.around[at]
        level = function if block is None else function + _inside(block, at)
        if bounds and statement != _FEND:
            function = 1
        if is_comment(item):
            level -= selects  # before the first `Case` it is that one's
        elif isinstance(item, s.Line):
            selects = isinstance(statement, s.Select)
            level = max(level - 1, 0) if block_word(statement).parts else level
        made.append(level)
    return made


def _inside(block: Block, at: int) -> int:
    """How much deeper a line is for the blocks that it stands in."""
    return sum(
        _DEEPER.get(one.kind, 1) for one in block.chain if one.crossed is None or at < one.crossed
    )


def is_comment(item: s.Item) -> bool:
    """Whether an item is a comment and nothing else."""
    return (
        isinstance(item, s.Line)
        and item.statement is None
        and item.label is None
        and item.comment is not None
    )
