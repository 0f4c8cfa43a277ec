"""Phrases that findings have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

SHOWN: Final = 6
"""Names that one finding lists."""


def listed(names: Sequence[str], count: int | None = None) -> dict[str, str]:
    """`names` and `them` of a finding about so many things; count: if `names` are not all."""
    count = len(names) if count is None else count
    shown = ", ".join(f"`{name}`" for name in names[:SHOWN])
    more = f" and {count - SHOWN} more" if count > SHOWN else ""
    return {"names": shown + more, "them": "them" if count > 1 else "it"}


def as_of_more(count: int) -> str:
    """What follows a finding at one place that is true of so many in all."""
    return f", as of {count - 1} more" if count > 1 else ""


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
