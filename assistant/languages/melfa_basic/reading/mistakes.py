"""Usual mistakes and their cures, and the reader of damaged lines.

`MISTAKES` states what a mistake looks like at the point where a line cannot be read any further.
Words of other languages are in `foreign.txt`, beside this file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.line import (
    Nodes,
    keywords,
    line_grammar,
    placed,
    split_step,
)
from assistant.languages.melfa_basic.rules import QUOTES, REMARK
from assistant.languages.melfa_basic.tables.variables import keyword_spelling
from assistant.languages.melfa_basic.tables.vocabulary import statement, statements
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.recovery.line_repairs import LineReader, LineSyntax, Missing, Phrase
from assistant.languages.recovery.mistakes import Slip

# Words of several parts would need blanks in the pattern.
_WORDS: Final = "|".join(word for word in statements() if word.isalnum())

MISTAKES: Final = (
    Slip(
        "`{1}` is a typographic mark", "write the plain mark ' before a comment",
        "1 Mvs P1 ¦‘go", r"([‘’‚‛′´`＇]).*", "'", rule=QUOTES,
    ),
    Slip(
        "`{1}` is a typographic mark", 'write the plain mark " around a text',
        "1 CallP ¦“SUB”", "([“”„‟″＂])([^“”„‟″＂\"]*)[“”„‟″＂\"]", r'"\2"', rule=QUOTES,
    ),
    Slip(
        "`{1}` is a typographic mark", 'write the plain mark " around a text',
        "1 CallP ¦“SUB", "([“”„‟″＂]).*", '"x"', rule=QUOTES,
    ),
    Slip(
        "a blank of a wide alphabet stands here", "write a plain blank",
        "1 Mvs P1¦\u3000Wth M_Out(1)=1", "[\u3000\u00a0\u2000-\u200b\ufeff]+", " ",
        rule=QUOTES,
    ),
    Slip(
        "`{0}` is a mark of a wide alphabet", "write the plain mark",
        "1 Mvr P1¦，P2,P3", "[，、]", ",", rule=QUOTES,
    ),
    Slip(
        "`{0}` is a mark of a wide alphabet", "write a plain minus",
        "1 Mov P1,¦–50", "[–—−－]", "-", rule=QUOTES,
    ),
    Slip(
        "", "", "1 Error 9100\t¦Raises an error.", r"(?:[A-Z][a-z]+(?: [\w-]+)+\.?|\.)\s*$", "'",
        r"\t\s*", rule=REMARK,
    ),
    Slip(
        "the text has no closing quote", 'write a `"` at its end',
        '1 CallP ¦"SUB', r'"([^"]*)', r'"\1"',
    ),
    Slip(
        "`{0}` assigns in other languages", "write `=`", "1 M1¦:=5", ":=", "=",
    ),
    Slip("`{1}` is a word of the language, no variable", "give the variable another name",
            "1 ¦Fine=2", rf"({_WORDS})\s*=(?!=)", "M1=", rf"^\s*(?P<at>(?:{_WORDS})\s*)",
            back=True),
    Slip("`{0}` compares in other languages", "write `=`", "1 If M1=¦=1 Then *A", "=+", ""),
    Slip(
        "`{0}` compares in other languages", "write `<>`", "1 If M1 ¦!= 1 Then *A", r"!\s*=", "<>",
    ),
    Slip("`{0}` joins conditions in other languages", "write `And`",
            "1 If M1=1 ¦&& M2=1 Then *A", "&&", " And "),
    Slip("`&&` joins conditions in other languages", "write `And`",
            "1 If M1=M2¦&& M2=1 Then *A", "&&", " And ", "&", back=True),
    Slip("`{0}` joins conditions in other languages", "write `Or`",
            "1 If M1=1 ¦|| M2=1 Then *A", r"\|+", " Or "),
    Slip("`**` is a power in other languages", "write `^`", "1 M1=M2¦**2", r"\*\*", "^",
            r"\*", back=True),
    Slip("`{0}` counts on in other languages", "write the variable again: `M1=M1+1`",
            "1 M1¦+=1", r"[-+*/]=", "="),
    Slip("`{0}` counts on in other languages", "write `=` and the variable again: `M1=M1+1`",
            "1 M1¦++", r"\+\+|--", "=1"),
    Slip("`{1}` begins a comment in other languages", "write `'` before a comment",
            "1 Mov P1 ¦// go", r"(//|/\*|--|\\\\)(?!\s*$).*", "'"),
    Slip("`//` begins a comment in other languages", "write `'` before a comment",
            "1 M1=2 ¦// go", r"//.*", "'", r"/", back=True),
    Slip("`{1}` begins a comment in other languages", "write `'` before a comment",
            "1 Mov P1 ¦! go on", r"([#!%])(?!=).*", "'", r"(?:^|\s)\s*"),
    Slip("a `;` stands at the end", "leave it out: the line's end is the statement's",
            "1 Mov P1¦;", r";\s*(?='|$)", ""),
    Slip("the step number has no blank behind it", "write a blank between number and statement",
            "¦10MOV P1", r"(\d{1,5})(?=[A-Za-z])", r"\1 ", "^"),
    Slip("two step numbers stand here", "leave one of them out",
            "10 ¦20 End", r"\d+[ \t]*", "", r"^[ \t]*"),
    Slip("the label has no `*` before it", "write `*{1}`",
            "1 ¦Again: M1=1", r"([A-Za-z]\w*)\s*:", r"*\1:",
            r"^\s*(?P<at>[A-Za-z]\w*\s*)", back=True),
    Slip("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 GoTo ¦Again", r"([A-Za-z]\w*)", r"*\1", r"\b(?:GoTo|GoSub)\s+"),
    Slip("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 If M1=1 Then ¦Again", r"([A-Za-z]\w*)\s*(?=$|'|Else\b)", r"*\1 ",
            r"\b(?:Then|Else)\s+(?P<at>(?!Go(?:To|Sub)\b)[A-Za-z]\w*\s*)", back=True),
    Slip("`EndIf` stands behind an If that is one line", "leave it out, or put it and what is "
            "behind `Then` on lines of their own",
            "1 If M1=1 Then M2=1 ¦EndIf", r"End\s*If\b", "", r"\bThen\b.+"),
    Slip("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 On M1 GoTo *A,¦Again", r"([A-Za-z]\w*)", r"*\1", r"\bOn\b.*\bGo(?:To|Sub)\b.*,\s*"),
    Slip("a `:` stands at the end", "leave it out: the line's end is the statement's",
            "1 Case 1¦:", r":\s*(?='|$)", ""),
    Slip("`{0}` begins a loop in other languages", "leave it out",
            "1 While M1=1 ¦Do", r"Do\s*(?='|$)", "", r"\bWhile\b.+"),
    Slip("the constant has no `)` at its end", "write it",
            "P1=(1,2,3,0,0,0)¦(7,0", r"\(([^()']*[^()'\s])", r"(\1)", r"\)\s*"),
    Slip("`{0}` are no flags", "write two numbers with a comma between them: `(7,0)`",
            "P1=(1,2,3,0,0,0)¦(7 0)", r"\([^()']*\)", "(7,0)", r"\([^()]*,[^()]*\)\s*"),
    Slip("`{0}` is no constant", "write numbers with commas between them; what is worked out "
            "is assigned part by part, `P1.X=M1`",
            "1 P1=¦(1,2,M1)", r"\([^()']*,[^()']*\)(?:\s*\([^()']*\))?", "(0,0)",
            r"(?<!\w)(?P<at>\(\s*[^(),]*)", back=True),
    Slip("a line holds one statement", "put what follows `:` on a line of its own",
            "1 Mov P1¦: Mov P2", r":.*", ""),
    Slip("a line holds one statement", "put what follows `;` on a line of its own",
            "1 Mov P1¦; Mov P2", r";.*", ""),
    Slip("something stands behind `Else`", "put it on a line of its own",
            "1 Else ¦M1=1", r"\S.*", "", r"^\s*Else\s+"),
    Slip("`{0}` opens a list in other languages", "write `(` and `)`",
            "1 M1=M2¦[3]", r"\[([^\[\]]*)\]", r"(\1)"),
    Slip("`{0}` opens a list in other languages", "write `(` and `)`",
            "1 P1=¦{{1,2,3}}", r"\{([^{}]*)\}", r"(\1)"),
    Slip("`{0}` is a unit", "leave it out: lengths are in mm, angles in degrees, times in s",
            "1 Dly 5 ¦s", r"(?:mm/s|mm|cm|ms|sec|s|m|deg|%)(?![\w(])", "", r"[0-9.]\s*"),
    Slip("`Print` names no line to send to", "write `Print #1,` with the number of the line",
            '1 Print ¦"go"', r'(?=[^#\s])', "#1,", r"\bPrint\s*"),
    Slip("`Input` names no line to read from", "write `Input #1,` with the number of the line",
            "1 Input ¦M1", r'(?=[^#\s])', "#1,", r"\bInput\s*"),
    Slip("`As {1}` declares a type in other languages", "declare it with `Def Inte`, `Def Pos` "
            "and so on", "1 Dim M1(2) ¦As Integer", r"As\s+(\w+)", ""),
)  # fmt: skip


@cache
def foreign_words() -> Mapping[str, tuple[str, str]]:
    """Words of other languages in lower case: what to write, and the cure."""
    text = files(__package__).joinpath("foreign.txt").read_text("utf-8")
    rows = (line.split("|") for line in text.splitlines() if line and not line.startswith("#"))
    found = {}
    for cells in rows:
        word, write, cure = (cell.strip() for cell in cells)
        found[word] = ("" if write == "-" else write, cure.replace("¦", write))
    return found


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
_PHRASES: Final = (
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
# Three words or more: a short line may be a misspelled statement.
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
        phrases=_PHRASES,
        unsaid={"SIGN": frozenset(("EQUALS",))},  # which compares there, as other operators do
        wrong=rules.SYNTAX,
    )
    return LineReader(syntax)


def _parted(written: str) -> int | None:
    """Return the length of a word that its operand follows without a blank: `MOVP1`, `GOTO100`,
    `DLY1`.
    """
    # The longest word first, as `MVR2` begins with `MVR`.
    for size in range(len(written) - 1, 1, -1):
        known = statement(written[:size])
        if known is not None and known.role != "part" and _OPERAND.match(written, size):
            return size
    return None
