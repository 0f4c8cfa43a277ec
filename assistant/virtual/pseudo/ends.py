"""Ways in which a running pseudo-program leaves the statement at hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assistant.virtual.pseudo.data import Value


class Fault(Exception):
    """What no controller could do."""


class NotRun(Exception):
    """What this interpreter does not know; the text says what it is."""


class Over(Exception):
    """The program is ended for good."""


class Jump(Exception):
    """label: in lower case."""

    def __init__(self, label: str) -> None:
        super().__init__(label)
        self.label = label


class Returned(Exception):
    def __init__(self, value: Value | None = None) -> None:
        super().__init__()
        self.value = value
