"""Usual mistakes in values, arguments, strings and comments, with their cures."""

from __future__ import annotations

from typing import Final

from assistant.languages.recovery.mistakes import Mistake

VALUE_MISTAKES: Final = (
    Mistake(
        "write unequal as `<>`; `!` begins a comment",
        "IF a ¦!= b THEN\n  c;\nENDIF",
        before=r"(?P<at>!=)",
        within="block",
        repair=r"insert _(THEN|DO)",
    ),
    Mistake(
        "write unequal as `<>` and NOT in a word; `!` begins a comment",
        "IF a ¦!= b c;",
        before=r"(?:(?:IF|WHILE)\b|:=)[^!\"\n]*(?P<at>![=\w(])[^\n]*",
    ),
    Mistake(
        "write it in one piece: `<=`, `>=` or `<>`",
        "IF a =¦> 1 b;",
        before=r"=|<[ \t]+",
        after=r"[<>]",
    ),
    Mistake(
        r"write `\` before the name of an optional argument",
        "MoveL a,b,c,d ¦/WObj:=e;",
        before=r"(?P<at>/)\s*\w+",
        after=r":=",
        repair=r"replace EQUAL",
    ),
    Mistake(
        r"write `\` before the name of an optional argument",
        "MoveL a,b,c,d ¦WObj:=e;",
        before=r"[\w)\]\"]",
        after=r"\w+\s*:=",
        repair=r"insert COMMA",
        here=True,
    ),
    Mistake(
        r"write `:=` before the value of the argument, or `,` behind it if it has none",
        r"MoveL a,b,c,d \WObj¦ e;",
        before=r"\\\s*\w+",
        after=r"\w",
        repair=r"insert COMMA",
    ),
    Mistake("assign with `:=`", "a ¦=: 5;", before=r"\A\s*[\w.]+", after=r"=:|<-", here=True),
    Mistake(
        "write `:=` in one piece",
        "a ¦: = 5;",
        before=r"\A\s*[\w.]+\s*(?P<at>:)",
        after=r"=",
        repair=r"hole",
        within="line",
    ),
    Mistake(
        "write an index in braces: `a{1}`",
        "a¦(1) := 3;",
        before=r"\A\s*\w+\s*(?P<at>\()[^()]*\)",
        after=r":=",
    ),
    Mistake(
        "assign to one variable at a time",
        "a := b ¦:= c;",
        before=r"\A\s*\w+\s*:=[^;]*",
        after=r":=",
    ),
    Mistake(
        "only a variable stands before `:=`",
        "¦1 := a;",
        before=r"\A",
        after=r'(?:\d[\w.]*|"[^"\n]*")\s*:=',
    ),
    Mistake(
        "write the arguments of a function in parentheses: `Offs(p,0,0,100)`",
        "MoveL Offs¦ a,0,0,100,b,c,d;",
        before=r"\b(?:Offs|RelTool)",
        repair=r"insert COMMA",
    ),
    Mistake("assign with `:=`", "a ¦= 1;", before=r"[\w.}]", after=r"=", repair=r"replace _ASSIGN"),
    Mistake("write it out: `a:=a+1`", "a ¦+= 1;", before=r"\w\s*(?P<at>[-+*/])", after=r"="),
    Mistake(
        "write it out: `a:=a+1`", "a ¦++;", before=r"\A\s*\w+\s*(?P<at>[-+])", after=r"[-+]\s*;"
    ),
    Mistake("compare with a single `=`", "IF a ¦== 1 b;", after=r"=="),
    Mistake(
        "compare with `=`; `:=` assigns",
        "IF a ¦:= 1 THEN\n  b;\nENDIF",
        after=r":=",
        repair=r"replace EQUAL",
    ),
    Mistake("join strings with `+`", 'TPWrite "a" ¦& b;', before=r'"', after=r'&(?!&)|"'),
    Mistake(
        "write the remainder as `a MOD b`, a power as `Pow(a,b)`",
        "a := b ¦% 2;",
        before=r":=[^;]*[\w)}]",
        after=r"[%^]",
    ),
    Mistake(
        "write an index and the size of an array in braces: `a{1}`",
        "a := b¦[1];",
        before=r"\A\s*(?:(?:VAR|PERS|CONST)\s+\w+\s+\w+|\w+\s+\w+|\w+\s*:=[^;]*\w)",
        after=r"\[[^\[\],]*(?:,[^\[\],]*)?\]",
    ),
    Mistake(
        "write a list of values in brackets: `[1,2]`",
        "VAR num a{2} :=¦ {1,2};",
        before=r":=\s*|(?:[\[,]|:=)\s*\(\s*[-+\d.]+",
        after=r"\{|,\s*[-+\d.]+\s*,",
    ),
    Mistake(
        "write AND, OR",
        "IF a ¦&& b THEN\n  c;\nENDIF",
        after=r"&&?|\|(?:\||(?=[^;\n]*\b(?:THEN|DO)\b))",
    ),
    Mistake(
        "write the NOT in parentheses: `a AND (NOT b)`",
        "a := b AND ¦NOT c;",
        after=r"NOT\b",
        here=True,
    ),
    Mistake(
        "write the signed value in parentheses: `a*(-1)`",
        "a := b*¦-1;",
        before=r"[-+*/<>=]",
        after=r"[-+]",
        here=True,
    ),
    Mistake(
        "delete the `,`, or write the first argument before it",
        "MoveL¦, a,b,c,d;",
        before=r"\A\s*\w+",
        after=r",",
        repair=r"insert EXP",
    ),
    Mistake(
        "delete the `,`, or write the value that is missing",
        "q 1,¦;",
        before=r",",
        after=r"[;)\]]",
        repair=r"insert (EXP|NAME).*",
    ),
    Mistake(
        "delete one `,`, or write the value that is missing between them",
        "q 1,¦,2;",
        before=r",",
        after=r",",
        repair=r"double",
    ),
    Mistake(
        "delete this `]`, or write the `[` that it closes",
        "CONST pose a := [[1,2,3]¦],[1,0,0,0]];",
        repair=r"delete",
        before=r":=[^;]*\]",
        after=r",",
        shown=r"\]",
    ),
    Mistake(
        "write the value in one piece, in brackets: `[[1,2,3],[1,0,0,0]]`",
        "CONST pose a := [1,2,3]¦,[1,0,0,0];",
        before=r":=\s*\[[^;]*\]",
        after=r",",
        repair=r"hole|delete|insert SEMICOLON",
    ),
    Mistake(
        "write `[` in front of the first value",
        "VAR bool a{3} := ¦FALSE,TRUE,FALSE];",
        repair=r"insert LSQB",
        before=r":=[^;]*",
    ),
    Mistake("swap the name and `:=`", "¦:= a FALSE;", after=r":=", repair=r"swap"),
    Mistake(
        "RAPID has no `?`: write IF … THEN … ELSE … ENDIF",
        "a := b ¦? 1 : 2;",
        before=r":=[^;]*",
        after=r"\?",
    ),
    Mistake(
        "write the number alone: lengths are in mm, angles in degrees, times in seconds",
        "a := 5 ¦mm;",
        before=r"[0-9.]\s*",
        after=r"(?:mm|cm|m|deg|rad|s|ms|sec|kg)\b",
        here=True,
    ),
    Mistake(
        "write the operator that is missing, such as `*`",
        "a := 3¦x;",
        before=r":=[^;\n]*[\d)](?!\s*[\r\n])",
        after=r"[a-z][^;\n]*;",
        repair=r"insert SEMICOLON|delete",
    ),
    Mistake(
        "write a hexadecimal number as `0xFF`",
        "a := ¦$FF;",
        before=r":=[^;]*",
        after=r"\$[0-9a-f]+\s*;",
    ),
    Mistake(
        'write a quote inside a string twice: `"say ""yes"""`',
        'a := "say "¦yes"";',
        before=r'"[^"\r\n]*"(?!\s)',
        after=r"[a-z]",
        here=True,
    ),
    Mistake(
        "call a procedure without parentheses: `name a, b;`",
        "q(1¦,2);",
        before=r"\A\s*[A-Za-z]\w*\s*\((?:[^()]|\([^()]*\))*",
        after=r"[,)\\]",
        here=True,
    ),
    Mistake(
        "separate arguments with commas",
        "MoveL a ¦b c d;",
        before=r"\A\s*(?!(?:IF|TEST|WHILE|FOR|CASE|RETURN|RAISE|GOTO|CONNECT)\b)\w+\s+\w+",
        after=r"\w+\s+\w",
        repair=r"hole",
    ),
    Mistake(
        "write decimals with a point: `1.5`",
        "a := 1¦,5;",
        before=r"(?<![\w.])\d+",
        after=r",\s*\d",
        here=True,
    ),
    Mistake(
        "begin a comment with `!`", "¦// note", after=r"//|#|/\*|--|\(\*|'[^'\r\n]*(?:[\r\n]|\Z)"
    ),
    Mistake(
        'write strings in straight double quotes: `"text"`',
        "TPWrite ¦“text”;",
        after="[\u201c\u201d\u201e\u00ab\u2018\u2019'`]",
    ),
    Mistake(
        r'write a backslash in a string twice, or a character as two hex digits: `"C:\\a"`, `\0A`',
        r'TPWrite ¦"C:\path";',
        after=r'"[^"\r\n]*\\[^"\r\n]*"',
        repair=r"string",
    ),
    Mistake(
        'end the string with `"` on the same line; join several with `+`',
        'TPWrite ¦"abc;',
        after=r'"[^"\r\n]*(?:[\r\n]|\Z)',
        repair=r"string|hole",
    ),
)
"""In the order in which they are tried."""
