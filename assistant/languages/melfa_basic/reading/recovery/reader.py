"""The reader of damaged lines of MELFA-BASIC, and its words."""

from __future__ import annotations

import re
from functools import cache
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.grammar import keywords
from assistant.languages.melfa_basic.reading.line import line_grammar, placed, split_step
from assistant.languages.melfa_basic.reading.nodes import Nodes
from assistant.languages.melfa_basic.reading.recovery.mistakes import MISTAKES, foreign_words
from assistant.languages.melfa_basic.tables.vocabulary import statement
from assistant.languages.melfa_basic.tables.words import keyword_spelling
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.recovery.line_repairs import LineReader, LineSyntax, Missing, Phrase

_MISSING, _UNCLEAR, _TEXT = 4, 5, 6
"""Costs of what is put in: how sure it is that it is meant."""

MISSING: Final = {
    "_THEN": Missing(" Then ", "`Then`", "write `Then` behind the condition", _MISSING),
    "RPAR": Missing(")", "a `)`", "write it, or take out the `(` that it belongs to", _MISSING),
    "COMMA": Missing(",", "a comma", "write `,` between the two", _MISSING),
    "EQUALS": Missing("=", "a `=`", "write `=` between the two", _UNCLEAR),
    "_TO": Missing(" To ", "`To`", "write `To` between first and last value", _MISSING),
    "_AS": Missing(" As ", "`As`", "write `As #1` with the number of the line", _MISSING),
    "NUMBER": Missing(" 1 ", "a value", "write a number or a variable", _UNCLEAR),
    "NAME": Missing(" M1 ", "a name", "write a variable", _UNCLEAR),
    "GOTO": Missing(" GoTo ", "`GoTo`", "write `GoTo` or `GoSub` before the label", _UNCLEAR),
    "TIMES": Missing("*", "an operator", "write `+`, `-`, `*` or `/` between the two", _TEXT),
    "HASH": Missing("#", "a `#`", "write `#` before the number", _MISSING),
    "LABEL": Missing("*L", "a label", "write `*` and the label's name", _UNCLEAR),
    "STRING": Missing('"x"', "a text", "write it between quotes", _UNCLEAR),
    "SKIP": Missing(" Skip ", "a statement", "write what is to be done", _UNCLEAR),
    "POSITION": Missing("(0,0)", "a constant", "write the constant", _UNCLEAR),
}

_VALUE_PHRASES: Final = frozenset(("a value", "a statement"))
PHRASES: Final = (
    Phrase(frozenset(("MOTION",)), "a statement"),
    Phrase(frozenset(("NUMBER",)), "a value"),
    Phrase(frozenset(("POSITION", "NAME")), "a name", _VALUE_PHRASES),
    Phrase(frozenset(("STRING",)), "a text", _VALUE_PHRASES),
    Phrase(frozenset(("LABEL",)), "a label", _VALUE_PHRASES),
    Phrase(frozenset(("_THEN",)), "`Then`"),
    Phrase(frozenset(("_TO",)), "`To`"),
    Phrase(frozenset(("_AS",)), "`As`"),
    Phrase(frozenset(("GOTO", "GOSUB")), "`GoTo` or `GoSub`"),
    Phrase(frozenset(("TYPE",)), "a type, `Inte` or `Pos` for example"),
    Phrase(frozenset(("HASH",)), "`#`"),
    Phrase(frozenset(("EQUALS",)), "`=`"),
    Phrase(frozenset(("COMMA",)), "`,`"),
    Phrase(frozenset(("RPAR",)), "`)`"),
    Phrase(frozenset(("LPAR",)), "`(`", _VALUE_PHRASES),
    Phrase(frozenset(("SIGN", "TIMES")), "an operator", _VALUE_PHRASES),
    Phrase(frozenset((END,)), "the end of the line"),
)

_BRANCH: Final = re.compile(r"\b(?:Then|Else|Wth)\b|^[ \t]*\*\w+[ \t]*:", re.IGNORECASE)
_PROSE: Final = re.compile(r"[ \t]*([^\W\d]+)(?:[ ,]+[^\W\d][\w'-]*){2,}[ \t.!?:]*$")
_OPERAND: Final = re.compile(r"\d|[PJMC]\w*\d|[PJ]\w{2}", re.IGNORECASE)


@cache
def recovery_reader() -> LineReader:
    syntax = LineSyntax(
        title="MELFA-BASIC",
        comment="'",
        comments=frozenset(("COMMENT", "REM")),
        names=frozenset(("NAME", "FN_NAME")),
        grammar=line_grammar(),
        parts=split_step,
        line="line",
        nodes=Nodes,
        item=lambda node, number: placed(node, number, None),
        mistakes=MISTAKES,
        foreign=foreign_words(),
        branch=_BRANCH,
        keywords=keywords(),
        words=tuple(word for word in keywords() if len(word) > 1),
        spelled=keyword_spelling,
        begins=lambda word: statement(word) is not None,
        parted=_parted,
        is_whole=lambda node: isinstance(node, s.Line) and node.statement is not None,
        prose=_PROSE,
        missing=MISSING,
        phrases=PHRASES,
        unsaid={"SIGN": frozenset(("EQUALS",))},  # which compares there, as other operators do
        wrong=rules.SYNTAX,
    )
    return LineReader(syntax)


def _parted(written: str) -> int | None:
    """Where a word ends that its operand follows without a blank: `MOVP1`, `GOTO100`, `DLY1`."""
    for size in range(len(written) - 1, 1, -1):
        known = statement(written[:size])
        if known is not None and known.role != "part" and _OPERAND.match(written, size):
            return size
    return None
