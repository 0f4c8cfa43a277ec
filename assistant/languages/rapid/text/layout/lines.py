r"""One layout for every RAPID text: indentation, blanks, blank lines and upper-case keywords.

The layout is RobotStudio's: four columns a level, `CASE` and `ERROR` at the level of what they
belong to, no blanks around operators and commas. Tokens are never added, dropped or respelt,
except that keywords become upper case; comments stay between the tokens where they stood.

    MODULE m
        PROC main()
            IF x=1 AND NOT y THEN
                MoveL p1,v100,z10,tool0\WObj:=w;  ! comments behind lines that stood aligned
                Stop;                             ! stay aligned
            ENDIF
            Foo a,
                    b;          a line that goes on stands two levels in,
            x:=Bar(a,
                   b);          or under what the open bracket begins with,
            y:=[
                1,2             or one level in if its line ends with it
            ];
"""

from __future__ import annotations

from typing import Final

from assistant.languages.rapid.text.layout.segments import SEGMENT_CUTTER
from assistant.languages.rapid.text.layout.spacing import Spacing
from assistant.languages.texts import layout
from assistant.languages.texts.words import Word


def lay_out(text: str) -> str:
    """The text in the one layout, for any text that the grammar takes; idempotent."""
    return layout.lay_out(text, list(SEGMENT_CUTTER.segments(text)), STYLE)


def _table_lines(table: str, indent: str, newline: str) -> str:
    """The lines of a table without the last line end: few long replacements, none by line."""
    tight = table.replace(" ", "").replace("\t", "").replace("\r", "")
    tight = "\n" + tight.removesuffix("\n")
    for head in ("CONST robtarget ", "LOCAL CONST robtarget ", "MoveJ ", "MoveL ", "MoveC "):
        tight = tight.replace("\n" + head.replace(" ", ""), "\n" + indent + head)
    return tight[1:].replace("\n", newline)


def _spelt_word(word: Word) -> str:
    match word.kind:
        case "key" | "hole":
            return word.text.upper()
        case "comment":
            return word.text.rstrip()
    return word.text


STYLE: Final = layout.Style(
    Spacing,
    _spelt_word,
    _table_lines,
    separate=frozenset({"proc", "func", "trap", "module"}),
    outermost=frozenset({"module"}),
    choosing=frozenset({"test"}),
)
