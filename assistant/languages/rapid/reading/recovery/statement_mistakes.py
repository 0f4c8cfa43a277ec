"""Usual mistakes in RAPID, as small broken programs with their cures."""

from __future__ import annotations

from typing import Final

from assistant.languages.rapid.reading.recovery.value_mistakes import VALUE_MISTAKES
from assistant.languages.recovery.mistakes import Mistake

MISTAKES: Final = (
    *VALUE_MISTAKES,
    Mistake("write MODULE … ENDMODULE", "¦", before=r"\A", after=r"\s*\Z", repair=r"outside"),
    Mistake(
        "write FROM: `FOR i FROM 1 TO 10 DO`",
        "FOR i ¦= 1 TO 10 DO\n  a;\nENDFOR",
        before=r"\A\s*FOR\s+\w+",
        after=r":?=",
    ),
    Mistake(
        "write `FOR i FROM 1 TO 10 DO`",
        "FOR i ¦IN 1 TO 10 DO\n  a;\nENDFOR",
        before=r"\A\s*FOR\b(?:\s+\w+)?",
        repair=r"hole|delete",
    ),
    Mistake(
        "an IF has one ELSE, as its last part",
        "IF a THEN\n  b;\nELSE\n  c;\n¦ELSE\n  d;\nENDIF",
        before=r"\bELSE\b",
        after=r"ELSE\b",
        repair=r"delete",
        within="block",
    ),
    Mistake(
        "DEFAULT stands behind the last CASE",
        "TEST a\nDEFAULT:\n  c;\n¦CASE 3:\n  d;\nENDTEST",
        before=r"\bDEFAULT\s*:",
        after=r"CASE\b",
        within="block",
    ),
    Mistake(
        "write an array that a routine is given as `num a{*}`, or `{*,*}`",
        "PROC q(num a¦[])\n  b;\nENDPROC",
        before=r"\A\s*(?:LOCAL\s+)?(?:PROC|FUNC)\b[^;]*\w\s*\{?",
        repair=r"hole|delete",
        after=r"\[|\}|\d",
    ),
    Mistake(
        "a PROC gives no value back; what does is a function: `FUNC num q()`",
        "PROC q() ¦: num\n  b;\nENDPROC",
        before=r"\A\s*(?:LOCAL\s+)?PROC\s+\w+\s*\([^)]*\)",
        after=r":|->",
        within="line",
    ),
    Mistake(
        "write the value behind RETURN: `RETURN a;`",
        "FUNC num q()\n  RETURN ¦:= 1;\nENDFUNC",
        before=r"RETURN",
        after=r":?=",
        here=True,
    ),
    Mistake(
        "RAPID has no way out of a loop but GOTO and a label behind it",
        "WHILE a DO\n  EXIT ¦FOR;\nENDWHILE",
        before=r"\bEXIT",
        after=r"(?:FOR|WHILE|DO|IF|TEST)\b",
    ),
    Mistake(
        "write MoveL, MoveJ, MoveC in one word",
        "¦Move L a,b,c,d;",
        before=r"\A\s*(?P<at>Move)\s+[JLC]",
        repair=r"insert COMMA",
    ),
    Mistake(
        "statements stand between PROC and ENDPROC",
        "PROC q()\n  b;\nENDPROC\n¦d;\nVAR num c;",
        before=r"\A",
        shown=r"\w+\s*;",
        repair=r"delete",
    ),
    Mistake(
        r"a parameter has no value of its own: make it optional with `\`, and ask Present(a)",
        "PROC q(num a ¦= 5)\n  b;\nENDPROC",
        before=r"\A\s*(?:LOCAL\s+)?(?:PROC|FUNC)\b[^;]*\w",
        after=r":?=",
    ),
    Mistake(
        "write `(` in front of the parameters",
        "PROC q¦ num a)\n  b;\nENDPROC",
        repair=r"insert LPAR",
        before=r"\A\s*(?:LOCAL\s+)?(?:PROC|FUNC)\b[^;(]*",
    ),
    Mistake("delete one of the two", "CONST ¦CONST num a := 3;", repair=r"double"),
    Mistake(
        "write the type before the name, without `:`",
        "VAR a¦: num;",
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:(?:VAR|PERS|CONST)\s+|(?:PROC|FUNC)\b[^;]*[(,]\s*)\w+",
        after=r":(?!=)",
    ),
    Mistake(
        "write `CONNECT interrupt WITH trap;`", "CONNECT a ¦TO b;", before=r"\A\s*CONNECT\s+\w+"
    ),
    Mistake(
        "RAPID has no braces around statements: THEN … ENDIF, DO … ENDWHILE, PROC … ENDPROC",
        "IF a = 1 ¦{\n  b;\nENDIF",
        repair=r"replace (?:_THEN|_DO|_END\w+)|delete",
        shown=r"[{}]\s*(?:ELSE\b|[\r\n]|\Z)",
    ),
    Mistake(
        "write THEN in place of `:`, and ENDIF behind the last statement",
        "IF a = 1¦:\n  b;\nENDIF",
        repair=r"replace _THEN",
        shown=r":",
    ),
    Mistake(
        "write DO in place of `:`, and the end of the loop behind the last statement",
        "WHILE a = 1¦:\n  b;\nENDWHILE",
        repair=r"replace _DO",
        shown=r":",
    ),
    Mistake(
        "delete it, or write what it ends: nothing is open here",
        "PROC q()\n  b;\nENDPROC\n  ¦ENDPROC",
        after=r"END(?!MODULE)\w+",
        repair=r"delete",
    ),
    Mistake(
        "write one declaration for each name",
        "VAR num a¦, b;",
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:VAR|PERS)\s+\w+\s+\w+(?:\s*:=[^;\[]*)?",
        after=r",\s*[a-z]\w*\s*(?:,|;|:=)",
    ),
    Mistake(
        "write the type before the name: `num a`",
        "VAR a¦ := 5;",
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?"
        r"(?:(?:VAR|PERS|CONST|FUNC)\s+\w+|(?:PROC|FUNC)\b[^;]*[(,]\s*\w+)",
        repair=r"insert NAME",
    ),
    Mistake(
        "a TEST has `DEFAULT:` for all other values",
        "TEST a\nCASE 1:\n  b;\n¦ELSE\n  c;\nENDTEST",
        before=r"\A\s*TEST\b",
        after=r"ELSE\b",
        within="block",
        here=True,
    ),
    Mistake(
        "write ELSEIF in one word; ELSE IF opens a second IF that wants an ENDIF of its own",
        "IF a THEN\n  b;\n¦ELSE IF c THEN\n  d;\nENDIF",
        before=r"(?P<at>\bELSE[ \t]+IF\b)",
        repair=r"close _ENDIF.*",
        within="block",
    ),
    Mistake("write it in one word", "IF a THEN\n  b;\n¦END IF", repair=r"join .*"),
    Mistake(
        "write ELSEIF", "IF a THEN\n  b;\n¦ELSIF c THEN\n  d;\nENDIF", repair=r"replace _ELSEIF"
    ),
    Mistake(
        "write THEN behind the condition of an IF whose statements end with ENDIF",
        "IF a = 1¦\n  b;\n  c;\nENDIF",
        repair=r"insert _THEN",
    ),
    Mistake(
        "an IF has THEN, a loop DO",
        "IF a ¦DO\n  b;\nENDIF",
        after=r"(?:THEN|DO)\b",
        repair=r"replace _(?:THEN|DO)",
    ),
    Mistake(
        "write DO behind the head of a loop", "WHILE a < 1¦\n  b;\nENDWHILE", repair=r"insert _DO"
    ),
    Mistake("delete the second `;`", "a := 1;¦;", before=r";", after=r";", within="line"),
    Mistake(
        "delete the `;`: only statements and declarations end with one",
        "IF a THEN\n  b;\nENDIF¦;",
        before=r"\A\s*|\)",
        after=r";",
        repair=r"delete|hole",
    ),
    Mistake(
        "a module has no parentheses unless an attribute stands in them: `MODULE a(SYSMODULE)`",
        "MODULE a¦()\n  VAR num b;\nENDMODULE",
        before=r"\A\s*MODULE\s+\w+\s*\(",
        repair=r"delete",
        within="line",
    ),
    Mistake(
        "begin the name of a module with a letter, and use letters, digits and `_` only",
        "MODULE my¦-module\n  VAR num a;\nENDMODULE",
        before=r"\A\s*MODULE\b[^(\r\n]*(?![ \t]*\r?\n)",
        after=r"[^)]",
        within="line",
        here=True,
    ),
    Mistake(
        "choose another name: this is a word of the language", "VAR num ¦to;", repair=r"reserved"
    ),
    Mistake("end the statement with `;`", "a := 1¦\nb := 2;", repair=r"insert SEMICOLON"),
    Mistake(
        "write `()` behind the name of a procedure or function",
        "PROC q¦\n  b;\nENDPROC",
        repair=r"insert LPAR RPAR",
    ),
    Mistake(
        "use letters, digits and `_` in a name, a letter first",
        "VAR num ¦1a;",
        before=r"\A\s*(?:(?:LOCAL|TASK)\s+)?(?:VAR|PERS|CONST|PROC|FUNC|TRAP)\b[^;:({\[]*",
        after=r"-|\d\w*[A-Za-z_(]|[A-Za-z_]",
        here=True,
    ),
    Mistake(
        "a TRAP has no parentheses",
        "TRAP q¦()\n  b;\nENDTRAP",
        before=r"\A\s*TRAP\s+\w+",
        within="line",
        after=r"\(",
    ),
    Mistake(
        "write MODULE and a name before the first declaration, ENDMODULE behind the last routine",
        "¦PROC q()\n  b;\nENDPROC\n",
        repair=r"wrap _MODULE",
    ),
    Mistake(
        "a file of RAPID begins with MODULE and a name; statements stand between PROC and ENDPROC",
        "¦MoveL p1,v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\n",
        repair=r"wrap _MODULE _PROC",
    ),
)
"""In the order in which they are tried."""
