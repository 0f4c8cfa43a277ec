"""More examples of usual mistakes in RAPID, each with the cure that its row says.

`¦` stands at the place that a finding must show.
"""

from __future__ import annotations

from typing import Final

FURTHER: Final = {
    "write unequal as `<>`; `!` begins a comment": ("WHILE a ¦!= 1 DO\n  b;\nENDWHILE",),
    "write unequal as `<>` and NOT in a word; `!` begins a comment": (
        "IF ¦!a b;",
        "a := ¦!b;",
    ),
    "write it in one piece: `<=`, `>=` or `<>`": (
        "IF a =¦< 1 b;",
        "IF a < ¦> 1 b;",
    ),
    r"write `\` before the name of an optional argument": (
        "a := Round(b ¦Dec:=1);",
        'TPWrite "a"¦Num:=b;',
    ),
    "write `:=` before the value of the argument, or `,` behind it if it has none": (r"q \A¦ b;",),
    "assign with `:=`": (
        "a ¦<- 5;",
        "a ¦== 1;",
        "CONST num a ¦= 1;",
        "p.trans.x ¦= 2;",
        "a{2} ¦= 3;",
    ),
    "only a variable stands before `:=`": ('¦"a" := b;',),
    "write it out: `a:=a+1`": ("a ¦-= b;",),
    "compare with a single `=`": (
        "WHILE a ¦== 1 DO\n  b;\nENDWHILE",
        "a := b ¦== c;",
    ),
    "join strings with `+`": ('a := "b" ¦"c";',),
    "write the remainder as `a MOD b`, a power as `Pow(a,b)`": ("a := b¦^2;",),
    "write an index and the size of an array in braces: `a{1}`": (
        "VAR num a¦[5];",
        "MoveL a¦[1],b,c,d;",
    ),
    "write a list of values in brackets: `[1,2]`": (
        "VAR pos a := (1¦,2,3);",
        "a := [(1¦,2,3),b];",
    ),
    "write AND, OR": ("IF a ¦|| b THEN\n  c;\nENDIF",),
    "write the NOT in parentheses: `a AND (NOT b)`": (
        "IF a OR ¦NOT b THEN\n  c;\nENDIF",
        "a := b = ¦NOT c;",
    ),
    "write the signed value in parentheses: `a*(-1)`": (
        "a := b + ¦-c;",
        "a := b/¦-c;",
    ),
    "delete the `,`, or write the value that is missing": (
        "a := [1,2,¦];",
        "a := b(1,¦);",
    ),
    "delete one `,`, or write the value that is missing between them": (
        "MoveJ a, ¦,z50,b;",
        "a := [0,1, ¦,0];",
    ),
    "delete this `]`, or write the `[` that it closes": (
        "a := [[1,2],[3,4] ¦],[5,6]];",
        "a := [[1,2],3,4¦],[5,6]];",
        "a := [b,[1]¦],c];",
    ),
    "write `[` in front of the first value": ("CONST pose a := ¦[1,2,3],[1,0,0,0]];",),
    "write the number alone: lengths are in mm, angles in degrees, times in seconds": (
        "WaitTime 2 ¦s;",
        "a := b + 3¦deg;",
    ),
    'write a quote inside a string twice: `"say ""yes"""`': ('TPWrite "say "¦yes" now";',),
    "call a procedure without parentheses: `name a, b;`": (
        "q(¦);",
        "q(a¦,b,c);",
        "MoveL(p1¦,v100,fine,tool0);",
        'q("a"¦,b);',
    ),
    "write decimals with a point: `1.5`": (
        "VAR num a := 0¦,25;",
        "IF a > 1¦,5 b;",
    ),
    "begin a comment with `!`": (
        "a := 1; ¦// note",
        "¦# note",
        "a := 1; ¦# note",
        "¦/* note */",
        "¦-- note",
        "¦' note",
    ),
    'write strings in straight double quotes: `"text"`': (
        "TPWrite ¦'text';",
        "VAR string a := ¦„text“;",
        "a := ¦«text»;",
    ),
    r'write a backslash in a string twice, or a character as two hex digits: `"C:\\a"`, `\0A`': (
        r'a := ¦"line\n";',
    ),
    'end the string with `"` on the same line; join several with `+`': (
        'a := ¦"abc\n  def";',
        'TPWrite ¦"abc',
    ),
    "write FROM: `FOR i FROM 1 TO 10 DO`": ("FOR i ¦:= 1 TO 10 DO\n  a;\nENDFOR",),
    "write `FOR i FROM 1 TO 10 DO`": (
        "FOR ¦(i FROM 1 TO 10) DO\n  a;\nENDFOR",
        "FOR ¦VAR num i FROM 1 TO 10 DO\n  a;\nENDFOR",
    ),
    "write an array that a routine is given as `num a{*}`, or `{*,*}`": (
        "PROC q(num a{¦})\n  b;\nENDPROC",
        "PROC q(num a{¦3})\n  b;\nENDPROC",
    ),
    "a PROC gives no value back; what does is a function: `FUNC num q()`": (
        "PROC q() ¦-> num\n  b;\nENDPROC",
    ),
    "write the value behind RETURN: `RETURN a;`": ("FUNC num q()\n  RETURN ¦= 1;\nENDFUNC",),
    r"a parameter has no value of its own: make it optional with `\`, and ask Present(a)": (
        "PROC q(\\num a¦:=5)\n  b;\nENDPROC",
    ),
    "write `(` in front of the parameters": ("FUNC num q¦ num a)\n  RETURN a;\nENDFUNC",),
    "delete one of the two": (
        "MoveL Offs(¦(p10,0,0,50),v100,fine,tool0;",
        "VAR num ¦num a := 0;",
        "PROC ¦PROC q()\n  b;\nENDPROC",
    ),
    "write the type before the name, without `:`": (
        "VAR a ¦: num := 5;",
        "PROC q(a¦: num)\n  b;\nENDPROC",
    ),
    "write `CONNECT interrupt WITH trap;`": ("CONNECT a¦, b;",),
    "RAPID has no braces around statements: THEN … ENDIF, DO … ENDWHILE, PROC … ENDPROC": (
        "IF a ¦{\n  b;\nENDIF",
        "WHILE (a < 1) ¦{\n  b;\nENDWHILE",
        "PROC q() ¦{\n  b;\nENDPROC",
        "IF a THEN\n  b;\n¦}",
        "FOR i FROM 1 TO 3 DO\n  b;\n¦}",
        "IF a THEN\n  b;\n¦} ELSE {\n  c;\nENDIF",
    ),
    "delete it, or write what it ends: nothing is open here": ("a;\n¦ENDIF\nb;",),
    "write one declaration for each name": ("VAR num a := 5¦, b := 6;",),
    "write the type before the name: `num a`": (
        "CONST a¦ := 5;",
        "PROC q(a¦)\n  b;\nENDPROC",
        "FUNC q¦(num a)\nENDFUNC",
    ),
    "write it in one word": (
        "FOR i FROM 1 TO 3 DO\n  b;\n¦END FOR",
        "WHILE a DO\n  b;\n¦END WHILE",
        "MODULE m\n  PROC p()\n    a;\n  ¦END PROC\nENDMODULE",
        "MODULE m\n  VAR num a;\n¦END MODULE",
    ),
    "write ELSEIF": ("IF a THEN\n  b;\n¦ELIF c THEN\nENDIF",),
    "write THEN behind the condition of an IF whose statements end with ENDIF": (
        "IF a¦\n  b;\nELSE\n  c;\nENDIF",
        "IF a THEN\n  b;\nELSEIF c¦\n  d;\nENDIF",
        "IF a¦ ELSE\n  b;\nENDIF",
    ),
    "an IF has THEN, a loop DO": ("WHILE a ¦THEN\n  b;\nENDWHILE",),
    "write DO behind the head of a loop": ("FOR i FROM 1 TO 10¦\n  a := 1;\nENDFOR",),
    "delete the `;`: only statements and declarations end with one": (
        "IF a THEN¦;\n  b;\nENDIF",
        "FOR i FROM 1 TO 2 DO\n  b;\nENDFOR¦;",
        "WHILE a DO¦;\n  b;\nENDWHILE",
        "TEST a\nCASE 1:\n  b;\nENDTEST¦;",
        "PROC q()¦;\n  b;\nENDPROC",
        "PROC q()\n  b;\nENDPROC¦;",
    ),
    "begin the name of a module with a letter, and use letters, digits and `_` only": (
        "MODULE my ¦module\n  VAR num a;\nENDMODULE",
        "MODULE ¦1st\n  VAR num a;\nENDMODULE",
        "MODULE m¦.mod\n  VAR num a;\nENDMODULE",
    ),
    "choose another name: this is a word of the language": (
        "PROC ¦test()\n  a;\nENDPROC",
        "¦step := 1;",
        "VAR robtarget ¦error;",
    ),
    "end the statement with `;`": (
        "a := 1¦",
        "IF a b¦\nIF c d;",
        "MoveL p1,v100,fine,tool0¦\nMoveL p2,v100,fine,tool0;",
        "VAR num a¦\nVAR num b;",
        "a := 1¦ ! note\n! more\n\nb := 2;",
        "q¦\nr 1;",
        "RETURN¦",
    ),
    "write `()` behind the name of a procedure or function": ("FUNC num q¦\n  RETURN 1;\nENDFUNC",),
    "use letters, digits and `_` in a name, a letter first": (
        "VAR num a¦-b;",
        "VAR num a ¦b;",
        "VAR num ¦_a;",
        "PROC ¦2go()\nENDPROC",
    ),
    "write MODULE and a name before the first declaration, ENDMODULE behind the last routine": (
        "¦VAR num a;\nPROC q()\n  b;\nENDPROC\n",
    ),
}
