"""Phrases that findings have in common."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, Generic, TypeVar

from assistant.base.arrays import Rows

N = TypeVar("N")

SHOWN_NAMES: Final = 6
"""Names that one finding lists."""


class Listing(Generic[N]):
    """Many things that one finding is about.

    first: where it stands, a node and a row of it; None if there is nothing. names: those that the
    finding lists. count: of all things.
    """

    def __init__(self) -> None:
        self.first: tuple[N, int] | None = None
        self.names: list[str] = []
        self.count = 0

    def add(self, node: N, name: str) -> None:
        self.add_rows(node, (0,), lambda _: name)

    def add_rows(self, node: N, rows: Sequence[int] | Rows, name: Callable[[int], str]) -> None:
        """Some rows of a table. name: what a row is called."""
        if len(rows) and self.first is None:
            self.first = node, int(rows[0])
        self.names += [name(int(row)) for row in rows[: SHOWN_NAMES - len(self.names)]]
        self.count += len(rows)

    @property
    def words(self) -> dict[str, str]:
        """The `names` and `them` of the finding."""
        shown = ", ".join(f"`{name}`" for name in self.names)
        more = f" and {self.count - SHOWN_NAMES} more" if self.count > SHOWN_NAMES else ""
        return {"names": shown + more, "them": "them" if self.count > 1 else "it"}


def like_it(count: int) -> str:
    """What follows the last of some findings, if so many others were like them."""
    return f" and {count} more like it" if count > 0 else ""


def alternatives(least: int, most: int | None, what: str) -> str:
    """How many things are taken: `1 argument`, `2 to 3 arguments`."""
    if most is None:
        return f"{least} {what}s or more"
    if least != most:
        return f"{least} to {most} {what}s"
    return f"{least or 'no'} {what}" + "s" * (least != 1)
