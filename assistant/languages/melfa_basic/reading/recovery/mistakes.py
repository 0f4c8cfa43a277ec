"""The table of usual mistakes: what it looks like where a line cannot be read on, and the cure."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import statements


@dataclass(frozen=True, slots=True)
class Mistake:
    r"""A row of the table.

    what, cure: of the finding; `{0}` is what `at` matched, `{1}` its first group. before: how the
    line up to the error ends, counted from its step number on. at: how the text from the error on
    begins; with `back`, what `before` matched counts as that, or its group `at`. write: what
    stands in place of it while the line is read on. example: a line, `¦` at the place that is
    shown. number: the controller's error.
    """

    what: str
    cure: str
    example: str
    at: str
    write: str
    before: str = ""
    back: bool = False
    number: int = 4220

    def edit(self, text: str, start: int, error: int, end: int) -> Edit | None:
        """What to put where, None if it is another mistake.

        start, error, end: offsets of the code's begin, of the word that does not fit, of the end.
        """
        begin = error
        if self.before:
            found = re.compile(rf"(?:{self.before})\Z", _FLAGS).search(text[start:error])
            if found is None:
                return None
            if self.back:
                begin = start + found.start("at" if "at" in found.re.groupindex else 0)
        match = re.compile(self.at, _FLAGS).match(text, begin, end)
        if match is None:
            return None
        groups = (match[0].strip(), *(group or "" for group in match.groups()))
        return Edit(
            match.start(),
            match.end(),
            match.expand(self.write),
            self.what.format(*groups),
            self.cure.format(*groups),
            self.number,
        )


@dataclass(frozen=True, slots=True)
class Edit:
    """A change to a line that is to make it MELFA-BASIC, and what to say about it."""

    start: int
    end: int
    text: str
    what: str
    cure: str
    number: int = 4220
    cost: int = 0


_FLAGS: Final = re.IGNORECASE

ILLEGAL: Final = 4310
"""The controller's error for a character that programs cannot have."""

_WORDS: Final = "|".join(word for word in statements() if word.isalnum())

MISTAKES: Final = (
    Mistake(
        "`{1}` is a typographic mark", "write the plain mark ' before a comment",
        "1 Mvs P1 ¦‘go", r"([‘’‚‛′´`＇]).*", "'", number=ILLEGAL,
    ),
    Mistake(
        "`{1}` is a typographic mark", 'write the plain mark " around a text',
        "1 CallP ¦“SUB”", "([“”„‟″＂])([^“”„‟″＂\"]*)[“”„‟″＂\"]", r'"\2"', number=ILLEGAL,
    ),
    Mistake(
        "`{1}` is a typographic mark", 'write the plain mark " around a text',
        "1 CallP ¦“SUB", "([“”„‟″＂]).*", '"x"', number=ILLEGAL,
    ),
    Mistake(
        "a blank of a wide alphabet stands here", "write a plain blank",
        "1 Mvs P1¦\u3000Wth M_Out(1)=1", "[\u3000\u00a0\u2000-\u200b\ufeff]+", " ",
        number=ILLEGAL,
    ),
    Mistake(
        "`{0}` is a mark of a wide alphabet", "write the plain mark",
        "1 Mvr P1¦，P2,P3", "[，、]", ",", number=ILLEGAL,
    ),
    Mistake(
        "`{0}` is a mark of a wide alphabet", "write a plain minus",
        "1 Mov P1,¦–50", "[–—−－]", "-", number=ILLEGAL,
    ),
    Mistake(
        "the text has no closing quote", 'write a `"` at its end',
        '1 CallP ¦"SUB', r'"([^"]*)', r'"\1"',
    ),
    Mistake(
        "`{0}` assigns in other languages", "write `=`", "1 M1¦:=5", ":=", "=",
    ),
    Mistake("`{1}` is a word of the language, no variable", "give the variable another name",
            "1 ¦Fine=2", rf"({_WORDS})\s*=(?!=)", "M1=", rf"^\s*(?P<at>(?:{_WORDS})\s*)",
            back=True),
    Mistake("`{0}` compares in other languages", "write `=`", "1 If M1=¦=1 Then *A", "=+", ""),
    Mistake(
        "`{0}` compares in other languages", "write `<>`", "1 If M1 ¦!= 1 Then *A", r"!\s*=", "<>",
    ),
    Mistake("`{0}` joins conditions in other languages", "write `And`",
            "1 If M1=1 ¦&& M2=1 Then *A", "&&", " And "),
    Mistake("`&&` joins conditions in other languages", "write `And`",
            "1 If M1=M2¦&& M2=1 Then *A", "&&", " And ", "&", back=True),
    Mistake("`{0}` joins conditions in other languages", "write `Or`",
            "1 If M1=1 ¦|| M2=1 Then *A", r"\|+", " Or "),
    Mistake("`**` is a power in other languages", "write `^`", "1 M1=M2¦**2", r"\*\*", "^",
            r"\*", back=True),
    Mistake("`{0}` counts on in other languages", "write the variable again: `M1=M1+1`",
            "1 M1¦+=1", r"[-+*/]=", "="),
    Mistake("`{0}` counts on in other languages", "write `=` and the variable again: `M1=M1+1`",
            "1 M1¦++", r"\+\+|--", "=1"),
    Mistake("`{1}` begins a comment in other languages", "write `'` before a comment",
            "1 Mov P1 ¦// go", r"(//|/\*|--|\\\\)(?!\s*$).*", "'"),
    Mistake("`//` begins a comment in other languages", "write `'` before a comment",
            "1 M1=2 ¦// go", r"//.*", "'", r"/", back=True),
    Mistake("`{1}` begins a comment in other languages", "write `'` before a comment",
            "1 Mov P1 ¦! go on", r"([#!%])(?!=).*", "'", r"(?:^|\s)\s*"),
    Mistake("a `;` stands at the end", "leave it out: the line's end is the statement's",
            "1 Mov P1¦;", r";\s*(?='|$)", ""),
    Mistake("the step number has no blank behind it", "write a blank between number and statement",
            "¦10MOV P1", r"(\d{1,5})(?=[A-Za-z])", r"\1 ", "^"),
    Mistake("two step numbers stand here", "leave one of them out",
            "10 ¦20 End", r"\d+[ \t]*", "", r"^[ \t]*"),
    Mistake("the label has no `*` before it", "write `*{1}`",
            "1 ¦Again: M1=1", r"([A-Za-z]\w*)\s*:", r"*\1:",
            r"^\s*(?P<at>[A-Za-z]\w*\s*)", back=True),
    Mistake("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 GoTo ¦Again", r"([A-Za-z]\w*)", r"*\1", r"\b(?:GoTo|GoSub)\s+"),
    Mistake("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 If M1=1 Then ¦Again", r"([A-Za-z]\w*)\s*(?=$|'|Else\b)", r"*\1 ",
            r"\b(?:Then|Else)\s+(?P<at>(?!Go(?:To|Sub)\b)[A-Za-z]\w*\s*)", back=True),
    Mistake("`EndIf` stands behind an If that is one line", "leave it out, or put it and what is "
            "behind `Then` on lines of their own",
            "1 If M1=1 Then M2=1 ¦EndIf", r"End\s*If\b", "", r"\bThen\b.+"),
    Mistake("`{1}` has no `*` before it, as a label has", "write `*{1}`",
            "1 On M1 GoTo *A,¦Again", r"([A-Za-z]\w*)", r"*\1", r"\bOn\b.*\bGo(?:To|Sub)\b.*,\s*"),
    Mistake("a `:` stands at the end", "leave it out: the line's end is the statement's",
            "1 Case 1¦:", r":\s*(?='|$)", ""),
    Mistake("`{0}` begins a loop in other languages", "leave it out",
            "1 While M1=1 ¦Do", r"Do\s*(?='|$)", "", r"\bWhile\b.+"),
    Mistake("the constant has no `)` at its end", "write it",
            "P1=(1,2,3,0,0,0)¦(7,0", r"\(([^()']*[^()'\s])", r"(\1)", r"\)\s*"),
    Mistake("`{0}` are no flags", "write two numbers with a comma between them: `(7,0)`",
            "P1=(1,2,3,0,0,0)¦(7 0)", r"\([^()']*\)", "(7,0)", r"\([^()]*,[^()]*\)\s*"),
    Mistake("`{0}` is no constant", "write numbers with commas between them; what is worked out "
            "is assigned part by part, `P1.X=M1`",
            "1 P1=¦(1,2,M1)", r"\([^()']*,[^()']*\)(?:\s*\([^()']*\))?", "(0,0)",
            r"(?<!\w)(?P<at>\(\s*[^(),]*)", back=True),
    Mistake("a line holds one statement", "put what follows `:` on a line of its own",
            "1 Mov P1¦: Mov P2", r":.*", ""),
    Mistake("a line holds one statement", "put what follows `;` on a line of its own",
            "1 Mov P1¦; Mov P2", r";.*", ""),
    Mistake("something stands behind `Else`", "put it on a line of its own",
            "1 Else ¦M1=1", r"\S.*", "", r"^\s*Else\s+"),
    Mistake("`{0}` opens a list in other languages", "write `(` and `)`",
            "1 M1=M2¦[3]", r"\[([^\[\]]*)\]", r"(\1)"),
    Mistake("`{0}` opens a list in other languages", "write `(` and `)`",
            "1 P1=¦{{1,2,3}}", r"\{([^{}]*)\}", r"(\1)"),
    Mistake("`{0}` is a unit", "leave it out: lengths are in mm, angles in degrees, times in s",
            "1 Dly 5 ¦s", r"(?:mm/s|mm|cm|ms|sec|s|m|deg|%)(?![\w(])", "", r"[0-9.]\s*"),
    Mistake("`Print` names no line to send to", "write `Print #1,` with the number of the line",
            '1 Print ¦"go"', r'(?=[^#\s])', "#1,", r"\bPrint\s*"),
    Mistake("`Input` names no line to read from", "write `Input #1,` with the number of the line",
            "1 Input ¦M1", r'(?=[^#\s])', "#1,", r"\bInput\s*"),
    Mistake("`As {1}` declares a type in other languages", "declare it with `Def Inte`, `Def Pos` "
            "and so on", "1 Dim M1(2) ¦As Integer", r"As\s+(\w+)", ""),
)  # fmt: skip


@cache
def foreign() -> Mapping[str, tuple[str, str]]:
    """Words of other languages in lower case: what to write, and the cure."""
    text = files(__package__).joinpath("foreign.txt").read_text("utf-8")
    rows = (line.split("|") for line in text.splitlines() if line and not line.startswith("#"))
    found = {}
    for cells in rows:
        word, write, cure = (cell.strip() for cell in cells)
        found[word] = ("" if write == "-" else write, cure.replace("¦", write))
    return found
