"""The reader of damaged texts of RAPID: its blocks, what people forget or confuse, its words."""

from __future__ import annotations

import re
from functools import cache
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.grammar import grammar
from assistant.languages.rapid.reading.recovery.statement_mistakes import MISTAKES
from assistant.languages.rapid.reading.scanner import SILENT, scanner, table_words
from assistant.languages.recovery.mistakes import TerminalGroup, Wording
from assistant.languages.recovery.reader import Reader
from assistant.languages.recovery.syntax import (
    Blocks,
    Changes,
    HalfHead,
    Holes,
    Layout,
    Scanner,
    Syntax,
)

_FLAGS: Final = re.IGNORECASE | re.MULTILINE

BLOCK_WORDS: Final = ("if", "for", "while", "test", "proc", "func", "trap", "record", "module")
"""Each begins a block that ends with the same word behind `end`."""
ENDS: Final = tuple("end" + word for word in BLOCK_WORDS if word not in ("record", "module"))

BLOCKS: Final = Blocks(
    ends={"_" + word.upper(): "_END" + word.upper() for word in BLOCK_WORDS},
    clauses=frozenset(("_ELSEIF", "_ELSE", "_CASE", "_DEFAULT", "_ERROR", "_BACKWARD", "_UNDO")),
    scopes=frozenset(("_PROC", "_FUNC", "_TRAP")),
    unit="_MODULE",
    unit_begin=re.compile(r"^[ \t]*(?:module[ \t]+\w|%%%)", _FLAGS),
    unit_end=re.compile(r"^[ \t]*endmodule\b", _FLAGS),
    item=re.compile(
        r"^[ \t]*(?:local[ \t]+|task[ \t]+)?(?:proc|func|trap|record|const|pers|var)[ \t]+\w",
        _FLAGS,
    ),
    starts=frozenset(("_FOR", "_RECORD", "_MODULE")),
    heads={
        "_IF": ("EXP", "_THEN"),
        "_ELSEIF": ("EXP", "_THEN"),
        "_ELSE": (),
        "_WHILE": ("EXP", "_DO"),
        "_FOR": ("NAME", "_FROM", "EXP", "_TO", "EXP", "_DO"),
        "_TEST": ("EXP", "_CASE", "EXP", "COLON"),
        "_CASE": ("EXP", "COLON"),
        "_DEFAULT": ("COLON",),
        "_ERROR": (),
        "_PROC": ("NAME", "LPAR", "RPAR"),
        "_FUNC": ("NAME", "NAME", "LPAR", "RPAR"),
        "_TRAP": ("NAME",),
        "_MODULE": ("NAME",),
    },
    last=frozenset(("_THEN", "_DO", "COLON", "RPAR")),
    braces={"LBRACE": ("_THEN", "_DO"), "COLON": ("_THEN", "_DO")},
    half=HalfHead(
        "_IF", "_THEN", "then", frozenset(("_ELSE", "_ELSEIF", "_ENDIF")), re.compile(r"![^\n]*")
    ),
)

_COMPARING: Final = ("LESS", "AT_MOST", "EQUAL", "MORE", "AT_LEAST", "UNEQUAL")
OPERATORS: Final = frozenset(
    ("PLUS", "MINUS", "STAR", "SLASH", *_COMPARING, "OR", "XOR", "AND", "DIV", "MOD")
)
CHANGES: Final = Changes(
    inserted=(
        *(("COMMA",), ("RPAR",), ("RSQB",), ("RBRACE",), ("_THEN",), ("_DO",), ("COLON",)),
        *(("_ASSIGN",), ("_FROM",), ("_TO",), ("_WITH",), ("LPAR", "RPAR"), ("LPAR",)),
        *(("RPAR", "RPAR"), ("RSQB", "RSQB"), ("RPAR", "SEMICOLON"), ("RSQB", "SEMICOLON")),
        *(("EXP",), ("NAME",), ("SEMICOLON",), ("BACKSLASH",), ("PERCENT",)),
        *(("EXP", "SEMICOLON"), ("LSQB",), ("LBRACE",), ("QMARK",)),
    ),
    openers=(
        *("_IF", "_ELSEIF", "_WHILE", "_FOR", "_TEST", "_CASE", "_PROC", "_FUNC"),
        *("VAR", "CONST", "PERS", "_TRAP", "_RECORD", "_ALIAS", "_MODULE"),
    ),
    needs={"_IF": frozenset(("_THEN", *_COMPARING, "OR", "XOR", "AND", "_NOT"))},
    alike=(
        *(("_ASSIGN", "EQUAL", "FOREIGN_EQUAL", "COLON", "MINUS"), ("_THEN", "_DO", "SEMICOLON")),
        *(("RPAR", "RSQB", "RBRACE"), ("LPAR", "LSQB", "LBRACE")),
        *(("COMMA", "DOT", "SEMICOLON", "COLON"), ("SLASH", "BACKSLASH")),
    ),
    unmeant=frozenset(("COLON", "MINUS")),
    wraps=(
        ("_PROC", "NAME", "LPAR", "RPAR"),
        ("_MODULE", "NAME"),
        ("_MODULE", "NAME", "_PROC", "NAME", "LPAR", "RPAR"),
    ),
    reserved={word: terminals[0] for word, terminals in grammar().words.items()},
    foreign={
        "next": ("endfor",),
        "wend": ("endwhile",),
        "endloop": ("endwhile", "endfor"),
        "endswitch": ("endtest",),
        "endselect": ("endtest",),
        "endsub": ("endproc",),
        "enddef": ("endproc",),
        "endprocedure": ("endproc",),
        "endfct": ("endfunc",),
        "end": (*ENDS, "endmodule"),
        "switch": ("test",),
        "select": ("test",),
        "otherwise": ("default",),
        "elif": ("elseif",),
        "def": ("proc",),
        "procedure": ("proc",),
        "sub": ("proc",),
        "function": ("func",),
    },
    strings=frozenset(("FOREIGN_STRING", "BAD_ESCAPE", "OPEN_STRING")),
    comments=frozenset(("FOREIGN_COMMENT",)),
    used=frozenset(("_ASSIGN", "DOT", "LBRACE")),
    table="TABLE",
)


def _open_line(ending: str, behind: str = "^") -> re.Pattern[str]:
    """What the rest of a line is like that begins a block and does not end it."""
    return re.compile(rf"{behind}(?!.*\b{ending}\b)", re.IGNORECASE)


LAYOUT: Final = Layout(
    openers={
        "if": _open_line("endif", r"\bthen\b"),
        "for": _open_line("endfor", r"\bdo\b"),
        "while": _open_line("endwhile", r"\bdo\b"),
        **{word: _open_line("end" + word) for word in ("test", "proc", "func", "trap", "module")},
    },
    closers={end: end.removeprefix("end") for end in (*ENDS, "endmodule")},
    clauses=frozenset(("else", "elseif", "case", "default", "error", "backward", "undo", "local")),
    before=frozenset(("local",)),
    code=re.compile(r'(?:"[^"\n]*"|[^!"\n])*'),
)


_VALUE: Final = frozenset(("NUMBER", "STRING", "TRUE", "FALSE", "LSQB"))
_HOLES: Final = {n for n, t in grammar().terminals.items() if re.fullmatch(r"<\w+>", t.pattern)}
_CLAUSES: Final = ("_ELSE", "_ELSEIF", "_CASE")

WORDING: Final = Wording(
    names={
        **grammar().marks,
        "NAME": "a name",
        "NUMBER": "a number",
        "STRING": "a string",
        "EXP": "a value",
        "HEADER": "`%%%`",
        "$END": "the end of the file",
    },
    unsaid=_HOLES | SILENT | {"TARGETS", "MOVES", "TABLE"},
    kinds=(
        TerminalGroup(_VALUE, "a value", frozenset(("NAME", "LPAR", "_NOT", "PLUS", "MINUS"))),
        TerminalGroup(
            frozenset(("_PROC", "_FUNC", "_RECORD")),
            "a declaration or routine",
            rest=lambda terminal: terminal.startswith("_END"),
        ),
        TerminalGroup(
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
    syntax = Syntax(
        scanner=Scanner(scanner(), SILENT),
        holes=Holes(
            {"EXP": "<EXP>", "NAME": "<ID>", "SMT": "<SMT>", "DDN": "<DDN>", "RDN": "<RDN>"}
        ),
        blocks=BLOCKS,
        changes=CHANGES,
        layout=LAYOUT,
        assign="_ASSIGN",
        value="EXP",
        data=frozenset(("VAR", "CONST", "PERS", "TASK", "LOCAL")),
        statement_holes=("SMT", "RDN", "DDN"),
        data_holes=("DDN",),
        glue=OPERATORS
        | {"COMMA", "LPAR", "LSQB", "LBRACE", "_ASSIGN", "BACKSLASH", "DOT", "COLON", "QMARK"},
        runs={"MOVES": ("NAME",), "TARGETS": ("CONST", "LOCAL")},
    )
    return Reader(table_words(), syntax, WORDING)
