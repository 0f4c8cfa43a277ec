"""What could stand at a place, in words."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from assistant.languages.lalr import END

_EXPECTED: Final = (
    ({"MOTION"}, "a statement"),
    ({"NUMBER"}, "a value"),
    ({"POSITION", "NAME"}, "a name"),
    ({"STRING"}, "a text"),
    ({"LABEL"}, "a label"),
    ({"THEN"}, "`Then`"),
    ({"TO"}, "`To`"),
    ({"AS"}, "`As`"),
    ({"GOTO", "GOSUB"}, "`GoTo` or `GoSub`"),
    ({"TYPE"}, "a type, `Inte` or `Pos` for example"),
    ({"HASH"}, "`#`"),
    ({"EQUALS"}, "`=`"),
    ({"COMMA"}, "`,`"),
    ({"RPAR"}, "`)`"),
    ({"LPAR"}, "`(`"),
    ({"SIGN", "TIMES"}, "an operator"),
    ({END}, "the end of the line"),
)
"""Terminals and what they are called; only the first that applies of a value, a name and a text."""

MOST: Final = 4
"""Things that are listed."""


def expected(terminals: Collection[str]) -> str:
    """What may follow, empty where nothing has a name."""
    found: list[str] = []
    if "SIGN" in terminals:
        terminals = {*terminals} - {"EQUALS"}  # which compares there, as other operators do
    for kinds, phrase in _EXPECTED:
        if kinds & set(terminals) and not (
            phrase in ("a name", "a text", "an operator", "`(`", "a label")
            and {"a value", "a statement"} & set(found)
        ):
            found.append(phrase)
    if not found or len(found) > MOST:
        return ""
    return found[0] if len(found) == 1 else f"{', '.join(found[:-1])} or {found[-1]}"
