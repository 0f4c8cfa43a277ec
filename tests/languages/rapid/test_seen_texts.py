"""Texts that are received byte by byte are read as other languages read a line."""

from __future__ import annotations

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import Translation, translate
from assistant.compiler.loader import load_text

READ = r"""t:="";
SocketReceive s\Str:=c\ReadNoOfBytes:=1\Time:=WAIT_MAX;
WHILE c<>"\0D" AND c<>"," DO
IF c<>"\0A" THEN
t:=t+c;
ENDIF
SocketReceive s\Str:=c\ReadNoOfBytes:=1\Time:=WAIT_MAX;
ENDWHILE"""
NUMBER = """ok:=StrToVal(t,n);
IF NOT ok THEN
EXIT;
ENDIF"""
MODULE = """MODULE talk
VAR socketdev s;
VAR string t;
VAR string c;
VAR bool ok;
VAR num n;
PROC main()
SocketCreate s;
SocketConnect s,"192.168.0.5",10010\\Time:=WAIT_MAX;
{body}
IF n>2 OR t="x" SetDO do1,1;
SocketClose s;
ENDPROC
ENDMODULE
"""


def told(body: str) -> Translation:
    module = SourceText(MODULE.format(body=body))
    return translate(load_text(module, language="rapid"), to="melfa-basic-5")


def lines(body: str) -> list[str]:
    program = told(body).compiled.program
    return [str(node) for node in program.statements()]


@pytest.mark.parametrize(
    ("body", "function"), [(READ, "received"), (f"{READ}\n{NUMBER}", "received_number")]
)
def test_a_text_or_a_number_is_one_that_is_received(body: str, function: str):
    said = lines(body)
    assert sum(f"function='{function}'" in one for one in said) == 1
    assert not any(one.startswith("While") and "'t'" in one for one in said)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (r'c<>"\0D"', 'c<>";"'),
        ("WAIT_MAX", "5"),
        ("ReadNoOfBytes:=1", "ReadNoOfBytes:=2"),
        ("t:=t+c", "t:=c+t"),
        (r'c<>"\0A"', r'c<>"\20"'),
    ],
)
def test_what_reads_otherwise_stays(before: str, after: str):
    said = lines(READ.replace(before, after))
    assert sum("function='received'" in one for one in said) > 1
