"""What kinds of values parameters have, from the parameter files (.PRM) of RT ToolBox.

A file begins with `…NARC parameter system V1.0;`, a line each follows:
`MEXTL=Uf,0,0,150,%r0,%r0,%r0;`. U is a parameter of the user, M one of the maker; then s for
text, d, i and l for whole numbers, x for hexadecimal ones, f for others, `%r` before an angle in
radians. Seen in backups of CR750 and CR800 controllers (Borzyszkowski/Mitsubishi-Melfa-Robot,
KenanAegean/melfabasic-robotic-arm); no manual tells it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.base.file_access import read_file
from assistant.controllers import rules
from assistant.controllers.mitsubishi import values

KIND_FILE_HEAD: Final = "NARC parameter system"
KIND_ROW: Final = re.compile(r"([A-Z][A-Z0-9_]{0,15})=([UM])([sdilfx]),(.*);")
KIND_FORMS: Final = {
    "s": (r".*", "text"),
    "d": (r"[+-]?\d+", "a whole number"),
    "i": (r"[+-]?\d+", "a whole number"),
    "l": (r"[+-]?\d+", "a whole number"),
    "x": (r"[+-]?\d+|(?:0x|&H)?[0-9A-Fa-f]+", "a hexadecimal number"),
    "f": (r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?", "a number"),
}


@dataclass(frozen=True, slots=True)
class ParameterKind:
    """letter: see `FORMS`. count: of values. own: whether it is one of the user's."""

    letter: str
    count: int
    own: bool

    def check(self, name: str, value: str) -> None:
        """Raises Refused if a value is of another kind, or if there are not as many."""
        pattern, words = KIND_FORMS[self.letter]
        parts = [part.strip() for part in value.split(",")]
        wrong = next((part for part in parts if not re.fullmatch(pattern, part)), None)
        if wrong is not None:
            reason = f"`{wrong}` is not {words}"
        elif len(parts) != self.count:
            reason = f"it has {len(parts)} values"
        else:
            return
        form = f"{self.count} times {words}" if self.count > 1 else words
        raise values.bad_value(value, name, reason, form)


def parameter_kinds(files: Iterable[str | FilePath]) -> dict[str, ParameterKind]:
    """Kinds of parameters by name, from some files; raises Refused for what is none."""
    found: dict[str, ParameterKind] = {}
    for file in files:
        path = FilePath(file)
        try:
            text = read_file(path).decode("latin-1")
        except OSError as error:
            reason = error.strerror or str(error)
            raise Refused(rules.NO_PARAMETERS(path=str(path), file=path, reason=reason)) from None
        if KIND_FILE_HEAD not in text.partition(";")[0]:
            reason = "it does not begin as a parameter file of RT ToolBox"
            raise Refused(rules.NO_PARAMETERS(path=str(path), file=path, reason=reason))
        for row in KIND_ROW.finditer(text):
            name, owner, letter, body = row.groups()
            found[name] = ParameterKind(letter, len(_row_values(body)), owner == "U")
    return found


def _row_values(body: str) -> list[str]:
    """The values of a row; texts stand in quotes and may hold commas."""
    return re.findall(r'"[^"]*"|[^,]+', body)
