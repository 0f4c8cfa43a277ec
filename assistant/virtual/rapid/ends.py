"""Ways in which a running program leaves the statement at hand."""

from __future__ import annotations

from typing import Literal

from assistant.virtual.rapid.values import Value


class Fault(Exception):
    """What a controller stops at with an error."""


class NotSimulated(Exception):
    """What this interpreter does not know; the text says what it is."""


class Over(Exception):
    """The program comes to its end here."""

    def __init__(
        self, ended: Literal["end", "stopped", "steps"] = "end", message: str = ""
    ) -> None:
        super().__init__(message)
        self.ended: Literal["end", "stopped", "steps"] = ended


class Jump(Exception):
    """GOTO; label: in lower case."""

    def __init__(self, label: str) -> None:
        super().__init__(label)
        self.label = label


class Returned(Exception):
    """RETURN out of a routine, with the value of a function."""

    def __init__(self, value: Value | None = None) -> None:
        super().__init__()
        self.value = value
