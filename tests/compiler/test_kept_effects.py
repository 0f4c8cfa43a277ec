"""Vendor text in a program carries what it does, wherever the program comes from."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler import load
from assistant.compiler.loader import load_text
from assistant.program.program import Program
from assistant.program.pseudo import print_program
from assistant.program.rewriting import records
from assistant.program.vendor_statements import VendorText, effect_of

ROOT = Path(__file__).parents[2]
RAPID = r"""MODULE m
  VAR intnum alarm;
  CONST robtarget p1:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    FOR p1 FROM 1 TO 3 DO
      SetAO ao1,p1;
      n:=best(p1\first);
    ENDFOR
    MoveL p1,v100\T:=7,fine,tool0;
    fetch\fast;
    CONNECT alarm WITH onalarm;
    ISignalDI di1,1,alarm;
  ERROR
    RETRY;
  ENDPROC
  PROC fetch(\switch fast)
    Stop;
  ENDPROC
  TRAP onalarm
    MoveJ p1,v100,fine,tool0;
  ENDTRAP
ENDMODULE
"""
MELFA = """10 Def Act 1,M_In(8)=1 GoSub *Alarm
20 Mvs P1 Wth M_Out(8)=1
30 M2=M_NvNum(1)+1
32 M3=M_NvNum(2)+1
34 M4=M_NvNum(3)+1
40 End
50 *Alarm
60 Return 0
P1=(400,0,400,180,0,180)(7,0)
"""


def programs() -> dict[str, Program]:
    samples = [f for f in sorted((ROOT / "samples").rglob("*")) if f.suffix in (".mod", ".prg")]
    found = {file.name: load(file).program for file in samples}
    for language, text in (("rapid", RAPID), ("melfa-basic-5", MELFA)):
        found[language] = load_text(SourceText(text), language=language).program
    return found


PROGRAMS = programs()


def kept(program: Program) -> list[VendorText]:
    parts = records((program.procedures, program.declarations, program.variables))
    return [part for part in parts if isinstance(part, VendorText)]


@pytest.mark.parametrize("name", PROGRAMS)
def test_lifted_text_carries_what_its_language_says_of_it(name: str) -> None:
    for part in kept(PROGRAMS[name]):
        assert part.effect == languages.effect(part), part.text


@pytest.mark.parametrize("name", PROGRAMS)
def test_it_comes_back_from_pseudo_text(name: str) -> None:
    printed = print_program(PROGRAMS[name]).text
    back = load_text(SourceText(printed)).program
    expected = {(type(k), k.language, k.text): k.effect for k in kept(PROGRAMS[name])}
    assert {(type(k), k.language, k.text): k.effect for k in kept(back)} == expected


def test_every_kind_of_kept_text_is_there() -> None:
    for name in ("rapid", "melfa-basic-5"):
        assert len(kept(PROGRAMS[name])) >= 3
    assert {type(k) for k in kept(PROGRAMS["rapid"])} == set(get_args(VendorText))


def test_text_of_no_known_language_may_do_anything() -> None:
    text = "program p\n\nprocedure main\n  opaque another | PTP P1\nend\n"
    (part,) = kept(load_text(SourceText(text)).program)
    assert part.effect is None and effect_of(part).moves and effect_of(part).writes == {"ptp", "p1"}
