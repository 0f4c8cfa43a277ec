"""Moves of MELFA-BASIC that are skipped, in RAPID, run on both sides."""

from __future__ import annotations

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import translate
from assistant.compiler.cell_defaults import with_neutral_cell
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation

POINTS = """P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
P2=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)
P3=(+400.00,+100.00,+400.00,+180.00,+0.00,+180.00)(7,0)
P4=(+420.00,+50.00,+400.00,+180.00,+0.00,+180.00)(7,0)
"""
HEAD = "Tool P_NTool\nBase P_NBase\nSpd 100\nMvs P1\n"


def crossed(lines: str) -> Translation:
    text = "".join(f"{n} {x}\n" for n, x in enumerate((HEAD + lines + "\nEnd").split("\n"), 1))
    loaded = load_text(SourceText(text + POINTS), language="melfa-basic-5")
    done = translate(with_neutral_cell(loaded), to="rapid", proving=Proving(seconds=2))
    reasons = [f.message for row in done.rows if row.level == "not" for f in row.reasons]
    assert not reasons, reasons
    assert done.motion is not None
    assert done.motion.holds, done.motion.findings
    return done


@pytest.mark.parametrize("move", ["Mvs P2", "Mov P2", "Mvr P1,P4,P3", "Mvs ,-50"])
def test_a_signal_skips_a_move(move: str) -> None:
    done = crossed(f"{move} WthIf M_In(10)=0, Skip\nM_Out(2)=1\nMvs P1")
    (text,) = done.files.values()
    assert b"ISignalDI\\Single,di_10,0,break_move;" in text
    assert b"broken_off" not in text


def test_a_program_asks_whether_it_was_skipped() -> None:
    done = crossed(
        "Mvs P2 WthIf M_In(10)=1, Skip\nIf M_SkipCq=1 Then\nP3=P_Curr\nM_Out(2)=1\nEndIf\n"
        "M_Out(3)=M_SkipCq\nMvs P3"
    )
    (text,) = done.files.values()
    assert b"IF broken_off=1 THEN" in text


def test_several_signals_and_variables_skip_a_move() -> None:
    done = crossed("M1=3\nMvs P2 WthIf (M_In(10)=1) And (M1>2), Skip\nM_Out(2)=1")
    (text,) = done.files.values()
    assert b"ITimer 0.1,break_move;" in text


def test_moves_that_end_by_one_condition_share_its_trap() -> None:
    done = crossed("Mvs P2 WthIf M_In(10)=1,Skip\nMvs P1 WthIf M_In(10)=1,Skip\nM_Out(2)=1")
    (text,) = done.files.values()
    assert text.count(b"TRAP break_move_trap") == 1
