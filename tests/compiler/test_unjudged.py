"""Inputs with which nobody knows what a program does are told of; other runs keep their proof."""

from __future__ import annotations

from pathlib import Path

from assistant import robots
from assistant.compiler import translate
from assistant.compiler.motion_proof import Proving
from assistant.languages import get
from assistant.virtual import melfa

WIDE = """1 M1%=M_In16(32)
2 If M1%>3 Then M_Out(1)=1
3 If M_In16(32)=40000 Then Dly 1
4 End
"""


def test_a_number_that_a_variable_may_not_hold_is_told_of(tmp_path: Path) -> None:
    (tmp_path / "WIDE.prg").write_text(WIDE, encoding="ascii", newline="\n")
    motion = translate(tmp_path / "WIDE.prg", to="rapid", proving=Proving(seconds=2.0)).motion
    assert motion is not None
    assert motion.holds, motion.findings
    (told,) = (f.message for f in motion.findings if f.code == "CO116")
    assert "does not fit into M1" in told


def test_joints_of_axes_that_an_arm_has_not_are_nothing_to_it() -> None:
    text = "1 Mov J1\n2 End\nJ1=(0,0,90,0,90,0,{},0)\n"
    language, robot = get("melfa-basic-5"), robots.get("rv-4frl")
    assert melfa.run(language.parse(text.format(0)), robot=robot).ended == "end"
    assert melfa.run(language.parse(text.format(5)), robot=robot).ended == "error"
