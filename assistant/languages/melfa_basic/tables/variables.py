"""Variables: the letters that their names begin with, and those of all programs."""

from __future__ import annotations

import re
from typing import Final

from assistant.program.program import ValueType, Variable

LETTERS: Final[dict[ValueType, str]] = {
    "number": "M", "integer": "M", "truth": "M", "text": "C",
    "position": "P", "pose": "P", "joints": "J",
}  # fmt: skip


def is_external(name: str, variable: Variable) -> bool:
    """Whether it is one variable of all programs of a controller, which its name must stay for.

    The second character of such a name is `_` (CR1D 4.3.7); first values of its own it has none.
    """
    written = re.fullmatch(r"[PJMC]_[A-Z0-9_]+", name.upper())
    return (
        written is not None
        and variable.storage == "persistent"
        and (variable.initial is None or re.fullmatch(r"._[01][0-9]", name) is not None)
        and name[0].upper() == LETTERS[variable.type]
    )
