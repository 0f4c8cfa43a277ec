"""Bytes of RAPID cross over: each case is run in both languages and compared.

The interpreter of RAPID packs with `struct`, the written program by its own arithmetic.
"""

from __future__ import annotations

import pytest

from assistant.compiler import Translation
from tests.compiler.proven import crossed_module, moves_the_same

HEAD = r"""MODULE Cell
RECORD head
  num kind;
ENDRECORD
RECORD message
  head front;
  rawbytes data;
ENDRECORD
CONST robtarget p10:=[[354,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC go(num x,num y,num z)
  MoveL Offs(p10,x,y,z),v100,fine,tool0;
ENDPROC
PROC show(VAR rawbytes bytes)
  VAR num at;
  VAR num byte;
  VAR num sum;
  FOR at FROM 1 TO RawBytesLen(bytes) STEP 1 DO
    UnpackRawBytes bytes,at,byte\Hex1;
    sum:=sum+byte*(13*at+1);
  ENDFOR
  go RawBytesLen(bytes),sum MOD 997,sum DIV 997;
ENDPROC
PROC fill(VAR message sent,num value)
  PackRawBytes value,sent.data,1\IntX:=DINT;
  sent.front.kind:=7;
ENDPROC
"""
WHOLE = (
    ("200", "USINT"), ("-100", "SINT"), ("40000", "UINT"), ("-2", "INT"), ("4294967040", "UDINT"),
    ("-2147483648", "DINT"), ("16777216", "ULINT"), ("-3", "LINT"),
)  # fmt: skip
REAL = (
    "0", "1", "-1.5", "0.1", "1/3", "123456.789", "-1E-38", "1E-44", "1E+30", "16777217",
    "16777219", "0.99999997",
)  # fmt: skip
CASES = {
    "whole numbers": "".join(
        rf"ClearRawBytes b;PackRawBytes {value},b\Network,1\IntX:={kind};"
        rf"PackRawBytes {value},b,(RawBytesLen(b)+1)\IntX:={kind};show b;"
        rf"UnpackRawBytes b\Network,1,x\IntX:={kind};x:=x/1E7;go x,0,1;"
        for value, kind in WHOLE
    ),
    "real numbers": "".join(
        rf"PackRawBytes {value},b,1\Float4;PackRawBytes {value},b\Network,5\Float4;show b;"
        for value in REAL
    ),
    "real numbers that are read": "".join(
        rf"PackRawBytes {value},b,1\Float4;UnpackRawBytes b,1,x\Float4;"
        "WHILE Abs(x)>1000 DO x:=x/1024;ENDWHILE go x,0,0;"
        for value in REAL
    ),
    "texts": r"""PackRawBytes "Az 09",b,2\ASCII;show b;UnpackRawBytes b,3,t\ASCII:=2;
      IF t="z " go 1,2,3;PackRawBytes 65,b,1\Hex1;UnpackRawBytes b,1,t\ASCII:=1;
      t:=t+ByteToStr(66\Char);IF t="AB" go StrToByte(StrPart(t,2,1)\Char),0,0;""",
    "copies and what is cleared": r"""PackRawBytes 258,b,1\IntX:=UDINT;CopyRawBytes b,1,two{2},3;
      show two{2};CopyRawBytes b,2,two{1},1\NoOfBytes:=2;show two{1};
      ClearRawBytes two{2}\FromIndex:=4;show two{2};PackRawBytes 1,two{2},6\Hex1;show two{2};""",
    "in records": "fill one,-5;fill two_of,6;show one.data;show two_of.data;"
    "go one.front.kind,RawBytesLen(all.data),0;fill all,70000;show all.data;",
}


def crossed(body: str) -> Translation:
    local = "VAR rawbytes b;\nVAR rawbytes two{2};\nVAR message one;\nVAR message two_of;\n"
    head = f"{HEAD}VAR message all;\nPROC main()\n{local}VAR num x;\nVAR string t;\n"
    return crossed_module(head, f"{body}\nENDPROC", seconds=20.0)


@pytest.mark.parametrize("name", CASES)
def test_bytes_are_the_same_in_the_other_language(name: str) -> None:
    moves_the_same(crossed(CASES[name]))


def test_bytes_begin_empty_at_each_call() -> None:
    done = crossed(r"PackRawBytes 1,b,1\Hex1;show b;IF x<1 THEN x:=x+1;main;ENDIF")
    assert not done.ok  # a routine that calls itself has data of its own each time


def test_what_has_no_format_of_these_stays() -> None:
    done = crossed(r"PackRawBytes 1,b,1;PackDNHeader \"10\",\"6,20\",b;go 1,2,3;".replace("\\", ""))
    assert [row.level for row in done.rows if "Pack" in row.text][-2:] == ["not", "not"]
