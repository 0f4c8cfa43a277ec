"""Recovery from syntax errors in RAPID: blocks, common mistakes with their cures, wording.

The mistakes are small broken programs, `¦` marks the place; values and arguments first, then
statements, in the order in which they are tried. `reader` gives the reader of damaged texts, which
`assistant.languages.recovery` drives.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.scanner import SILENT, grammar, scanner, table_words
from assistant.languages.recovery.mistakes import Mistake, TerminalGroup, Wording
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

_VALUE_MISTAKES: Final = (
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


MISTAKES: Final = (
    *_VALUE_MISTAKES,
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


_FLAGS: Final = re.IGNORECASE | re.MULTILINE

_BLOCK_WORDS: Final = ("if", "for", "while", "test", "proc", "func", "trap", "record", "module")
"""Each begins a block that ends with the same word behind `end`."""
# RECORD and MODULE enclose no statements, so no word of another language means their end, except
# `end` for MODULE.
ENDS: Final = tuple("end" + word for word in _BLOCK_WORDS if word not in ("record", "module"))

BLOCKS: Final = Blocks(
    ends={"_" + word.upper(): "_END" + word.upper() for word in _BLOCK_WORDS},
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
_OPERATORS: Final = frozenset(
    ("PLUS", "MINUS", "STAR", "SLASH", *_COMPARING, "OR", "XOR", "AND", "DIV", "MOD")
)
_CHANGES: Final = Changes(
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
    """Return a pattern for the rest of a line that begins a block without ending it."""
    return re.compile(rf"{behind}(?!.*\b{ending}\b)", re.IGNORECASE)


_LAYOUT: Final = Layout(
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

_WORDING: Final = Wording(
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
    operators=_OPERATORS,
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
        changes=_CHANGES,
        layout=_LAYOUT,
        assign="_ASSIGN",
        value="EXP",
        data=frozenset(("VAR", "CONST", "PERS", "TASK", "LOCAL")),
        statement_holes=("SMT", "RDN", "DDN"),
        data_holes=("DDN",),
        glue=_OPERATORS
        | {"COMMA", "LPAR", "LSQB", "LBRACE", "_ASSIGN", "BACKSLASH", "DOT", "COLON", "QMARK"},
        runs={"MOVES": ("NAME",), "TARGETS": ("CONST", "LOCAL")},
    )
    return Reader(table_words(), syntax, _WORDING)
