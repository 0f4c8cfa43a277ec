"""Outputs that moves set on their way: told alike by two interpreters, before and after."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.virtual.events import OnWay, Run, Switched
from tests.examples import drawn
from tests.virtual import melfa_cell, rapid_words
from tests.virtual.rapid_cell import ran
from tests.virtual.test_translated_cases import HEAD
from tests.virtual.test_translated_melfa import SCENARIOS, SIGNALS
from tests.virtual.test_translated_melfa import run_melfa as run_melfa_source
from tests.virtual.test_translated_melfa import run_rapid as run_rapid_target
from tests.virtual.test_translated_rapid import LANGUAGES, NUMBERS, run_melfa, run_rapid
from tests.virtual.translating import Tally, in_turn, judge


def places(run: Run) -> list[tuple[str, float, OnWay | None]]:
    return [(e.signal, e.value, e.at) for e in run.events if isinstance(e, Switched)]


# ---------------------------------------------------------------------------- what each tells
def test_rapid_tells_where_outputs_are_set() -> None:
    run = ran(
        "MoveL p10,v100,fine,tGrip;\n"
        "TriggIO a,20\\DOp:=do1,1;\nTriggEquip b,30\\Start,0.1\\GOp:=go1,5;\n"
        "TriggIO c,0\\Start\\DOp:=do2,1;\nTriggIO d,0\\DOp:=do3,1;\n"
        "TriggL Offs(p10,0,0,100),v100,a\\T2:=b\\T3:=c\\T4:=d,fine,tGrip;\n"
        "TriggIO a,0.2\\Time\\DOp:=do1,0;\n"
        "TriggJ p10,v100,a\\T2:=d,z10,tGrip;",
        data="VAR triggdata a;VAR triggdata b;VAR triggdata c;VAR triggdata d;",
    )
    assert (run.ended, run.message) == ("end", "")
    assert places(run) == [
        ("do2", 1.0, OnWay("start", 0.0)),
        ("go1", 5.0, OnWay("end", pytest.approx(70.0), 0.1)),
        ("do1", 1.0, OnWay("end", 20.0)),
        ("do3", 1.0, None),
        ("do1", 0.0, OnWay("time", 0.2)),
        ("do3", 1.0, OnWay("end", 0.0)),
    ]


def test_rapid_stops_at_triggdata_that_nothing_set_up() -> None:
    run = ran("TriggL p10,v100,a,fine,tGrip;", data="VAR triggdata a;")
    assert run.ended == "error" and "nothing set up" in run.message


def test_melfa_tells_where_outputs_are_set() -> None:
    run = melfa_cell.run(
        "Mvs P1\nMvs P3 Wth M_Out(17)=1\nMvs P1 WthIf M_Ratio>=75,M_Out(18)=1\n"
        "Mvs P3 WthIf M_RDst<20,M_Out(19)=1\nMov P1 WthIf 20>M_RDst,M_Out(20)=1\n"
        "Mvs P3 WthIf M_Ratio>=100,M_Out(21)=1\nEnd"
    )
    assert (run.ended, run.message) == ("end", "")
    assert places(run) == [
        ("17", 1.0, OnWay("start", 0.0)),
        ("18", 1.0, OnWay("end", pytest.approx(25.0))),
        ("19", 1.0, OnWay("end", 20.0)),
        ("20", 1.0, OnWay("end", 20.0)),
        ("21", 1.0, None),
    ]


@pytest.mark.parametrize("condition", ["M_RDst>20", "M_Ratio<>5", "M_Ratio>M_RDst"])
def test_melfa_does_not_guess_when_a_condition_holds(condition: str) -> None:
    run = melfa_cell.run(f"Mvs P1\nMvs P3 WthIf {condition},M_Out(18)=1\nEnd")
    assert run.ended == "unknown"


# ------------------------------------------------------------------------- from RAPID to MELFA

RAPID = """{data}
CONST num five:=5;
CONST num before:=-20;
CONST robtarget q1:=[[354,0,300],[0,0,1,0],[0,0,0,0],{unused}];
CONST robtarget q2:=[[{x},0,{z}],[0,0,1,0],[0,0,0,0],{unused}];
PROC main()
  MoveL q1,v100,fine,tGripper;
{body}
ENDPROC
FUNC num fPlain()
  RETURN 5;
ENDFUNC
{more}"""
SETS_UP = "FUNC num fSetsUp()\nTriggIO gunon,50\\DOp:=do1,1;\nRETURN 5;\nENDFUNC"


def from_rapid(language: str, body: str, folder: FilePath, x: float = 354, z: float = 400) -> Tally:
    """What becomes of a program with these statements; 100 mm from q1 to q2."""
    process = folder / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    tally = Tally()
    data = "".join(f"VAR triggdata {n};\n" for n in ("gunon", "gunoff") if n in body)
    more = SETS_UP if "fSetsUp" in body else ""
    text = RAPID.format(data=data, x=x, z=z, body=body, more=more, unused=rapid_words.UNUSED)
    judge(
        tally,
        body,
        f"{HEAD}{text}\nENDMODULE\n",
        [{}],
        source=("rapid", run_rapid),
        target=(language, lambda *given: run_melfa(language, *given)),
        process=process,
        signals=NUMBERS,
    )
    assert tally.kept == []
    return tally


SAID = {
    "at the start": "TriggIO gunon,0\\Start\\DOp:=do1,1;\nTriggL q2,v100,gunon,fine,tGripper;",
    "before the end": "TriggIO gunon,20\\DOp:=do1,1;\nTriggL q2,v100,gunon,fine,tGripper;",
    "behind the start": "TriggIO gunon,20\\Start\\DOp:=do1,1;\nTriggL q2,v100,gunon,fine,tGripper;",
    "at the end, told from the start": "TriggIO gunon,100\\Start\\DOp:=do1,1;\n"
    "TriggL q2,v100,gunon,fine,tGripper;",
    "by an equipment without delay": "TriggEquip gunon,20,0\\GOp:=goSlot,3;\n"
    "TriggL q2,v100,gunon,z10,tGripper;",
    "at the end": "TriggIO gunon,0\\DOp:=do1,high;\nTriggJ q2,v100,gunon,fine,tGripper;",
    "at both ends": "TriggIO gunon,0\\Start\\DOp:=do1,1;\nTriggIO gunoff,0\\DOp:=do1,0;\n"
    "TriggL q2,v100,gunon\\T2:=gunoff,fine,tGripper;\nMoveL q1,v100,fine,tGripper;",
    "set up once": "TriggIO gunon,20\\DOp:=do1,1;\nTriggIO gunoff,10\\DOp:=do1,0;\n"
    "TriggL q2,v100,gunon,fine,tGripper;\nTriggL q1,v100,gunoff,fine,tGripper;\n"
    "TriggL q2,v100,gunon,fine,tGripper;",
    "a time before the end": "TriggIO gunon,0.2\\Time\\DOp:=do1,1;\n"
    "TriggL q2,v100,gunon,fine,tGripper;",
    "ahead for an equipment": "TriggEquip gunon,20,0.1\\DOp:=do1,1;\n"
    "TriggL q2,v100,gunon,fine,tGripper;",
    "at the end in a corner": "TriggIO gunon,0\\DOp:=do1,1;\nTriggL q2,v100,gunon,z10,tGripper;",
    "by a constant": "TriggIO gunon,five\\DOp:=do1,1;\nTriggL q2,v100,gunon,fine,tGripper;",
    "by a move that calls a function": "TriggIO gunon,20\\DOp:=do1,1;\n"
    "TriggL Offs(q2,0,0,fPlain()),v100,gunon,fine,tGripper;\nTriggIO gunon,9\\DOp:=do1,0;\n"
    "TriggL Offs(q1,0,0,fPlain()),v100,gunon,fine,tGripper;",
    "set up anew": "FOR i FROM 1 TO 2 DO\nTriggIO gunon,20\\DOp:=do1,1;\n"
    "TriggL q2,v100,gunon,fine,tGripper;\nTriggIO gunon,5\\DOp:=do1,0;\n"
    "TriggL q1,v100,gunon,fine,tGripper;\nENDFOR",
}


@pytest.mark.parametrize(("case", "language"), in_turn(SAID, [*LANGUAGES]))
def test_rapid_is_said_alike(case: str, language: str, tmp_path: FilePath) -> None:
    tally = from_rapid(language, SAID[case], tmp_path)
    assert tally.counts["equal"] == 1, tally.reasons


REFUSED = {
    "MB209": {
        "several": "TriggIO gunon,20\\DOp:=do1,1;\nTriggIO gunoff,10\\DOp:=do1,0;\n"
        "TriggL q2,v100,gunon\\T2:=gunoff,fine,tGripper;",
        "a time of a joint move": "TriggIO gunon,0.2\\Time\\DOp:=do1,1;\n"
        "TriggJ q2,v100,gunon,fine,tGripper;",
        "a delay beyond the end": "TriggEquip gunon,5,-0.1\\DOp:=do1,1;\n"
        "TriggL q2,v100,gunon,fine,tGripper;",
        "behind the start of an unknown way": "IF di1=1 MoveL q2,v100,fine,tGripper;\n"
        "TriggIO gunon,9\\Start\\DOp:=do1,1;\nTriggL q2,v100,gunon,fine,tGripper;",
        "a port of a process": "TriggIO gunon,9\\ProcID:=2,1;\nTriggL q2,v100,gunon,fine,tGripper;",
        "more than the start is set": "TriggIO gunon,9\\DOp:=do1,1\\DODelay:=1;\n"
        "TriggL q2,v100,gunon,fine,tGripper;",
        "a worked out place that is to be worked out once": "TriggIO gunon,fPlain()\\DOp:=do1,1;\n"
        "TriggL q2,v100,gunon,fine,tGripper;",
        "what a function sets up": "TriggIO gunon,20\\DOp:=do1,1;\n"
        "TriggL Offs(q2,0,0,fSetsUp()),v100,gunon,fine,tGripper;",
        "what was set up last, and worked out": "IF di1=1 THEN\nTriggIO gunon,20\\DOp:=do1,1;\n"
        "ELSE\nTriggIO gunon,nStep\\DOp:=do1,1;\nENDIF\nTriggL q2,v100,gunon,fine,tGripper;",
    },
    "MB240": {
        "a constant for one bit": "TriggIO gunon,20\\DOp:=do1,five;\n"
        "TriggL q2,v100,gunon,fine,tGripper;",
    },
    "CK112": {
        "a constant before the start": "TriggIO gunon,before\\DOp:=do1,1;\n"
        "TriggL q2,v100,gunon,fine,tGripper;",
    },
}


@pytest.mark.parametrize(
    ("code", "case"), [(code, case) for code, cases in REFUSED.items() for case in cases]
)
def test_what_melfa_cannot_say_is_an_error(code: str, case: str, tmp_path: FilePath) -> None:
    tally = from_rapid("melfa-basic-5", REFUSED[code][case], tmp_path)
    assert tally.counts["refused"] == 1
    assert any(reason.startswith(code) for reason in tally.reasons), tally.reasons


@settings(max_examples=drawn(25), deadline=None)
@given(
    st.sampled_from(["TriggL", "TriggJ"]),
    st.lists(
        st.tuples(
            st.sampled_from([0, 0.5, 20, 99, 150]),
            st.sampled_from(["", "\\Start"]),
            st.sampled_from([None, 0, 0.1]),
            st.sampled_from(["\\DOp:=do1,1", "\\DOp:=do1,0", "\\GOp:=goSlot,2"]),
        ),
        min_size=1,
        max_size=2,
    ),
    st.sampled_from(["fine", "z1", "z50"]),
    st.integers(0, 120),
)
def test_rapid_is_said_alike_or_refused(
    tmp_path_factory: pytest.TempPathFactory,
    word: str,
    triggers: list[tuple[float, str, float | None, str]],
    zone: str,
    up: int,
) -> None:
    lines, names = [], ["gunon", "gunoff"][: len(triggers)]
    for name, (distance, where, delay, output) in zip(names, triggers, strict=True):
        setup = "TriggIO" if delay is None else "TriggEquip"
        lag = "" if delay is None else f",{delay}"
        lines.append(f"{setup} {name},{distance}{where}{lag}{output};")
    taken = "\\T2:=".join(names)
    lines.append(f"{word} q2,v100,{taken},{zone},tGripper;")
    lines.append("MoveL q1,v100,fine,tGripper;")
    tally = from_rapid("melfa-basic-5", "\n".join(lines), tmp_path_factory.mktemp("on"), z=300 + up)
    assert tally.counts["equal"] + tally.counts["refused"] == 1


# ------------------------------------------------------------------------- from MELFA to RAPID


def from_melfa(body: str, level: int = 5, z: float = 400) -> Tally:
    text = f"Spd 100\nMvs P1\n{body}\nMvs P1\nEnd\n"
    for number, height in ((1, 300), (2, z)):
        text += f"P{number}=(+354.00,+0.00,+{height:.2f},+180.00,+0.00,+180.00)(7,0)\n"
    tally = Tally()
    judge(
        tally,
        body,
        text.upper() if level == 4 else text,
        SCENARIOS[:1],
        source=(f"melfa-basic-{level}", lambda *given: run_melfa_source(level, None, *given)),
        target=("rapid", lambda *given: run_rapid_target(None, *given)),
        signals=SIGNALS,
    )
    assert tally.kept == []
    return tally


MOVES = (
    "Mvs P2 Wth M_Out(1)=1",
    "Mvs P2 WthIf M_RDst<=20,M_Out(1)=1",
    "Mvs P2 WthIf 20>M_RDst,M_Out8(8)=17",
    "Mvs P2 WthIf M_Ratio>=80,M_Out(1)=1",
    "Mvs P2 WthIf M_Ratio>=0,M_Out(1)=1",
    "Mvs P2 WthIf M_Ratio>=100,M_Out(1)=1",
    "Mov P2 WthIf M_RDst<20,M_Out(1)=1",
    "Cnt 1,20,20\nMvs P2 Wth M_Out(1)=1\nCnt 0",
)


@pytest.mark.parametrize(("move", "level"), in_turn(MOVES, [4, 5, 6]))
def test_melfa_is_said_alike(move: str, level: int) -> None:
    tally = from_melfa(move, level)
    assert tally.counts["equal"] == 1, tally.reasons


@pytest.mark.parametrize(
    ("move", "code"),
    [
        ("Mov P2 WthIf M_Ratio>80,M_Out(1)=1", "RA305"),
        ("Mvs P2 Wth M_Out(1)=1 Dly 0.5", "RA305"),
        ("Mvs P2 WthIf M_In(1)=1,M_Out(1)=1", "RA304"),
        ("Mvs P2 WthIf M_RDst<20,Skip", "RA304"),
        ("Mvs P2 WthIf M_RDst>20,M_Out(1)=1", "RA304"),
        ("Mvs P2 Wth M1=1", "RA304"),
    ],
)
def test_what_rapid_cannot_say_is_an_error(move: str, code: str) -> None:
    tally = from_melfa(move)
    assert tally.counts["refused"] == 1
    assert any(reason.startswith(code) for reason in tally.reasons), tally.reasons


@settings(max_examples=drawn(25), deadline=None)
@given(
    st.sampled_from(["Mvs", "Mov"]),
    st.sampled_from(["M_RDst<", "M_RDst<=", "M_Ratio>", "M_Ratio>=", "Wth"]),
    st.integers(0, 120),
    st.integers(0, 1),
    st.integers(0, 120),
)
def test_melfa_is_said_alike_or_refused(
    word: str, place: str, amount: int, value: int, up: int
) -> None:
    append = "Wth" if place == "Wth" else f"WthIf {place}{amount},"
    tally = from_melfa(f"{word} P2 {append} M_Out(1)={value}", z=300 + up)
    assert tally.counts["equal"] + tally.counts["refused"] == 1
