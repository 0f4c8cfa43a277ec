"""What MELFA-BASIC has no words for."""

from __future__ import annotations


class Unsayable(Exception):
    """MELFA-BASIC has no words for it."""

    def __init__(self, what: str, cure: str = "") -> None:
        super().__init__(what)
        self.what, self.cure = what, cure


class NoNumber(Unsayable):
    """A signal that is known by name only; `what` is the name."""


class Undeclared(Unsayable):
    """A name that stands for nothing; `what` is the name."""
