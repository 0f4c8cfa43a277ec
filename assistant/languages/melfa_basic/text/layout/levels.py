"""How deep each line of a program stands in its blocks."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import closed, divided, opened

_DEEPER: Final = {"Select": 2}
"""Levels that a block's inside is deeper, if not one: `Case` stands one level in."""


class Levels:
    """The level of line after line, from 0; what is closed but was never opened is passed over."""

    def __init__(self) -> None:
        self._open: list[str] = []
        self._inside = 0
        self._selects = False

    @property
    def inside(self) -> int:
        """The level of a plain line that comes next."""
        return self._inside

    @property
    def comment(self) -> int:
        """The level of a line that is a comment; before the first `Case` it is that one's."""
        return self.inside - self._selects

    def of(self, item: s.Line) -> int:
        """The level of a line, which comes next."""
        if is_comment(item):
            return self.comment
        self._selects = isinstance(item.statement, s.Select)
        return self._level(item.statement)

    def _level(self, statement: s.Statement | None) -> int:
        if isinstance(statement, s.Function):
            self._open, self._inside = ["Function"], 1
            return 0
        kind = opened(statement)
        if kind:
            level = self.inside
            self._open.append(kind)
            self._inside += _DEEPER.get(kind, 1)
            return level
        if divided(statement):
            return max(self.inside - 1, 0)
        self._close(statement)
        return self.inside

    def _close(self, statement: s.Statement | None) -> None:
        if statement == s.Command("FEnd"):
            self._open, self._inside = [], 0
        for kind in closed(statement):
            self._leave(kind)

    def _leave(self, kind: str) -> None:
        if kind in self._open:
            left = ""
            while left != kind:
                left = self._open.pop()
                self._inside -= _DEEPER.get(left, 1)


def is_comment(item: s.Line) -> bool:
    """Whether a line is a comment and nothing else."""
    return item.statement is None and item.label is None and item.comment is not None
