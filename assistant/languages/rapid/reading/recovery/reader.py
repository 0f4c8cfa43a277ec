"""The reader of damaged texts of RAPID, and its words."""

from __future__ import annotations

from functools import cache
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.recovery.statement_mistakes import MISTAKES
from assistant.languages.rapid.reading.recovery.syntax import OPERATORS, syntax
from assistant.languages.rapid.reading.scanner import SILENT, table_words
from assistant.languages.recovery.reading import Reader
from assistant.languages.recovery.wording import Kind, Wording

_VALUE: Final = frozenset(("NUMBER", "STRING", "TRUE", "FALSE", "LSQB"))
_HOLES: Final = "TDN DDN RDN PAR ALT DIM SMT VAR_HOLE EIT CSE EXP ARG"
_CLAUSES: Final = ("_ELSE", "_ELSEIF", "_CASE")

WORDING: Final = Wording(
    names={
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
    },
    unsaid=frozenset((*_HOLES.split(), *SILENT, "TARGETS", "MOVES", "TABLE")),
    kinds=(
        Kind(_VALUE, "a value", frozenset(("NAME", "LPAR", "_NOT", "PLUS", "MINUS"))),
        Kind(
            frozenset(("_PROC", "_FUNC", "_RECORD")),
            "a declaration or routine",
            rest=lambda terminal: terminal.startswith("_END"),
        ),
        Kind(
            frozenset(("_IF", "_GOTO", "_RETURN")),
            "a statement",
            rest=lambda terminal: terminal.startswith("_END") or terminal in _CLAUSES,
        ),
    ),
    operators=OPERATORS,
    cures={
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
    },
    mistakes=MISTAKES,
    wrong=rules.SYNTAX,
    missing=rules.MISSING,
    many=rules.MANY,
)


@cache
def reader() -> Reader:
    return Reader(table_words(), syntax(), WORDING)
