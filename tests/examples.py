"""How many examples property tests draw."""

from __future__ import annotations

from typing import Final

from hypothesis import settings

FEWEST: Final = 8
SHARE: Final = 10
"""One of so many examples is drawn by `make test`, always the same ones: they are cases that are
known to pass. `make test-slow` draws all of them anew.
"""


def drawn(most: int) -> int:
    """How many of `most` examples a run draws, by the profile of hypothesis."""
    assert settings.default is not None
    return max(min(most, FEWEST), most // SHARE) if settings.default.derandomize else most
