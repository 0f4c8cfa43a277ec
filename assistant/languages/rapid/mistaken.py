"""Usual mistakes in RAPID, as small broken programs with their cures."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from assistant.languages.rapid.layout_hints import code_end

if TYPE_CHECKING:
    from assistant.languages.rapid.broken import Broken, Repair


@dataclass(frozen=True, slots=True)
class Mistake:
    """A row of the table.

    examples: statements, items or whole files with `¦` at the place that a finding must show.
    before: regular expression for what ends at the error, or with `block` stands anywhere from
    the begin of the open block on; its group `at`, if it has one, is the place.
    after: for what begins at the error. repair: for the kind and the word of the change that
    mends it, `insert SEMICOLON`. here: the place is the word that does not fit.
    """

    cure: str
    examples: tuple[str, ...]
    before: str = ""
    after: str = ""
    repair: str = ""
    shown: str = ""
    within: Literal["statement", "line", "block"] = "statement"
    here: bool = False

    def place(self, broken: Broken, repair: Repair) -> int | None:
        """Offset to show, -1 for that of the repair; None if it is another mistake."""
        text, error = broken.text, broken.word.start
        if self.repair and not re.fullmatch(self.repair, f"{repair.kind} {repair.what}".strip()):
            return None
        if self.shown and not re.compile(self.shown).match(text, repair.start):
            return None
        if self.after and not re.compile(self.after, _FLAGS).match(text, error):
            return None
        if self.before:
            begin = self._begin(broken, repair)
            pattern = self.before if self.within == "block" else rf"(?:{self.before})\s*\Z"
            found = re.compile(pattern, _FLAGS).search(text[begin:error])
            if found is None:
                return None
            if "at" in found.re.groupindex:
                return begin + found.start("at")
        return error if self.here else -1

    def _begin(self, broken: Broken, repair: Repair) -> int:
        """Where the text that `before` looks at begins."""
        if self.within == "line":
            return broken.text.rfind("\n", 0, code_end(broken.text, broken.word.start)) + 1
        if self.within == "block":
            return broken.block if repair.kept is None else repair.kept.at
        return broken.words[0].start


_FLAGS: Final = re.IGNORECASE


MISTAKES: Final = (
    Mistake(
        "write MODULE … ENDMODULE",
        ("¦",),
        before=r"\A",
        after=r"\s*\Z",
        repair=r"outside",
    ),
    Mistake(
        "write unequal as `<>`; `!` begins a comment",
        ("IF a ¦!= b THEN\n  c;\nENDIF", "WHILE a ¦!= 1 DO\n  b;\nENDWHILE"),
        before=r"(?P<at>!=)",
        within="block",
        repair=r"insert _(THEN|DO)",
    ),
    Mistake(
        "write unequal as `<>` and NOT in a word; `!` begins a comment",
        ("IF a ¦!= b c;", "IF ¦!a b;", "a := ¦!b;"),
        before=r"(?:(?:IF|WHILE)\b|:=)[^!\"\n]*(?P<at>![=\w(])[^\n]*",
    ),
    Mistake(
        "write FROM: `FOR i FROM 1 TO 10 DO`",
        ("FOR i ¦= 1 TO 10 DO\n  a;\nENDFOR", "FOR i ¦:= 1 TO 10 DO\n  a;\nENDFOR"),
        before=r"\A\s*FOR\s+\w+",
        after=r":?=",
    ),
    Mistake(
        "write it in one piece: `<=`, `>=` or `<>`",
        ("IF a =¦> 1 b;", "IF a =¦< 1 b;", "IF a < ¦> 1 b;"),
        before=r"=|<[ \t]+",
        after=r"[<>]",
    ),
    Mistake(
        r"write `\` before the name of an optional argument",
        ("MoveL a,b,c,d ¦/WObj:=e;",),
        before=r"(?P<at>/)\s*\w+",
        after=r":=",
        repair=r"replace EQUAL",
    ),
    Mistake(
        r"write `\` before the name of an optional argument",
        ("MoveL a,b,c,d ¦WObj:=e;", "a := Round(b ¦Dec:=1);"),
        before=r"[\w)\]]",
        after=r"\w+\s*:=",
        repair=r"insert COMMA",
        here=True,
    ),
    Mistake(
        r"write `:=` before the value of the argument, or `,` behind it if it has none",
        (r"MoveL a,b,c,d \WObj¦ e;", r"q \A¦ b;"),
        before=r"\\\s*\w+",
        after=r"\w",
        repair=r"insert COMMA",
    ),
    Mistake(
        r"a parameter has no value of its own: make it optional with `\`, and ask Present(a)",
        ("PROC q(num a ¦= 5)\n  b;\nENDPROC", "PROC q(\\num a¦:=5)\n  b;\nENDPROC"),
        before=r"\A\s*(?:LOCAL\s+)?(?:PROC|FUNC)\b[^;]*\w",
        after=r":?=",
    ),
    Mistake(
        "assign with `:=`",
        ("a ¦= 1;", "a ¦== 1;", "CONST num a ¦= 1;", "p.trans.x ¦= 2;", "a{2} ¦= 3;"),
        before=r"[\w.}]",
        after=r"=",
        repair=r"replace _ASSIGN",
    ),
    Mistake(
        "write it out: `a:=a+1`",
        ("a ¦+= 1;", "a ¦-= b;"),
        before=r"\w\s*(?P<at>[-+*/])",
        after=r"=",
    ),
    Mistake(
        "write it out: `a:=a+1`",
        ("a ¦++;",),
        before=r"\A\s*\w+\s*(?P<at>[-+])",
        after=r"[-+]\s*;",
    ),
    Mistake(
        "compare with a single `=`",
        ("IF a ¦== 1 b;", "WHILE a ¦== 1 DO\n  b;\nENDWHILE", "a := b ¦== c;"),
        after=r"==",
    ),
    Mistake(
        "compare with `=`; `:=` assigns",
        ("IF a ¦:= 1 THEN\n  b;\nENDIF",),
        after=r":=",
        repair=r"replace EQUAL",
    ),
    Mistake(
        "join strings with `+`",
        ('TPWrite "a" ¦& b;', 'a := "b" ¦"c";'),
        before=r'"',
        after=r'&(?!&)|"',
    ),
    Mistake(
        "write the remainder as `a MOD b`, a power as `Pow(a,b)`",
        ("a := b ¦% 2;", "a := b¦^2;"),
        before=r":=[^;]*[\w)}]",
        after=r"[%^]",
    ),
    Mistake(
        "write an index and the size of an array in braces: `a{1}`",
        ("a := b¦[1];", "VAR num a¦[5];"),
        before=r"\A\s*(?:(?:VAR|PERS|CONST)\s+\w+\s+\w+|\w+\s*:=[^;]*\w)",
        after=r"\[[^\[\],]*(?:,[^\[\],]*)?\]",
    ),
    Mistake(
        "write a list of values in brackets: `[1,2]`",
        ("VAR num a{2} :=¦ {1,2};", "VAR pos a := (1¦,2,3);"),
        before=r":=\s*(?:\(\s*[-+\d.]+)?",
        after=r"\{|,\s*[-+\d.]+\s*,",
    ),
    Mistake(
        "write AND, OR",
        ("IF a ¦&& b THEN\n  c;\nENDIF", "IF a ¦|| b THEN\n  c;\nENDIF"),
        after=r"&&?|\|\|?",
    ),
    Mistake(
        "write the NOT in parentheses: `a AND (NOT b)`",
        ("a := b AND ¦NOT c;", "IF a OR ¦NOT b THEN\n  c;\nENDIF", "a := b = ¦NOT c;"),
        after=r"NOT\b",
        here=True,
    ),
    Mistake(
        "write the signed value in parentheses: `a*(-1)`",
        ("a := b*¦-1;", "a := b + ¦-c;", "a := b/¦-c;"),
        before=r"[-+*/<>=]",
        after=r"[-+]",
        here=True,
    ),
    Mistake(
        "delete the `,`: the first argument stands behind the name",
        ("MoveL¦, a,b,c,d;",),
        before=r"\A\s*\w+",
        after=r",",
        repair=r"insert EXP",
    ),
    Mistake(
        "delete the `,`, or write the value that is missing",
        ("q 1,¦;", "a := [1,2,¦];", "a := b(1,¦);"),
        before=r",",
        after=r"[;)\]]",
        repair=r"insert (EXP|NAME).*",
    ),
    Mistake(
        "delete one `,`, or write the value that is missing between them",
        ("q 1,¦,2;", "MoveJ a, ¦,z50,b;", "a := [0,1, ¦,0];"),
        before=r",",
        after=r",",
        repair=r"double",
    ),
    Mistake(
        "delete one `]`",
        ("CONST pose a := [[1,2,3]¦],[1,0,0,0]];", "a := [[1,2],[3,4]¦],[5,6]];"),
        repair=r"delete",
        before=r":=[^;]*\]",
        after=r",",
        shown=r"\]",
    ),
    Mistake(
        "write the value in one piece, in brackets: `[[1,2,3],[1,0,0,0]]`",
        ("CONST pose a := [1,2,3]¦,[1,0,0,0];",),
        before=r":=\s*\[[^;]*\]",
        after=r",",
        repair=r"hole|delete|insert SEMICOLON",
    ),
    Mistake(
        "write `(` in front of the parameters",
        ("PROC q¦ num a)\n  b;\nENDPROC", "FUNC num q¦ num a)\n  RETURN a;\nENDFUNC"),
        repair=r"insert LPAR",
        before=r"\A\s*(?:LOCAL\s+)?(?:PROC|FUNC)\b[^;(]*",
    ),
    Mistake(
        "delete one of the two",
        ("CONST ¦CONST num a := 3;", "VAR num ¦num a := 0;", "PROC ¦PROC q()\n  b;\nENDPROC"),
        repair=r"double",
    ),
    Mistake(
        "write `[` in front of the first value",
        (
            "VAR bool a{3} := ¦FALSE,TRUE,FALSE];",
            "CONST pose a := ¦[1,2,3],[1,0,0,0]];",
        ),
        repair=r"insert LSQB",
        before=r":=[^;]*",
    ),
    Mistake(
        "swap the name and `:=`",
        ("¦:= a FALSE;",),
        after=r":=",
        repair=r"swap",
    ),
    Mistake(
        "RAPID has no `?`: write IF … THEN … ELSE … ENDIF",
        ("a := b ¦? 1 : 2;",),
        before=r":=[^;]*",
        after=r"\?",
    ),
    Mistake(
        "write the type before the name, without `:`",
        (
            "VAR a¦: num;",
            "VAR a ¦: num := 5;",
            "PROC q(a¦: num)\n  b;\nENDPROC",
        ),
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:(?:VAR|PERS|CONST)\s+|(?:PROC|FUNC)\b[^;]*[(,]\s*)\w+",
        after=r":(?!=)",
    ),
    Mistake(
        "write `CONNECT interrupt WITH trap;`",
        ("CONNECT a ¦TO b;", "CONNECT a¦, b;"),
        before=r"\A\s*CONNECT\s+\w+",
    ),
    Mistake(
        "write the number alone: lengths are in mm, angles in degrees, times in seconds",
        ("a := 5 ¦mm;", "WaitTime 2 ¦s;", "a := b + 3¦deg;"),
        before=r"[0-9.]\s*",
        after=r"(?:mm|cm|m|deg|rad|s|ms|sec|kg)\b",
        here=True,
    ),
    Mistake(
        "write a hexadecimal number as `0xFF`",
        ("a := ¦$FF;",),
        before=r":=[^;]*",
        after=r"\$[0-9a-f]+\s*;",
    ),
    Mistake(
        "RAPID has no braces around statements: THEN … ENDIF, DO … ENDWHILE, PROC … ENDPROC",
        (
            "IF a = 1 ¦{\n  b;\nENDIF",
            "IF a ¦{\n  b;\nENDIF",
            "WHILE (a < 1) ¦{\n  b;\nENDWHILE",
            "PROC q() ¦{\n  b;\nENDPROC",
            "IF a THEN\n  b;\n¦}",
            "FOR i FROM 1 TO 3 DO\n  b;\n¦}",
            "IF a THEN\n  b;\n¦} ELSE {\n  c;\nENDIF",
        ),
        repair=r"replace (?:_THEN|_DO|_END\w+)|delete",
        shown=r"[{}]",
    ),
    Mistake(
        "write THEN in place of `:`, and ENDIF behind the last statement",
        ("IF a = 1¦:\n  b;\nENDIF",),
        repair=r"replace _THEN",
        shown=r":",
    ),
    Mistake(
        "write DO in place of `:`, and the end of the loop behind the last statement",
        ("WHILE a = 1¦:\n  b;\nENDWHILE",),
        repair=r"replace _DO",
        shown=r":",
    ),
    Mistake(
        "delete it, or write what it ends: nothing is open here",
        (
            "PROC q()\n  b;\nENDPROC\n  ¦ENDPROC",
            "a;\n¦ENDIF\nb;",
        ),
        after=r"END(?!MODULE)\w+",
        repair=r"delete",
    ),
    Mistake(
        'write a quote inside a string twice: `"say ""yes"""`',
        ('a := "say "¦yes"";', 'TPWrite "say "¦yes" now";'),
        before=r'"[^"\r\n]*"',
        after=r"[a-z]",
        here=True,
    ),
    Mistake(
        "call a procedure without parentheses: `name a, b;`",
        ("q(1¦,2);", "q(¦);", "q(a¦,b,c);", "MoveL(p1¦,v100,fine,tool0);", 'q("a"¦,b);'),
        before=r"\A\s*[A-Za-z]\w*\s*\((?:[^()]|\([^()]*\))*",
        after=r"[,)\\]",
        here=True,
    ),
    Mistake(
        "write one declaration for each name",
        ("VAR num a¦, b;", "VAR num a := 5¦, b := 6;"),
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:VAR|PERS)\s+\w+\s+\w+(?:\s*:=[^;\[]*)?",
        after=r",\s*[a-z]\w*\s*(?:,|;|:=)",
    ),
    Mistake(
        "write the type before the name: `num a`",
        ("VAR a¦ := 5;", "CONST a¦ := 5;", "PROC q(a¦)\n  b;\nENDPROC", "FUNC q¦(num a)\nENDFUNC"),
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?"
        r"(?:(?:VAR|PERS|CONST|FUNC)\s+\w+|(?:PROC|FUNC)\b[^;]*[(,]\s*\w+)",
        repair=r"insert NAME",
    ),
    Mistake(
        "separate arguments with commas",
        ("MoveL a ¦b c d;",),
        before=r"\A\s*(?!(?:IF|TEST|WHILE|FOR|CASE|RETURN|RAISE|GOTO|CONNECT)\b)\w+\s+\w+",
        after=r"\w+\s+\w",
        repair=r"hole",
    ),
    Mistake(
        "a TEST has `DEFAULT:` for all other values",
        ("TEST a\nCASE 1:\n  b;\n¦ELSE\n  c;\nENDTEST",),
        before=r"\A\s*TEST\b",
        after=r"ELSE\b",
        within="block",
        here=True,
    ),
    Mistake(
        "write decimals with a point: `1.5`",
        ("a := 1¦,5;", "VAR num a := 0¦,25;", "IF a > 1¦,5 b;"),
        before=r"\d",
        after=r",\s*\d",
        here=True,
    ),
    Mistake(
        "begin a comment with `!`",
        (
            "¦// note",
            "a := 1; ¦// note",
            "¦# note",
            "a := 1; ¦# note",
            "¦/* note */",
            "¦-- note",
            "¦' note",
        ),
        after=r"//|#|/\*|--|\(\*|'[^'\r\n]*(?:[\r\n]|\Z)",
    ),
    Mistake(
        'write strings in straight double quotes: `"text"`',
        ("TPWrite ¦“text”;", "TPWrite ¦'text';", "VAR string a := ¦„text“;", "a := ¦«text»;"),
        after="[\u201c\u201d\u201e\u00ab\u2018\u2019'`]",
    ),
    Mistake(
        r'write a backslash in a string twice, or a character as two hex digits: `"C:\\a"`, `\0A`',
        (r'TPWrite ¦"C:\path";', r'a := ¦"line\n";'),
        after=r'"[^"\r\n]*\\[^"\r\n]*"',
        repair=r"string",
    ),
    Mistake(
        'end the string with `"` on the same line; join several with `+`',
        ('TPWrite ¦"abc;', 'a := ¦"abc\n  def";', 'TPWrite ¦"abc'),
        after=r'"[^"\r\n]*(?:[\r\n]|\Z)',
        repair=r"string|hole",
    ),
    Mistake(
        "write ELSEIF in one word; ELSE IF opens a second IF that wants an ENDIF of its own",
        ("IF a THEN\n  b;\n¦ELSE IF c THEN\n  d;\nENDIF",),
        before=r"(?P<at>\bELSE[ \t]+IF\b)",
        repair=r"close _ENDIF.*",
        within="block",
    ),
    Mistake(
        "write it in one word",
        (
            "IF a THEN\n  b;\n¦END IF",
            "FOR i FROM 1 TO 3 DO\n  b;\n¦END FOR",
            "WHILE a DO\n  b;\n¦END WHILE",
            "MODULE m\n  PROC p()\n    a;\n  ¦END PROC\nENDMODULE",
            "MODULE m\n  VAR num a;\n¦END MODULE",
        ),
        repair=r"join .*",
    ),
    Mistake(
        "write ELSEIF",
        ("IF a THEN\n  b;\n¦ELSIF c THEN\n  d;\nENDIF", "IF a THEN\n  b;\n¦ELIF c THEN\nENDIF"),
        repair=r"replace _ELSEIF",
    ),
    Mistake(
        "write THEN behind the condition of an IF whose statements end with ENDIF",
        (
            "IF a = 1¦\n  b;\n  c;\nENDIF",
            "IF a¦\n  b;\nELSE\n  c;\nENDIF",
            "IF a THEN\n  b;\nELSEIF c¦\n  d;\nENDIF",
            "IF a¦ ELSE\n  b;\nENDIF",
        ),
        repair=r"insert _THEN",
    ),
    Mistake(
        "an IF has THEN, a loop DO",
        ("IF a ¦DO\n  b;\nENDIF", "WHILE a ¦THEN\n  b;\nENDWHILE"),
        after=r"(?:THEN|DO)\b",
        repair=r"replace _(?:THEN|DO)",
    ),
    Mistake(
        "write DO behind the head of a loop",
        ("WHILE a < 1¦\n  b;\nENDWHILE", "FOR i FROM 1 TO 10¦\n  a := 1;\nENDFOR"),
        repair=r"insert _DO",
    ),
    Mistake(
        "delete the second `;`",
        ("a := 1;¦;",),
        before=r";",
        after=r";",
        within="line",
    ),
    Mistake(
        "delete the `;`: only statements and declarations end with one",
        (
            "IF a THEN\n  b;\nENDIF¦;",
            "IF a THEN¦;\n  b;\nENDIF",
            "FOR i FROM 1 TO 2 DO\n  b;\nENDFOR¦;",
            "WHILE a DO¦;\n  b;\nENDWHILE",
            "TEST a\nCASE 1:\n  b;\nENDTEST¦;",
            "PROC q()¦;\n  b;\nENDPROC",
            "PROC q()\n  b;\nENDPROC¦;",
        ),
        before=r"\A\s*|\)",
        after=r";",
        repair=r"delete|hole",
    ),
    Mistake(
        "a module has no parentheses unless an attribute stands in them: `MODULE a(SYSMODULE)`",
        ("MODULE a¦()\n  VAR num b;\nENDMODULE",),
        before=r"\A\s*MODULE\s+\w+\s*\(",
        repair=r"delete",
        within="line",
    ),
    Mistake(
        "begin the name of a module with a letter, and use letters, digits and `_` only",
        (
            "MODULE my¦-module\n  VAR num a;\nENDMODULE",
            "MODULE my ¦module\n  VAR num a;\nENDMODULE",
            "MODULE ¦1st\n  VAR num a;\nENDMODULE",
            "MODULE m¦.mod\n  VAR num a;\nENDMODULE",
        ),
        before=r"\A\s*MODULE\b[^\r\n]*(?![ \t]*\r?\n)",
        after=r"[^)]",
        within="line",
        here=True,
    ),
    Mistake(
        "choose another name: this is a word of the language",
        ("VAR num ¦to;", "PROC ¦test()\n  a;\nENDPROC", "¦step := 1;", "VAR robtarget ¦error;"),
        repair=r"reserved",
    ),
    Mistake(
        "end the statement with `;`",
        (
            "a := 1¦\nb := 2;",
            "a := 1¦",
            "IF a b¦\nIF c d;",
            "MoveL p1,v100,fine,tool0¦\nMoveL p2,v100,fine,tool0;",
            "VAR num a¦\nVAR num b;",
            "a := 1¦ ! note\n! more\n\nb := 2;",
            "q¦\nr 1;",
            "RETURN¦",
        ),
        repair=r"insert SEMICOLON",
    ),
    Mistake(
        "write `()` behind the name of a procedure or function",
        ("PROC q¦\n  b;\nENDPROC", "FUNC num q¦\n  RETURN 1;\nENDFUNC"),
        repair=r"insert LPAR RPAR",
    ),
    Mistake(
        "use letters, digits and `_` in a name, a letter first",
        ("VAR num ¦1a;", "VAR num a¦-b;", "VAR num a ¦b;", "VAR num ¦_a;", "PROC ¦2go()\nENDPROC"),
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:VAR|PERS|CONST|PROC|FUNC|TRAP)\b[^;:({\[]*",
        after=r"-|\d\w*[A-Za-z_(]|[A-Za-z_]",
        here=True,
    ),
    Mistake(
        "a TRAP has no parentheses",
        ("TRAP q¦()\n  b;\nENDTRAP",),
        before=r"\A\s*TRAP\s+\w+",
        within="line",
        after=r"\(",
    ),
    Mistake(
        "write MODULE and a name before the first declaration, ENDMODULE behind the last routine",
        ("¦PROC q()\n  b;\nENDPROC\n", "¦VAR num a;\nPROC q()\n  b;\nENDPROC\n"),
        repair=r"wrap _MODULE",
    ),
    Mistake(
        "a file of RAPID begins with MODULE and a name; statements stand between PROC and ENDPROC",
        ("¦MoveL p1,v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\n",),
        repair=r"wrap _MODULE _PROC",
    ),
)
"""In the order in which they are tried."""
