"""What a controller has of one program, and its digests."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Final


@dataclass(frozen=True, slots=True)
class Held:
    """A program on a controller.

    file: its bytes, None if it is not there. loaded: the module in memory with what was taught
    since, None if it is not loaded or the controller has no such memory.
    """

    file: bytes | None = field(default=None, repr=False)
    loaded: bytes | None = field(default=None, repr=False)


NOTHING_INSTALLED: Final = Held()


@dataclass(frozen=True, slots=True)
class Digests:
    """SHA-256 of a `Held`, of the forms that are compared; None for what is not there.

    task: in whose memory the module is, "" if it is in none.
    """

    file: str | None = None
    loaded: str | None = None
    task: str = ""


def digest(data: bytes | None) -> str | None:
    return None if data is None else hashlib.sha256(data).hexdigest()
