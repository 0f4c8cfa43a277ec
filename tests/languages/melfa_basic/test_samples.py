"""The samples in MELFA-BASIC IV: what they do, and that every dialect says it."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.compiler.loader import load
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from tests.tables import every_row

SAMPLES = Path(__file__).parents[3] / "samples" / "melfa"
NAMES = ("MULTITASK", "DATALINK", "CONTROLLINK")
melfa = languages.get("melfa-basic-4")


def steps(name: str) -> dict[int, str]:
    """The statements of a sample by their step numbers."""
    tree = melfa.parse(melfa.read(SAMPLES / f"{name}.prg"))
    return {
        item.number: printer.statement(item.statement, upper=True)
        for item in tree.items
        if isinstance(item, s.Line) and item.statement is not None and item.number is not None
    }


@every_row("name", [*NAMES, *(f"datalink/{name}" for name in (*NAMES, "MEASURE"))])
def test_a_sample_is_sound_and_laid_out(name: str) -> None:
    source = melfa.read(SAMPLES / f"{name}.prg")
    tree = melfa.parse(source)
    assert not tree.findings
    assert {f.severity for f in melfa.check([tree])} <= {Severity.INFO}
    assert melfa.format(tree) == source.text
    assert source.encoding == "ascii"
    assert source.text.count("\r\n") == source.text.count("\n")


def test_the_first_slot_starts_and_stops_the_others() -> None:
    said = steps("MULTITASK")
    order = list(said.values())
    assert [t for t in order if t.startswith(("XLOAD", "XRUN", "XSTP"))] == [
        'XLOAD 2,"DATALINK"', 'XRUN 2,"DATALINK"',
        'XLOAD 3,"CONTROLLINK"', 'XRUN 3,"CONTROLLINK"',
        "XSTP 2", "XSTP 3",
    ]  # fmt: skip
    assert order[0] == "RELM"  # the arm is free for slot 3, and taken back at the end
    assert order[-2:] == ["GETM 1", "HLT"]
    both = [order.index("WAIT M_01=1"), order.index("WAIT M_02=1")]
    assert order.index('XRUN 3,"CONTROLLINK"') < min(both)
    assert max(both) < order.index("XSTP 2")


def test_the_data_link_sends_until_it_is_told_to_stop() -> None:
    said = steps("DATALINK")
    assert said[30] == 'OPEN "COM2:" AS #2'
    assert (said[35], said[40]) == ("INPUT #2,DATA", 'IF DATA="0" THEN 160')
    assert said[100].startswith("PRINT #2,M_TIMER(1)")
    assert [q for q in ("P_CURR", "J_FBC", "J_CURR", "M_RSPD(3)") if q in said[100]] == [
        "P_CURR", "J_FBC", "J_CURR", "M_RSPD(3)",
    ]  # fmt: skip
    assert (said[130], said[160]) == ("GOTO 100", "M_02=1")


def test_the_control_link_moves_to_what_it_receives() -> None:
    said = steps("CONTROLLINK")
    assert said[40] == "CNT 1,300"
    assert list(said.values())[-5:] == [
        'OPEN "COM1:" AS #1', "DEF JNT JNTPOS", "INPUT #1,JNTPOS", "MOV JNTPOS", "GOTO 80",
    ]  # fmt: skip
    assert list(said).index(80) < list(said).index(90) < list(said).index(100)


@pytest.mark.parametrize("to", ["melfa-basic-5", "melfa-basic-6"])
@pytest.mark.parametrize("name", NAMES)
def test_a_sample_in_the_later_dialects(name: str, to: str, tmp_path: Path) -> None:
    compiled = assistant.compile(SAMPLES / f"{name}.prg", language=to)
    assert compiled.ok
    assert {f.severity for f in compiled.findings} <= {Severity.INFO}
    assert list(compiled.files) == [f"{name}.prg"]
    (tmp_path / f"{name}.prg").write_bytes(compiled.files[f"{name}.prg"])
    later = load(tmp_path / f"{name}.prg")
    assert later.language == to
    back = assistant.compile(later.program, language="melfa-basic-4")
    assert back.ok
    (text,) = back.files.values()
    assert _without_steps(text) == _without_steps((SAMPLES / f"{name}.prg").read_bytes())


def _without_steps(text: bytes) -> list[bytes]:
    """Lines without their numbers, and those of jumps."""
    words = (line.split(b" ", 1)[1] for line in text.splitlines())
    return [w.rstrip(b"0123456789") if w.startswith((b"GOTO", b"IF")) else w for w in words]
