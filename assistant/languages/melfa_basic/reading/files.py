"""Files of MELFA-BASIC as bytes: whether they look like it, and which version."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import functions, statements, variables

TOKENISED: Final = b"ROBPRG"
"""First bytes of a controller's own .MB4, .MB5 and .MB6 files."""

_LEVELS: Final = {".mb4": 4, ".mb5": 5, ".mb6": 6}
"""Suffixes that say the version."""

_MARK: Final = re.compile(r"' robot-assistant: melfa-basic-([456])")
_LOOKED_AT: Final = 1 << 17
_RAPID: Final = re.compile(
    r"^[ \t]*(%%%|MODULE[ \t]+[A-Za-z]|ENDMODULE|(LOCAL[ \t]+)?PROC[ \t]+[A-Za-z])",
    re.IGNORECASE | re.MULTILINE,
)
_LEAST: Final = 0.5
"""Share of a file's lines, blank ones and comments aside, that look like the language."""


def recognises(data: bytes, level: int, suffix: str = "") -> bool:
    """True if bytes look like one version; a written file and some suffixes state the version.

    suffix: of the file's name in lower case, with its dot.
    """
    stated = _LEVELS.get(suffix)
    if data.startswith(TOKENISED):
        return stated in (level, None)
    # The mark of a text in UTF-8, as Latin-1 reads it.
    text = data[:_LOOKED_AT].decode("latin-1").removeprefix("\xef\xbb\xbf")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if marked := _MARK.search(text):
        return int(marked[1]) == level
    return _is_program(text, named=stated is not None) and level == (stated or version(text))


def _is_program(text: str, *, named: bool = False) -> bool:
    """True if a text looks like MELFA-BASIC in any version, or like a list of positions.

    named: its suffix belongs to MELFA-BASIC alone, so that no line of it needs to.
    """
    if _RAPID.search(text):
        return False
    sure = likely = lines = 0
    for line in text.split("\n"):
        if _SILENT.match(line):
            continue
        lines += 1
        found = _looks().match(line)
        if found is not None:
            likely += 1
            sure += found["sure"] is not None or found["step"] is not None
    # One line that no other language has, and half of all that could be of this one.
    return (sure > 0 or (named and lines > 0)) and likely >= _LEAST * lines


_SILENT: Final = re.compile(r"\s*(?:'|\x1a|$)")


@cache
def _looks() -> re.Pattern[str]:
    """A line of code or a variable line; `sure` where no other language writes it."""
    first = {row.word.split()[0] for row in statements().values() if row.role != "part"}
    own = "|".join(
        re.escape(row.word)
        for row in statements().values()
        if row.role in ("motion", "command") and row.word not in _COMMON
    )
    word = "|".join(map(re.escape, sorted(first, key=len, reverse=True)))
    status = "|".join(variables())
    name = r"[A-Za-z]\w*[$%&!#]?(?:\([^()=]*\))?(?:\.\w+)?"
    return re.compile(
        r"(?P<step>[ \t]*\d{1,5}(?=[ \t*']))?[ \t]*"
        r"(?:(?P<sure>\*[A-Za-z]\w*[ \t]*(?::|'|$)"
        rf"|(?:{own})(?!\w)[^;{{}}]*$"
        rf"|(?:{status})\b\$?[ \t]*(?:\([^()=]*\))?[ \t]*="
        r"|(?:DEF[ \t]+(?:POS|JNT)[ \t]+)?[A-Za-z]\w*[ \t]*(?:\([\d, ]+\))?[ \t]*="
        r"[ \t]*\((?=[^A-Za-z(),]*+,)[^A-Za-z()]*+\)(?:[ \t]*\([^()]*+\))?[ \t]*$"
        r"|(?:If|ElseIf|While|Wait)\b.*\b(?:M_In|M_Out)\w*[ \t]*\()"
        rf"|(?:{word})(?!\w)(?!.*;[ \t]*$)|{name}[ \t]*=(?!=)[^;{{}}]*$|'|\*[A-Za-z])",
        re.IGNORECASE,
    )


_COMMON: Final = frozenset(
    {"Base", "Break", "Default", "Else", "End", "EndIf", "Error", "Fine", "Remove", "Return"}
    | {"Skip", "Title", "Tool", "Wait", "While"}
)
"""Commands that other languages have as well."""


def version(text: str) -> int:
    """The oldest version that a text may be: IV is numbered and in upper case throughout."""
    if _SIX.search(text):
        return 6
    # Comments and texts may hold any word.
    code = _QUIET.sub("", text)
    least = max((at for pattern, at in _newer() if pattern.search(code)), default=4)
    words = _NUMBERED.findall(code)
    if words and all(word.isupper() for word in words):
        return least
    # A position list has no word that shows the version.
    listed = not words and "=(" in text and not re.search(r"(?i)\b(mov|mvs|if)\b", code)
    return least if listed else max(least, 5)


_SIX: Final = re.compile(r"^[ \t]*\d*[ \t]*(FUNCTION|#INCLUDE|STATIC)\b", re.I | re.M)
_NUMBERED: Final = re.compile(r"^[ \t]*\d+[ \t]+([A-Za-z]+)", re.MULTILINE)
_QUIET: Final = re.compile(r"'[^\n]*|\"[^\"\n]*\"|\bREM\b[^\n]*", re.IGNORECASE)


@cache
def _newer() -> tuple[tuple[re.Pattern[str], int], ...]:
    """Return patterns for the features of each newer version, with that version: statements,
    functions, variables.
    """
    return tuple((re.compile("|".join(_of(level)), re.I | re.M), level) for level in (6, 5))


def _of(level: int) -> Iterator[str]:
    def new(dialects: frozenset[int]) -> bool:
        return min(dialects) == level

    heads = [r.word for r in statements().values() if r.role != "part" and new(r.dialects)]
    plain = [word.replace(" ", "[ \\t]+") for word in heads if not word.startswith("#")]
    yield rf"^[ \t]*\d*[ \t]*(?:\*\w+:)?[ \t]*(?:{'|'.join(plain)})\b(?![ \t]*=)"
    called = [f.name.removesuffix("$") for f in functions().values() if new(f.dialects)]
    yield rf"\b(?:{'|'.join(called)})\$?\("
    yield rf"\b(?:{'|'.join(v.name for v in variables().values() if new(v.dialects))})\b"
