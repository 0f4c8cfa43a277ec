"""Words of a text of any language, as its text rooms speak of them."""

from __future__ import annotations

from typing import NamedTuple


class Word(NamedTuple):
    """kind: as the language calls it. text: as written. start: its offset."""

    kind: str
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)
