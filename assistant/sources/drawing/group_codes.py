"""Lines of a text DXF: a group code and its value, in turn.

Group codes tell what a value is (DXF reference, "Group code value types"). Libraries cut a number
off where it stops being one, so that `50,5` is 50: each of them is looked at here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.sources.drawing.findings import MALFORMED, shown

NUMBER_CODES: Final = (
    *((10, 59), (60, 79), (90, 99), (110, 149), (160, 179), (210, 239), (270, 289)),
    *((290, 299), (370, 389), (400, 409), (420, 429), (440, 469), (1010, 1071)),
)
"""First and last code of those that are numbers."""
PLAIN_NUMBER: Final = re.compile(
    rb"[ \t]*[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|(?i:nan|inf|infinity))[ \t\x00\x1a]*"
)
"""A number as the reference has it; that one is not finite is found where it is used."""
MOST_MALFORMED: Final = 10
"""Malformed numbers that have a finding each."""

ESCAPED_CHARACTERS: Final = re.compile(r"(?:\\U\+[0-9A-Fa-f]{4})+")
ESCAPE_MARK: Final = b"\\U+"
"""Prefix of a character that the code page of a file does not have."""


def malformed_numbers(data: bytes, path: str) -> list[Diagnostic]:
    """Return findings for values that are no numbers but have to be, the first ones of them.

    It ends where lines are no longer codes and values in turn: that is damage of another kind.
    """
    known: dict[bytes, int | None] = {}
    wrong: list[tuple[int, int, bytes]] = []
    lines = data.splitlines()
    for row, (code, value) in enumerate(zip(lines[::2], lines[1::2], strict=False)):
        if code not in known:
            number = _group_code(code)
            if number is None:
                break
            known[code] = number if any(a <= number <= b for a, b in NUMBER_CODES) else None
        kind = known[code]
        if kind is not None and PLAIN_NUMBER.fullmatch(value) is None:
            wrong.append((2 * row + 2, kind, value))
    return [*_malformed_findings(wrong, path)]


def _group_code(text: bytes) -> int | None:
    try:
        return int(text)
    except ValueError:
        return None


def _malformed_findings(wrong: list[tuple[int, int, bytes]], path: str) -> Iterator[Diagnostic]:
    for place, (line, code, value) in enumerate(wrong[:MOST_MALFORMED]):
        given = value.decode("latin-1").strip()
        rest = len(wrong) - MOST_MALFORMED
        more = f" ({rest} more such values)" if rest > 0 and place == MOST_MALFORMED - 1 else ""
        yield MALFORMED(
            path=path, line=line, given=shown(given), code=code, more=more, cure=_number_cure(given)
        )


def _number_cure(given: str) -> str:
    """What to write instead, where that is plain."""
    if re.fullmatch(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", given):
        return f"write a decimal point, {given.replace(',', '.')}"
    meant = given.replace(",", "") if "." in given else given
    meant = re.sub(r"[dD](?=[+-]?\d+$)", "E", meant)
    if meant != given and PLAIN_NUMBER.fullmatch(meant.encode("latin-1")):
        return f"write {meant}"
    return "write a number such as 12.5, or export the drawing anew"


def unescaped(text: str) -> str:
    r"""A text with the characters that `\U+XXXX` stand for, as far as they can be printed."""
    return ESCAPED_CHARACTERS.sub(_unescaped_characters, text)


def _unescaped_characters(found: re.Match[str]) -> str:
    units = bytes.fromhex("".join(found[0].split("\\U+")))
    made = units.decode("utf-16-be", errors="replace")
    return made if made.isprintable() and "�" not in made else found[0]
