"""Syntax errors in the words of the person who has to fix them."""

from __future__ import annotations

import re

# ruff: noqa: ARG005 (every row of a table takes the same arguments)
from collections.abc import Callable, Set
from typing import Final

NAMES: Final = {
    "NAME": "a name",
    "NUMBER": "a number",
    "STRING": "a string",
    "SEMICOLON": "`;`",
    "COMMA": "`,`",
    "COLON": "`:`",
    "DOT": "`.`",
    "LPAR": "`(`",
    "RPAR": "`)`",
    "LSQB": "`[`",
    "RSQB": "`]`",
    "LBRACE": "`{`",
    "RBRACE": "`}`",
    "PERCENT": "`%`",
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
SILENT: Final = frozenset({"NOTE", "COMMENT", "BLANK", "TARGETS", "MOVES", "TABLE"})
STATEMENT: Final = frozenset({"_IF", "_WHILE", "_FOR", "_TEST"})


def found(text: str) -> str:
    return f"`{text}`" if text.strip() else "the end of the text"


def expected(terminals: Set[str]) -> str:
    """What could stand there, the kinds of things named once."""
    rest = set(terminals) - HOLES - SILENT
    words = []
    if rest >= EXPRESSION:
        words.append("a value")
        rest -= EXPRESSION | {"NAME", "LPAR", "_NOT", "PLUS", "MINUS"}
    if rest >= STATEMENT:
        words.append("a statement")
        rest = {t for t in rest if t.startswith("_END") or t in ("_ELSE", "_ELSEIF", "_CASE")}
    if len(rest & OPERATORS) > 3:
        words.append("an operator")
        rest -= OPERATORS
    words += sorted(NAMES.get(t, f"`{t.lstrip('_')}`") for t in rest)
    if len(words) > 6:
        words = [*words[:6], "…"]
    if len(words) < 2:
        return words[0] if words else "nothing more"
    return ", ".join(words[:-1]) + " or " + words[-1]


def cure(before: str, word: str, terminals: Set[str]) -> str:
    """What to do, from the first row of the table that fits."""
    for fits, sentence in CURES:
        if fits(before, word, terminals):
            return sentence
    return "correct the text at this place"


ENDS: Final = ("_ENDIF", "_ENDFOR", "_ENDWHILE", "_ENDTEST", "_ENDPROC", "_ENDFUNC", "_ENDTRAP")
CLOSERS: Final = frozenset(
    (
        *("ENDIF", "ENDFOR", "ENDWHILE", "ENDTEST", "ENDPROC", "ENDFUNC", "ENDTRAP", "ENDMODULE"),
        *("PROC", "FUNC", "TRAP"),
    )
)

Fits = Callable[[str, str, Set[str]], bool]

CURES: Final[tuple[tuple[Fits, str], ...]] = (
    (lambda b, w, t: not w.strip() and not b.strip(), "write MODULE … ENDMODULE"),
    (
        lambda b, w, t: "_MODULE" in t and "_ENDMODULE" not in t,
        "a file of RAPID begins with MODULE and a name; nothing stands behind ENDMODULE",
    ),
    (lambda b, w, t: w in ("=", "==") and "COLON" in t, "assign with `:=`"),
    (lambda b, w, t: w == "=" and b.rstrip().endswith("="), "compare with a single `=`"),
    (lambda b, w, t: w == "==", "compare with a single `=`"),
    (lambda b, w, t: w.upper() == "NOT", "write the NOT in parentheses: `a AND (NOT b)`"),
    (
        lambda b, w, t: w in ("+", "-") and b.rstrip()[-1:] in "*/+-<>=",
        "write the signed value in parentheses: `a*(-1)`",
    ),
    (
        lambda b, w, t: w.startswith('"'),
        'end the string with `"` on the same line; write `\\\\` for a backslash, `""` for a quote',
    ),
    (lambda b, w, t: w == "'", 'write strings in double quotes: `"text"`'),
    (lambda b, w, t: w == "#" or (w == "/" and b.endswith("/")), "begin a comment with `!`"),
    (
        lambda b, w, t: w == "," and re.search(r"\w\s*\([^()]*$", b) is not None,
        "call a procedure without parentheses: `name a, b;`",
    ),
    (lambda b, w, t: w == ")" and "RPAR" not in t, "delete it, or open a parenthesis before"),
    (
        lambda b, w, t: not w.strip() and "_ENDMODULE" in t,
        "end the module with ENDMODULE",
    ),
    (
        lambda b, w, t: any(e in t for e in ENDS) and (not w.strip() or w.upper() in CLOSERS),
        "close what was opened: IF with ENDIF, FOR with ENDFOR, PROC with ENDPROC …",
    ),
    (lambda b, w, t: "SEMICOLON" in t, "end the statement before it with `;`"),
    (
        lambda b, w, t: t == {"NAME"} or (t - {"NAME"}) <= HOLES | SILENT,
        "write a name that begins with a letter and is no word of the language",
    ),
)
"""(does it fit the text before, the word found and what was expected; what to do)."""
