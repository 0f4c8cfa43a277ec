"""Error numbers of Mitsubishi CR controllers: their levels, and the commonest in our own words.

The table is `errors.tsv`; numbers and levels are those of the controllers' error lists (BFP-A8871,
BFP-A5993). A number that ends in `n` stands for those of all axes or units.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

ERROR_LEVELS: Final = {"H": "high", "L": "low", "C": "caution"}
"""High: servos go off. Low: the program stops. Caution: the program goes on."""

ERROR_FAMILIES: Final = {
    0: "an error of the hardware",
    1: "an error of the servos",
    2: "an error of the motion",
    3: "an error of the running program",
    4: "an error of a program or its editing",
    5: "a command that the present state forbids",
    6: "an error of the communication or the signals",
    7: "an error of files, parameters or options",
    8: "an error of an option",
    9: "an error raised by the user's program",
}
"""First digit of the number → what it is about, for numbers that the table does not name."""

LOOK_IT_UP: Final = "look the number up in the controller's troubleshooting manual"


@dataclass(frozen=True, slots=True)
class CrError:
    """One error number; level is a key of `LEVELS`, "" if it is not known."""

    number: int
    level: str
    text: str
    cure: str


def cr_error(number: int) -> CrError:
    """What an error number means; never fails."""
    digits = f"{number:04}"
    rows = (_error_table().get(digits), _error_table().get(f"{digits[:-1]}n"))
    level, text, cure = next((row for row in rows if row is not None), ("", "", ""))
    words = text.replace("{n}", digits[-1]) or ERROR_FAMILIES.get(number // 1000, "an error")
    return CrError(number, level, words, cure or LOOK_IT_UP)


@cache
def _error_table() -> Mapping[str, tuple[str, str, str]]:
    """Number → level, text and cure; a text is empty where there is none of our own."""
    text = files(__package__).joinpath("errors.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return {row["number"]: (row["level"], row["text"], row["cure"]) for row in rows}
