"""Runs of MELFA-BASIC that take time, as the arm moves."""

from __future__ import annotations

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.loader import load_text
from assistant.virtual.events import Run, Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import start_slot
from assistant.virtual.rapid.interpreter import start_task
from tests.virtual.test_timed import ARM, MELFA, drive, joints_at, times

MELFA_HEAD = "PA=(+400.00,-100.00,+400.00,+180.00,+0.00,+180.00)(7,0)\n"


def melfa(text: str, *, alone: bool = True) -> tuple[Kernel, Run]:
    """A program that begins with the arm at (400, -100, 400)."""
    tree = languages.get("melfa-basic-5").parse(text)
    assert tree.findings == ()
    start = joints_at((400.0, -100.0, 400.0), MELFA)
    kernel = Kernel(motion=Timed(MELFA, drive(MELFA), start))
    start_slot(kernel, (tree,), robot=MELFA)
    if not alone:
        kernel.at(1e6, lambda: None)
    return kernel, kernel.run()


POINTS = (
    "P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)\n"
    "P2=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)\n"
)


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize(("corner", "first"), [("Cnt 0", 1.01), ("Cnt 1,10,10", 0.905)])
def test_what_stands_behind_a_motion_with_and_without_cnt(
    corner: str, first: float, alone: bool
) -> None:
    text = (
        f"1 Spd 100\n2 {corner}\n3 Mvs P1\n4 M_Out(5)=1\n5 Cnt 0\n6 Mvs P2\n7 M_Out(5)=0\n8 End\n"
    )
    kernel, run = melfa(text + POINTS, alone=alone)
    assert (run.ended, run.message) == ("end", "")
    assert times(run)[0] == first
    assert times(run)[1] == round(kernel.now, 4)


def test_where_a_melfa_arm_is_on_its_way() -> None:
    text = (
        "1 Spd 100\n2 Cnt 1,10,10\n3 Mvs P1\n4 PN=P_Curr\n5 M1=M_RDst\n6 M2=M_Ratio\n"
        "7 If Abs(PN.Y+10)<0.01 Then M_Out(1)=1\n8 If Abs(M1-10)<0.01 Then M_Out(2)=1\n"
        "9 If Abs(M2-90)<0.01 Then M_Out(3)=1\n10 Dly 3\n11 PN=P_Curr\n"
        "12 If Abs(PN.Y)<0.01 Then M_Out(4)=1\n13 If M_Ratio=100 Then M_Out(5)=1\n14 End\n"
    )
    _, run = melfa(text + POINTS)
    assert (run.ended, run.message) == ("end", "")
    set_ = [row.what.signal for row in run.log if isinstance(row.what, Switched)]
    assert set_ == ["1", "2", "3", "4", "5"]


def test_what_is_appended_to_a_melfa_motion_happens_on_its_way() -> None:
    """Lines of 100 mm at 100 mm/s take 1.01 s, to the middle 0.505 s; Skip looks every few ms."""
    text = (
        "1 Spd 100\n2 Mvs P1 Wth M_Out(1)=1\n3 Mvs P2 WthIf M_RDst<20,M_Out(2)=1\n"
        "4 Mvs P1 WthIf M_Ratio>50,Skip\n5 M_Out(3)=M_SkipCq\n6 PN=P_Curr\n"
        "7 If Abs(PN.Z-450)<1 Then M_Out(4)=1\n8 End\n"
    )
    _, run = melfa(text + POINTS)
    assert (run.ended, run.message) == ("end", "")
    assert times(run) == pytest.approx([0.0, 1.815, 2.525, 2.525], abs=0.01)


def test_a_melfa_arm_tells_what_it_cannot_reach_by_its_number() -> None:
    _, run = melfa("1 Mov P9\n2 End\nP9=(+4000.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)\n")
    assert run.ended == "error"
    assert "2602" in run.message


def test_an_interrupt_by_the_position_comes_as_soon_in_rapid() -> None:
    """RAPID asks for the condition every 0.1 s, and stops the arm as soon as it holds."""
    text = (
        "1 Tool P_NTool\n2 Base P_NBase\n3 Spd 100\n4 Mvs P1\n5 Def Act 1,P_Curr.Z>430 GoTo *S\n"
        "6 Act 1=1\n7 Mvs P2\n8 M_Out(2)=1\n9 End\n10 *S\n11 M_Out(1)=1\n12 End\n" + POINTS
    )
    _, run = melfa(text)
    made = translate(load_text(SourceText(text), language="melfa-basic-5"), to="rapid")
    assert made.ok
    tree = languages.get("rapid").parse(next(iter(made.files.values())).decode())
    kernel = Kernel(motion=Timed(ARM, drive(ARM), joints_at((400.0, -100.0, 400.0), ARM)))
    start_task(kernel, (tree,), robot=ARM)
    done = kernel.run()
    (first,), (second,) = times(run), times(done)
    assert 0.0 <= second - first <= 0.1
    assert [row.what.signal for row in done.log if isinstance(row.what, Switched)] == ["do_1"]
