"""Syntax errors in the words of the person who has to fix them.

`MISTAKES` is the table of usual mistakes: each row shows the mistake in small broken programs and
says the cure. What fits no row gets the cure of the change that mended it.
"""

from __future__ import annotations

from collections.abc import Set
from typing import TYPE_CHECKING, Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.recovery.statement_mistakes import MISTAKES
from assistant.languages.rapid.reading.scanner import SILENT
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

if TYPE_CHECKING:
    from assistant.languages.rapid.reading.recovery.broken import Broken, Repair

NAMES: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "EXP": "a value",
    "SEMICOLON": "`;`",
    "COMMA": "`,`",
    "COLON": "`:`",
    "DOT": "`.`",
    "EQUAL": "`=`",
    "_ASSIGN": "`:=`",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "PERCENT": "`%`",
    "MINUS": "`-`",
    "STAR": "`*`",
    "SLASH": "`/`",
    "BACKSLASH": "`\\`",
    "VBAR": "`|`",
    "QMARK": "`?`",
    "HEADER": "`%%%`",
    "$END": "the end of the file",
}
"""Terminals of the grammar as people call them; the rest are words written as they are."""

OPERATORS: Final = frozenset(
    "PLUS MINUS STAR SLASH LESS AT_MOST EQUAL MORE AT_LEAST UNEQUAL OR XOR AND DIV MOD".split()  # noqa: SIM905
)
EXPRESSION: Final = frozenset({"NUMBER", "STRING", "TRUE", "FALSE", "LSQB"})
HOLES: Final = frozenset(
    "TDN DDN RDN PAR ALT DIM SMT VAR_HOLE EIT CSE EXP ARG".split()  # noqa: SIM905
)
RUNS: Final = frozenset({"TARGETS", "MOVES", "TABLE"})
STATEMENT: Final = frozenset({"_IF", "_GOTO", "_RETURN"})
ITEM: Final = frozenset({"_PROC", "_FUNC", "_RECORD"})
LONGEST_SHOWN: Final = 30

CURES: Final = {
    "double": "delete one of the two",
    "delete": "delete it",
    "swap": "swap it with the word beside it",
    "hole": "correct the statement; it was left out",
    "wrap": "statements stand between PROC and ENDPROC",
    "behind": "nothing stands behind ENDMODULE; delete it, or the ENDMODULE before it",
    "outside": "a file of RAPID begins with MODULE and a name; nothing stands behind ENDMODULE",
    "reserved": "choose another name: this is a word of the language",
    "comment": "begin a comment with `!`",
    "string": 'write a string in double quotes, on one line: `"text"`',
    "strange": "delete this character, or write a value or name of letters and digits",
}
"""Kind of repair → the cure that goes without saying more."""


def finding(source: SourceText, broken: Broken, repair: Repair) -> Diagnostic:
    """What is wrong at a damaged place, and the cure."""
    start, end = repair.start, repair.end
    hint = ""
    for mistake in MISTAKES:
        moved = mistake.place(broken, repair)
        if moved is not None:
            hint = mistake.cure
            if moved >= 0:
                start, end = moved, max(end, moved)
            break
    kind = repair.kind
    if broken.at_file_level and kind in ("delete", "double", "swap", "hole", "strange", "string"):
        kind = "outside"
    words = repair.what.split()
    if words == ["NAME"] and "NUMBER" in broken.accepted():
        words = ["EXP"]
    named = "`()`" if words == ["LPAR", "RPAR"] else " and ".join(name(word) for word in words)
    verb = "are" if len(words) > 1 and named != "`()`" else "is"
    if repair.kind == "insert":
        what, cure = named, f"write {named} here"
    elif repair.kind == "close":
        what, cure = named, "close what was opened: " + _opened(source, broken, words)
    else:
        return source.finding(
            rules.SYNTAX,
            Span(start, max(end, start)),
            found=found(broken.text[repair.start : repair.end]),
            expected=named if repair.kind in ("replace", "join") else expected(broken.accepted()),
            hint=hint or CURES.get(kind) or f"write {named}",
        )
    return source.finding(rules.MISSING, Span(start, end), what=f"{what} {verb}", hint=hint or cure)


def _opened(source: SourceText, broken: Broken, ends: list[str]) -> str:
    openers = [opener for opener in broken.openers() if opener[1] >= 0][-len(ends) :]
    return ", ".join(
        f"{type.lstrip('_')} of line {source.line_column(begin)[0]} with END{type[1:]}"
        for type, begin in reversed(openers)
    )


def name(terminal: str) -> str:
    return NAMES.get(terminal, f"`{terminal.lstrip('_')}`")


def found(text: str) -> str:
    if text.strip(" \t\r\n") and (not text.strip() or not text[0].isprintable()):
        return f"the character U+{ord(text[0]):04X}"
    text = " ".join(text.split())
    if len(text) > LONGEST_SHOWN:
        text = text[:LONGEST_SHOWN] + "…"
    return f"`{text}`" if text else "the end of the text"


def expected(terminals: Set[str]) -> str:
    """What could stand there, the kinds of things named once."""
    rest = set(terminals) - HOLES - SILENT - RUNS
    words = []
    if rest >= EXPRESSION:
        words.append("a value")
        rest -= EXPRESSION | {"NAME", "LPAR", "_NOT", "PLUS", "MINUS"}
    if rest >= ITEM:
        words.append("a declaration or routine")
        rest = {t for t in rest if t.startswith("_END")}
    if rest >= STATEMENT:
        words.append("a statement")
        rest = {t for t in rest if t.startswith("_END") or t in ("_ELSE", "_ELSEIF", "_CASE")}
    if len(rest & OPERATORS) > 3:
        words.append("an operator")
        rest -= OPERATORS
    words += sorted(map(name, rest))
    if len(words) > 6:
        words = [*words[:6], "…"]
    if len(words) < 2:
        return words[0] if words else "nothing more"
    return ", ".join(words[:-1]) + " or " + words[-1]
