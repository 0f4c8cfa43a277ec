"""A change to the text of a line."""

from __future__ import annotations

from dataclasses import dataclass

from assistant.base.diagnostics import Rule


@dataclass(frozen=True, slots=True)
class Edit:
    """A change to a line that is to make it one of the language, and what to say about it.

    rule: of the finding, None for the usual one.
    """

    start: int
    end: int
    text: str
    what: str
    cure: str
    cost: int = 0
    rule: Rule | None = None

    def of(self, text: str) -> str:
        """A line with this change."""
        return text[: self.start] + self.text + text[self.end :]
