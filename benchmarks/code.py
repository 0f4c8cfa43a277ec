"""Ordinary programs of any length: statements of every kind, no two lines alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

LINES: Final = 20_000

RAPID: Final = """\
    PROC part%d()
        VAR num count%d:=%d;
        WaitDI di%d,1\\MaxTime:=%d;
        IF count%d>%d AND (NOT flag%d) THEN
            count%d:=(count%d+%d)*2;
        ELSEIF Abs(count%d-%d)<0.5 THEN
            SetDO do%d,high; ! note %d
        ELSE
            MoveJ Offs(p%d,0,0,%d.5),v%d,z10,tool%d\\WObj:=wobj%d;
            MoveL p%d,v%d,fine,tool%d;
        ENDIF
        FOR i%d FROM 1 TO %d DO
            part%d;
            TPWrite "row %d of "+NumToStr(count%d,0);
        ENDFOR
        TEST count%d
        CASE %d:
            RETURN;
        DEFAULT:
            WaitTime 0.%d;
        ENDTEST
    ENDPROC
"""
MELFA_BASIC: Final = """\
*PART%d
M%d=%d
Wait M_In(%d)=1
If M%d>%d And Not M_In(%d)=1 Then
    M%d=(M%d+%d)*2
ElseIf Abs(M%d-%d)<0.5 Then
    M_Out(%d)=1 Dly 0.%d ' note %d
Else
    Mov P%d,-%d.5
    Mvs P%d Wth M_Out(%d)=1
EndIf
For M%d=1 To %d
    GoSub *PART%d
    Print #1,"row %d of ",M%d
Next M%d
Select M%d
Case %d
    Mvs P%d+P%d
Default
    Dly 0.%d
End Select
P%d=P%d*(0,0,%d,0,0,0)
Return
"""


def code(language: str, n: int) -> dict[str, bytes]:
    """File name → bytes of about n lines, in as many files as the language wants."""
    if language == "rapid":
        lines = ["MODULE code", *_filled(RAPID, n), "ENDMODULE", ""]
        return {"code.mod": "\r\n".join(lines).encode("ascii")}
    body = list(_filled(MELFA_BASIC, n))
    numbered = [f"{number} {line}" for number, line in enumerate(body, start=1)]
    return {"code.prg": "\r\n".join([*numbered, ""]).encode("ascii")}


def _filled(pattern: str, n: int) -> Iterator[str]:
    """Copies of a pattern of lines, the numbers in each its own: no line is known already."""
    count = pattern.count("\n")
    for copy in range(1, n // count + 1):
        yield from (pattern.rstrip() % ((copy,) * pattern.count("%d"))).split("\n")
