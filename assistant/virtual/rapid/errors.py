"""Errors that a program can recover from: their names, and the numbers that they have here.

The manuals name them and give no numbers: programs compare `ERRNO` with the names.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.languages.rapid.tables import predefined

MOST_RAISED: Final = 90
"""A program may raise 1 to 90, and what it booked (manual, RAISE)."""
FIRST_BOOKED: Final = 101
FIRST_ERROR: Final = 1001
ANY_ERROR: Final = "long_jmp_all_err"
"""In the list of a handler, whatever the error is."""

ERROR_NUMBERS: Final[Mapping[str, int]] = {
    name: number
    for number, name in enumerate(
        (name for name, datum in predefined.data().items() if datum.type == "errnum"), FIRST_ERROR
    )
    if name != "errno"
}
"""By name in lower case."""
ERROR_NAMES: Final[Mapping[int, str]] = {
    number: predefined.data()[name].name for name, number in ERROR_NUMBERS.items()
}
