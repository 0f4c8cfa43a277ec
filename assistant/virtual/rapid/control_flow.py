"""Control flow: the exceptions by which a program leaves a statement, and its error numbers.

The manuals name the errors and give no numbers: programs compare `ERRNO` with the names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.diagnostics import Span
from assistant.languages.rapid.tables import predefined
from assistant.virtual.rapid.values import Value

if TYPE_CHECKING:
    from assistant.virtual.rapid.scopes import Frame, Unit


MOST_RAISED: Final = 90
"""A program may raise 1 to 90, and what it booked (manual, RAISE)."""
FIRST_BOOKED: Final = 101
_FIRST_ERROR: Final = 1001
ANY_ERROR: Final = "long_jmp_all_err"
"""In the list of a handler, whatever the error is."""

ERROR_NUMBERS: Final[Mapping[str, int]] = {
    name: number
    for number, name in enumerate(
        (name for name, datum in predefined.data().items() if datum.type == "errnum"), _FIRST_ERROR
    )
    # A variable of this type, and no error.
    if name != "errno"
}
"""By name in lower case."""
ERROR_NAMES: Final[Mapping[int, str]] = {
    number: predefined.data()[name].name for name, number in ERROR_NUMBERS.items()
}


UNSURE: Final = "unsure"
"""Instead of the name of an error, where the manuals do not tell whether it has one."""


class Fault(Exception):
    """An error that stops a controller.

    number: that of an error that the program can recover from, None for any other. unsure: True if
    it is open whether the error has a number, so that the action of a handler is unknown. at, row:
    the statement that raised it. leaves: the call that did not recover from it. goal: the call
    whose handler it reaches in one step, None for that of the next caller.
    """

    def __init__(self, message: str, error: str = "", number: int | None = None) -> None:
        """error: the name of its number."""
        self.unsure = error == UNSURE
        named = bool(error) and not self.unsure
        super().__init__(f"{message} ({error})" if named else message)
        self.number = ERROR_NUMBERS[error.lower()] if named else number
        self.at: tuple[Unit, Span | None] | None = None
        self.row = 0
        self.leaves: Frame | None = None
        self.goal: Frame | None = None


class NotSimulated(Exception):
    """A feature that this interpreter does not support; the text names it."""


class Over(Exception):
    """The program comes to its end here."""

    def __init__(
        self, ended: Literal["end", "stopped", "steps"] = "end", message: str = ""
    ) -> None:
        super().__init__(message)
        self.ended: Literal["end", "stopped", "steps"] = ended


class Cycled(Over):
    """ExitCycle: the program pointer goes to the first routine."""


class Again(Exception):
    """RETRY."""


class Onward(Exception):
    """TRYNEXT."""


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
