"""Interrupts, skips and stops while the arm is on its way, with motions that take time."""

from __future__ import annotations

import pytest

from assistant import languages, robots
from assistant.virtual.events import Moved, Run, Switched
from assistant.virtual.kernel import Kernel
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.melfa import Controller, Entry
from assistant.virtual.melfa.world import STEP_TIME

ROBOT = robots.get("rv-4frl")
POSITIONS = """
P1=(400,0,500,180,0,180)(7,0)
P2=(400,200,500,180,0,180)(7,0)
P3=(400,100,600,180,0,180)(7,0)
"""


def run(**programs: str) -> Run:
    """Program A in slot 1; input 1 is on from 1 s on."""
    language = languages.get("melfa-basic-5")
    files = {
        name: language.parse(text.strip() + "\nEnd" + POSITIONS) for name, text in programs.items()
    }
    assert not [finding for file in files.values() for finding in file.findings]
    kernel = Kernel(statement_time=STEP_TIME, most_steps=5000, motion=Timed(ROBOT))
    kernel.at(1.0, lambda: kernel.board.inputs.set("1", 1.0))
    Controller(kernel, files, {1: Entry("A", "CYC")}, robot=ROBOT).start()
    return kernel.run()


def told(done: Run) -> list[str]:
    """Outputs that come on and places that are moved to, each with its tenth of a second."""
    assert done.ended == "end", done.message
    found = []
    for row in done.log:
        match row.what:
            case Switched(signal, 1.0):
                found.append(f"{signal} at {row.time:.1f}")
            case Moved(flange=flange):
                assert flange is not None
                _, y, z = flange.position
                found.append(f"{y:.0f},{z:.0f} at {row.time:.1f}")
    return found


WITH = """
Mov P1
Spd 100
Def Act 1,M_In(1)=1 GoSub *INTR{stop}
Act 1=1
Mvs P2
M_Out(1)=1
End
*INTR
Act 1=0
M_Out(2)=1
{more}
Return {back}
"""


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        # The arm stands for a second, and goes on from there.
        ({"more": "Dly 1"}, ["0,500 at 0.0", "200,500 at 0.1", "2 at 1.0", "1 at 3.1"]),
        ({"stop": ",S"}, ["0,500 at 0.0", "200,500 at 0.1", "2 at 1.0", "1 at 2.1"]),
        # The interrupt waits for the end of the motion.
        ({"stop": ",L"}, ["0,500 at 0.0", "200,500 at 0.1", "2 at 2.1", "1 at 2.1"]),
        # The motion is not made to its end.
        ({"back": "1"}, ["0,500 at 0.0", "200,500 at 0.1", "2 at 1.0", "1 at 1.0"]),
        # The arm is elsewhere when the line is gone on with.
        (
            {"more": "Mvs P3"},
            [
                *("0,500 at 0.0", "200,500 at 0.1", "2 at 1.0"),
                *("100,600 at 1.0", "200,500 at 2.0", "1 at 3.4"),
            ],
        ),
        # It can be asked where it stands.
        (
            {"more": "PX=P_Curr\nM_Out(3)=(PX.Y>80)And(PX.Y<100)"},
            ["0,500 at 0.0", "200,500 at 0.1", "2 at 1.0", "3 at 1.0", "1 at 2.1"],
        ),
    ],
)
def test_an_interrupt_on_the_way(parts: dict[str, str], expected: list[str]) -> None:
    text = WITH.format(**{"stop": "", "more": "M9=0", "back": "0", **parts})
    assert told(run(A=text)) == expected


def test_a_motion_is_skipped_on_its_way() -> None:
    done = run(
        A="""
Mov P1
Spd 100
Mvs P2 WthIf M_In(1)=1,Skip
M_Out(1)=M_SkipCq
Mvs P3 WthIf M_Ratio>50,Skip
M_Out(2)=M_SkipCq
PX=P_Curr
M_Out(3)=(PX.Z>548)And(PX.Z<552)
"""
    )
    assert told(done) == [
        *("0,500 at 0.0", "200,500 at 0.1", "1 at 1.0"),
        *("100,600 at 1.0", "2 at 1.5", "3 at 1.5"),
    ]


def test_an_output_comes_when_its_condition_does() -> None:
    done = run(
        A="""
Mov P1
Spd 100
Mvs P2 WthIf M_In(1)=1,M_Out(1)=1
M_Out(2)=1
Mvs P3 WthIf M_In(2)=1,M_Out(3)=1
Mvs P1 WthIf M_RSpd>90,M_Out(4)=1
M_Out(5)=M_SkipCq
"""
    )
    assert told(done) == [
        *("0,500 at 0.0", "200,500 at 0.1", "1 at 1.0", "2 at 2.1"),
        *("100,600 at 2.1", "0,500 at 3.5", "4 at 3.5"),
    ]


SECOND = """
GetM 1
Spd 100
Mvs P2
M_Out(2)=1
"""


def test_a_stopped_motion_goes_on() -> None:
    first = """
Mov P1
RelM
XRun 2,"B",1
Dly 1
XStp 2
Wait M_Wai(2)=1
Dly 1
XRun 2
Wait M_Psa(2)=1
"""
    assert told(run(A=first, B=SECOND)) == ["0,500 at 0.0", "200,500 at 0.1", "2 at 3.1"]


STOPPED = """
Mov P1
RelM
XRun 2,"B",1
Dly 1
XStp 2
Wait M_Wai(2)=1
{}
GetM 1
PX=P_Curr
M_Out(1)=(PX.Y>80)And(PX.Y<100)
Mvs P1
{}
"""


def test_another_slot_moves_on_from_where_a_motion_was_stopped() -> None:
    done = run(A=STOPPED.format("XRst 2", ""), B=SECOND)
    assert told(done) == ["0,500 at 0.0", "200,500 at 0.1", "1 at 1.1", "0,500 at 1.1"]


def test_a_stopped_motion_that_another_slot_ended_does_not_go_on() -> None:
    done = run(A=STOPPED.format("", "RelM\nXRun 2\nWait M_Psa(2)=1"), B=SECOND)
    assert done.ended == "unknown" and "another slot has ended" in done.message
