"""The table of usual mistakes: what it looks like where a line cannot be read on, and the cure."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.languages.melfa_basic.rules import QUOTES, REMARK
from assistant.languages.melfa_basic.tables.vocabulary import statements
from assistant.languages.recovery.mistakes import Slip

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
