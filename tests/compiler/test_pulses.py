"""Pulses of outputs from one language into the other."""

from __future__ import annotations

import pytest

import assistant
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text

SIGNALS = "".join(f"! signal: do{n} digital output {n}\n" for n in range(1, 6))


def from_rapid(body: str, to: str) -> assistant.Translation:
    text = (
        f"MODULE m\n! program: m\n! entry: main\n{SIGNALS}PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    )
    return assistant.translate(load_text(SourceText(text), language="rapid"), to=to)


def from_melfa(body: str) -> assistant.Translation:
    loaded = load_text(SourceText(f"{body}\nEnd\n"), language="melfa-basic-5")
    return assistant.translate(loaded, to="rapid")


def written(found: assistant.Translation) -> str:
    (data,) = found.files.values()
    return data.decode()


@pytest.mark.parametrize(
    ("pulse", "line"),
    [
        (r"PulseDO\High,do1;", "M_Out(1)=1 Dly 0.2"),
        (r"PulseDO\High\PLength:=1.5,do2;", "M_Out(2)=1 Dly 1.5"),
        (r"PulseDO\High\PLength:=2,do3;", "M_Out(3)=1 Dly 2"),
    ],
)
def test_a_pulse_of_rapid(pulse: str, line: str) -> None:
    found = from_rapid(pulse, "melfa-basic-5")
    assert found.ok and line in written(found)


def test_a_pulse_of_melfa_basic() -> None:
    found = from_melfa("M_Out(7)=1 Dly 0.5")
    assert found.ok and r"PulseDO\High\PLength:=0.5,do_7;" in written(found)


@pytest.mark.parametrize(
    "line", ["M_Out(7)=0 Dly 3000", "M_Out(7)=1 Dly 3000", "M_Out(7)=1 Dly 0", "M_Outb(8)=1 Dly 1"]
)
def test_a_pulse_that_rapid_has_not(line: str) -> None:
    errors = [f.code for f in from_melfa(line).findings if f.severity is Severity.ERROR]
    assert errors == ["RA305"]


def test_a_pulse_to_the_other_value_asks_for_the_value_that_may_be_there() -> None:
    off = from_rapid("PulseDO do1;", "melfa-basic-5")
    assert off.ok and "If" not in written(off) and "M_Out(1)=1 Dly 0.2" in written(off)
    on = written(from_rapid("SetDO do1,1;\nPulseDO do1;", "melfa-basic-5"))
    assert "M_Out(1)=1 Dly 0.2" in on and "M_Out(1)=0 Dly 0.2" in on


def test_no_pulse_is_told_of_where_the_program_asks_whether_its_output_is_off() -> None:
    asked = "SetDO do1,1;\nIF do1=0 THEN\nPulseDO\\High,do1;\nENDIF"
    for body, told in ((asked, False), (asked.replace("=0", "=1"), True)):
        codes = [f.code for f in from_rapid(body, "melfa-basic-5").findings]
        assert ("MB253" in codes) is told


def test_units_of_analog_signals_are_told_in_both_directions() -> None:
    heading = "! signal: speed analog output 6010\n! signal: seen analog input 6020\n"
    body = "SetAO speed,nPercent/10;\nnPercent:=seen;\nSetDO do1,1;"
    text = f"MODULE m\n! program: m\n! entry: main\n{SIGNALS}{heading}VAR num nPercent:=75;\n"
    text += f"PROC main()\n{body}\nENDPROC\nENDMODULE\n"
    found = assistant.translate(load_text(SourceText(text), language="rapid"), to="melfa-basic-5")
    assert [f.message.split("`")[1] for f in found.findings if f.code == "MB300"] == [
        "speed",
        "seen",
    ]
    assert [row.level for row in found.rows.noted if any(f.code == "MB300" for f in row.reasons)]
    back = from_melfa("M_DOut(6010)=75\nM1=M_DIn(6020)\nM_Out(1)=1")
    assert [f.code for f in back.findings].count("RA474") == 2


@pytest.mark.parametrize(
    "line",
    [
        "set grip = 1 pulse 0.5 s",
        "move linear a speed 100 mm/s blend fine set grip = 1 pulse 0.5 s at 0 mm from start",
    ],
)
def test_a_pulse_of_bits_beside_others_is_no_pulse(line: str) -> None:
    text = "program m\nsignal grip group output 8 bits 4\n"
    text += f"target a [400, 0, 400] [0, 0, 1, 0]\nprocedure main\n{line}\nend\n"
    compiled = assistant.compile(load_text(SourceText(text)), language="melfa-basic-5")
    errors = [f.code for f in compiled.findings if f.severity is Severity.ERROR]
    assert errors == ["MB209"]


def test_four_pulses_run_at_a_time() -> None:
    pulses = [rf"PulseDO\High,do{n};" for n in range(1, 6)]
    assert from_rapid("\n".join(pulses[:4]), "melfa-basic-5").ok
    five = from_rapid("\n".join(pulses), "melfa-basic-5")
    assert five.ok and "MB291" in [f.code for f in five.findings]
    apart = [*pulses[:4], "WaitTime 1;", pulses[4]]
    assert from_rapid("\n".join(apart), "melfa-basic-5").ok


@pytest.mark.parametrize(
    ("before", "told"), [("SetDO do1,1;", True), ("SetDO do1,0;", False), ("SetDO do2,1;", False)]
)
def test_what_may_be_on_before_is_told(before: str, told: bool) -> None:
    found = from_rapid(before + "\nPulseDO\\High,do1;", "melfa-basic-5")
    assert ("MB253" in [f.code for f in found.findings]) is told
    number = 1 if "do1" in before else 2
    value = int(before.endswith("1;"))
    back = from_melfa(f"M_Out({number})={value}\nM_Out(1)=1 Dly 0.5")
    assert ("RA313" in [f.code for f in back.findings]) is told
