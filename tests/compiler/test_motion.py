"""Proof by motion: what was written is run beside its source, and a fault in it is found."""

from __future__ import annotations

from pathlib import Path

import pytest

import assistant
from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.compiler import Compiled
from assistant.compiler.arms import Arms
from assistant.compiler.loader import load, load_text
from assistant.compiler.motion_proof import (
    ComparisonTerms,
    MotionProof,
    Proving,
    prove_motion,
    written_pair,
)
from assistant.virtual.proving import search

CELL = """
[signals.doGrip]
number = 4
[signals.goSlot]
kind = "group"
number = 24
bits = 4
[signals.diPart]
direction = "input"
number = 8
[signals.diReady]
direction = "input"
number = 9
[signals.giOrder]
kind = "group"
direction = "input"
number = 40
bits = 4
"""
SAMPLES = Path(__file__).parents[2] / "samples"
HEAD = """MODULE Cell
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
PERS wobjdata wTable:=[FALSE,TRUE,"",[[300,-100,50],[0.991444861,0,0,0.130526192]],[[0,0,0],[1,0,0,0]]];
CONST robtarget p10:=[[150,120,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[50.123,20,200],[0,0.991444861,0.130526192,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""  # noqa: E501
MAIN = """PROC main()
  VAR num n;
  MoveL p10,v200,fine,tGrip\\WObj:=wTable;
  WaitDI diReady,1;
  n:=giOrder;
  IF n=11 THEN
    Pick p20,2;
  ELSEIF n>3 AND diPart=1 THEN
    Pick p10,n;
  ENDIF
  WaitDI diReady,0\\MaxTime:=2;
  SetGO goSlot,n;
  MoveL p10,v200,z10,tGrip\\WObj:=wTable;
ENDPROC
PROC Pick(robtarget at,num count)
  FOR i FROM 1 TO count DO
    MoveL Offs(at,0,0,20*i),v100,fine,tGrip\\WObj:=wTable;
    SetDO doGrip,i MOD 2;
  ENDFOR
ENDPROC
ENDMODULE
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return made(HEAD + MAIN, "melfa-basic-5", tmp_path_factory.mktemp("compiled"))


def made(text: str, to: str, folder: Path, more: str = "") -> Compiled:
    """A program in another language, with the signals of the cell, and more of them."""
    process = folder / "cell.process.toml"
    process.write_text(CELL + more, encoding="utf-8")
    loaded = load_text(SourceText(text), process=process, language="rapid")
    done = assistant.compile(loaded, language=to)
    assert done.ok, done.findings
    return done


def proof(done: Compiled, proving: Proving | None = None) -> MotionProof:
    given = written_pair(done.source, done.program, done.language, done.files)
    return prove_motion(given, Arms(), proving or Proving())


def with_fault(
    done: Compiled,
    line: str,
    other: str,
    proving: Proving | None = None,
    terms: ComparisonTerms | None = None,
) -> MotionProof:
    """The proof of what was written with another line in it."""
    ((name, data),) = done.files.items()
    assert data.decode().count(line) == 1, data.decode()
    files = {name: data.decode().replace(line, other).encode()}
    given = written_pair(done.source, done.program, done.language, files)
    return prove_motion(given, Arms(), proving or Proving(), None, terms or ComparisonTerms())


def test_every_branch_of_the_source_is_taken(compiled: Compiled) -> None:
    found = proof(compiled, Proving(runs=60))
    assert found.holds
    assert found.found is not None
    assert found.found.total == (3, 15)
    assert found.found.never[0] == ()
    assert found.found.runs > 5 and found.found.visits > found.found.runs
    assert 0.0 < found.found.apart < 0.02
    assert "branches taken: 3 of 3 in standard input, " in found.line()
    left = {(f.path, f.line, f.message) for f in found.findings if f.code == "CO112"}
    assert ("CELL.prg", 58, "no run took this branch: For passed") in left


def test_of_a_library_nothing_is_run() -> None:
    text = "MODULE lib\nPERS num n:=1;\nPROC count()\n  n:=n+1;\nENDPROC\nENDMODULE\n"
    done = assistant.compile(load_text(SourceText(text), language="rapid"), language="rapid")
    assert done.ok
    (finding,) = proof(done).findings
    assert finding.code == "CO111" and "nothing of it was run" in finding.message
    made_of = written_pair(done.source, done.program, done.language, done.files)
    assert prove_motion(made_of, Arms(), Proving(), "count").found is not None


def test_the_modules_of_a_list_are_there_from_the_start(tmp_path: Path) -> None:
    (tmp_path / "m.mod").write_text(HEAD + MAIN, encoding="utf-8")
    listed = tmp_path / "cell.pgf"
    listed.write_text("<Program><Module>m.mod</Module></Program>", encoding="utf-8")
    process = tmp_path / "cell.process.toml"
    process.write_text(CELL, encoding="utf-8")
    done = assistant.compile(load(listed, process=process), language="melfa-basic-5")
    assert done.ok, done.findings
    assert proof(done, Proving(runs=2)).holds


LONG = """PROC main()
  VAR num n;
  FOR i FROM 1 TO 500 DO
    SetDO doGrip,i MOD 2;
    n:=n+i;
  ENDFOR
ENDPROC
ENDMODULE
"""


def test_a_run_that_takes_too_long_is_broken_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was compared by then is reported, and is no proof."""
    done = made("MODULE Cell\n" + LONG, "melfa-basic-5", tmp_path)
    every = proof(done).found
    monkeypatch.setattr(search, "LEAST_SECONDS", 0.0)
    short = proof(done, Proving(seconds=0.0))
    assert every is not None and every.changes == 500
    assert [f.code for f in short.findings if f.severity == "error"] == ["CO111"]
    monkeypatch.setattr(search, "first_run_seconds", lambda _, source: 0.0 if source else 60.0)
    monkeypatch.setattr(search, "first_run_seconds", search.first_run_seconds)
    longer = proof(done, Proving(seconds=0.0))
    assert not longer.holds and longer.found is not None
    assert 0 < longer.found.changes < 100
    (finding,) = longer.findings
    assert finding.code == "CO111" and "takes too long" in finding.message


def test_a_seed_gives_the_same_runs(compiled: Compiled) -> None:
    few = Proving(seed=3, runs=12)
    record = proof(compiled, few).record()
    assert record == proof(compiled, few).record()
    assert record["runs"] == 12


FAULTS = {
    "a condition": ("MN=11 Then", "MN=12 Then", "ended as `error` error 9100", 22),
    "a count": ("MCOUNT=2", "MCOUNT=3", "370.00) at 100.0 blend 0.0 (CELL.prg:63)", 16),
    "an operator": ("And M_In(8)=1", "Or M_In(8)=1", "9=0, and linear to", 16),
    "a place": ("+120.00,+200.00", "+120.00,+200.03", "0.03 mm and 0.00 degrees off", 8),
    "a turn": ("+180.00,+0.00,+15.00", "+180.00,+0.00,+15.10", "0.10 degrees off", 22),
    "a frame": ("PWTABLE=(-263.8958", "PWTABLE=(-263.9158", "0.02 mm", 8),
    "a frame that is turned": ("-15.0000)", "-15.0100)", "another flange", 8),
    "a tool": ("PTGRIP=(+0.00,+0.00,+100", "PTGRIP=(+0.00,+0.00,+101", "another tool", 8),
    "a wait": ("Wait M_In(9)=1", "Wait M_In(9)=0", "another event", 9),
    "a time limit": ("M_Timer(1)<2000", "M_Timer(1)<0", "ended as `error`", 16),
    "an error": ("Error 9100", "MN=MN", "ended as `error`", 16),
    "an output": ("M_Out(4)=1", "M_Out(4)=0", "signal 4 = 1, and signal 4 = 0 (CELL.prg:65)", 23),
    "a corner": ("Cnt 1,10,10", "Cnt 1,20,20", "a wider corner", 18),
    "a speed": ("Spd 100", "Spd 110", "another speed", 22),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_with_its_place(compiled: Compiled, name: str) -> None:
    line, other, said, source = FAULTS[name]
    found = with_fault(compiled, line, other)
    assert not found.holds
    assert found.line() == "not proven"
    (finding,) = [f for f in found.findings if f.code == "CO110"]
    assert said in finding.message.replace("410.00", "370.00")
    assert finding.line == source


def test_warnings_are_named_beside_a_difference(compiled: Compiled) -> None:
    line, other, *_ = next(iter(FAULTS.values()))
    found = with_fault(compiled, line, other, terms=ComparisonTerms(warnings=("MB206", "MB233")))
    (finding,) = [f for f in found.findings if f.code == "CO110"]
    assert "a warning explains it (MB206, MB233); if not, report this" in finding.cure
    (finding,) = [f for f in with_fault(compiled, line, other).findings if f.code == "CO110"]
    assert finding.cure == "nothing was written; report this with the program"


EFFECTS = (
    HEAD.replace("CONST", "PERS num nDone:=0;\nPERS bool bOk:=FALSE;\nCONST", 1)
    + """PROC main()
  MoveL p10,v200,fine,tGrip\\WObj:=wTable;
  WaitDI diReady,1;
  SetDO doGrip,1;
  WaitUntil diPart=1 OR giOrder=3;
  IF (diPart=1 OR diReady=1) AND giOrder<5 THEN
    PulseDO\\PLength:=0.4,doGlue;
  ENDIF
  WaitDI diReady,0;
  nDone:=nDone+1;
  bOk:=TRUE;
  MoveL p20,v200,fine,tGrip\\WObj:=wTable;
  SetDO doGrip,0;
ENDPROC
ENDMODULE
"""
)
GLUE = "[signals.doGlue]\nnumber = 6\n"
UNHEARD = {
    "a dropped wait": ("Wait M_In(9)=1", "MNDONE=MNDONE"),
    "a dropped wait for an input that is off": ("Wait M_In(9)=0", "MNDONE=MNDONE"),
    "an inverted wait": ("Wait M_In(9)=0", "Wait M_In(9)=1"),
    "a wait for another input": ("Wait M_In(9)=1", "Wait M_In(8)=1"),
    "all of a wait": ("Or (M_In8(40)", "And (M_In8(40)"),
    "one of two": ("M_In(8)=1 Or M_In(9)=1", "M_In(8)=1 Xor M_In(9)=1"),
    "a term": ("(M_In(8)=1 Or M_In(9)=1)", "(M_In(8)=1)"),
    "a bound": ("<5", "<=5"),
    "a longer pulse": ("Dly 0.4", "Dly 0.8"),
    "a number that is shared": ("MNDONE+1", "MNDONE+2"),
    "a truth that is shared": ("MBOK=1", "MBOK=0"),
}


@pytest.fixture(scope="module")
def with_effects(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return made(EFFECTS, "melfa-basic-5", tmp_path_factory.mktemp("effects"), GLUE)


@pytest.mark.parametrize("name", UNHEARD)
def test_what_no_motion_shows_is_found(with_effects: Compiled, name: str) -> None:
    assert not with_fault(with_effects, *UNHEARD[name]).holds


def test_waits_and_shared_data_are_counted(with_effects: Compiled) -> None:
    found = proof(with_effects, Proving(runs=30))
    assert found.holds, found.findings
    record = found.record()
    assert record["waits"] > 2 and record["shared_values"] > 2
    assert found.line().count("waits for inputs") == 1


def test_shared_data_that_a_routine_has_by_reference_is_no_difference(tmp_path: Path) -> None:
    """RAPID changes it at once, MELFA-BASIC behind the call."""
    text = (
        HEAD.replace("CONST", "PERS num nDone:=0;\nCONST", 1)
        + """PROC main()
  count nDone;
  MoveL p20,v200,fine,tGrip\\WObj:=wTable;
ENDPROC
PROC count(INOUT num n)
  n:=n+1;
  MoveL p10,v200,fine,tGrip\\WObj:=wTable;
ENDPROC
ENDMODULE
"""
    )
    assert proof(made(text, "melfa-basic-5", tmp_path)).holds


@pytest.mark.slow
def test_a_longer_time_limit_is_found(tmp_path: Path) -> None:
    """Where the time is over both go on, one of them late."""
    text = HEAD + MAIN.replace("\\MaxTime:=2", "\\MaxTime:=2\\TimeFlag:=late")
    text = text.replace("VAR num n;", "VAR num n;\n  VAR bool late;")
    limited = made(text, "melfa-basic-5", tmp_path)
    assert proof(limited).holds
    for seconds in ("200", "20000"):
        assert not with_fault(limited, "<2000", f"<{seconds}").holds


ENDLESS = """PROC main()
  MoveL p10,v200,fine,tGrip\\WObj:=wTable;
  WHILE TRUE DO
    SetDO doGrip,1;
    WaitTime 0.5;
    SetDO doGrip,0;
  ENDWHILE
ENDPROC
ENDMODULE
"""


def test_an_end_is_no_loop_without_end(tmp_path: Path) -> None:
    endless = made(HEAD + ENDLESS, "melfa-basic-5", tmp_path)
    few = Proving(runs=1)
    assert proof(endless, few).holds
    assert not with_fault(endless, "M_Out(4)=0", "M_Out(4)=0 : End", few).holds
    once = ENDLESS.replace("WHILE TRUE DO", "").replace("ENDWHILE", "")
    ends = made(HEAD + once, "melfa-basic-5", tmp_path)
    assert proof(ends, few).holds
    found = with_fault(ends, "Dly 0.5", "*LEND : GoTo *LEND", few)
    assert "the first program ended, the second went on for" in found.findings[0].message


def test_rounding_of_the_last_decimal_is_no_fault(compiled: Compiled) -> None:
    assert proof(compiled, Proving(runs=10)).holds
    few = Proving(runs=10)
    assert with_fault(compiled, "+120.00,+200.00", "+120.00,+200.005", few).holds


def test_what_cannot_be_run_is_said_with_its_place(tmp_path: Path) -> None:
    text = HEAD + MAIN.replace("n:=giOrder;", "n:=giOrder;\n  SetAO aoHeat,n/2;")
    heat = '[signals.aoHeat]\nkind = "analog"\nnumber = 6010\n'
    done = made(text, "melfa-basic-6", tmp_path, heat)
    (finding,) = [f for f in proof(done, Proving(runs=30)).findings if f.code == "CO116"]
    assert "what a register makes of" in finding.message
    assert finding.path == "CELL.prg" and finding.line is not None


SCRIPT = """
[[set]]
input = "diReady"
at = 1
[[set]]
input = "giOrder"
value = 11
[[set]]
input = "diReady"
value = 0
when = "doGrip = 0"
after = 0.5
"""


def test_an_output_of_the_cell_that_is_only_read_is_off(tmp_path: Path) -> None:
    text = HEAD + "PROC main()\nIF doGrip=0 MoveL p10,v100,fine,tGrip;\nENDPROC\nENDMODULE\n"
    there = proof(made(text, "melfa-basic-5", tmp_path))
    found = there.found
    assert found is not None and found.visits and not found.failing
    assert not found.differences


def test_a_script_drives_both_programs(compiled: Compiled, tmp_path: Path) -> None:
    script = tmp_path / "part.toml"
    script.write_text(SCRIPT, encoding="utf-8")
    driven = Proving(script=script)
    found = proof(compiled, driven).record()
    assert found["holds"]
    assert (found["runs"], found["visits"]) == (1, 4)
    assert not with_fault(compiled, "MCOUNT=2", "MCOUNT=1", driven).holds
    assert with_fault(compiled, "MCOUNT=MN", "MCOUNT=1", driven).holds  # nobody goes there


def test_a_script_that_counts_seconds_is_warned_of(compiled: Compiled, tmp_path: Path) -> None:
    script = tmp_path / "part.toml"
    driven = Proving(script=script)
    script.write_text(SCRIPT.replace("at = 1\n", ""), encoding="utf-8")
    assert "CO124" not in [f.code for f in proof(compiled, driven).findings]
    script.write_text(SCRIPT, encoding="utf-8")
    told = [f.message for f in proof(compiled, driven).findings if f.code == "CO124"]
    assert len(told) == 1 and "changes `diready` at 1 s" in told[0]


def test_a_script_that_leaves_a_program_waiting_proves_nothing(tmp_path: Path) -> None:
    script = tmp_path / "part.toml"
    script.write_text('[[set]]\ninput = "diPart"\n', encoding="utf-8")
    waits = made(
        HEAD
        + MAIN.replace("  MoveL p10,v200,fine", "  WaitDI diReady,1;\n  MoveL p10,v200,fine", 1),
        "melfa-basic-5",
        tmp_path,
    )
    found = proof(waits, Proving(script=script))
    assert not found.holds
    (finding,) = [f for f in found.findings if f.code == "CO111"]
    assert "only waits, and nothing is compared" in finding.message


def test_a_script_that_leaves_a_program_waiting_half_way_is_told(
    compiled: Compiled, tmp_path: Path
) -> None:
    script = tmp_path / "part.toml"
    script.write_text('[[set]]\ninput = "diPart"\n', encoding="utf-8")
    (finding,) = [f for f in proof(compiled, Proving(script=script)).findings if f.code == "CO114"]
    assert finding.line == HEAD.count("\n") + MAIN[: MAIN.index("WaitDI")].count("\n") + 1
    script.write_text(SCRIPT, encoding="utf-8")
    found = proof(compiled, Proving(script=script)).findings
    assert "CO114" not in {f.code for f in found}


def test_a_script_that_is_wrong_is_refused(compiled: Compiled, tmp_path: Path) -> None:
    script = tmp_path / "part.toml"
    script.write_text("[[set]]\nvalue = 1\n", encoding="utf-8")
    with pytest.raises(Refused):
        proof(compiled, Proving(script=script))


def test_tools_and_frames_of_another_cell(tmp_path: Path) -> None:
    cell = "[frames.wTable]\nposition = [400, 10, 60]\n[tools.tGrip]\ntip = [5, 0, 120]\n"
    there = made(HEAD + MAIN, "melfa-basic-5", tmp_path, cell)
    found = proof(there, Proving(runs=20))
    assert found.holds, found.findings
    ((name, data),) = there.files.items()
    assert b"PWTABLE=(-400." in data
    (tmp_path / name).write_bytes(data)
    other = tmp_path / "other.process.toml"
    other.write_text("[frames.wTable]\nposition = [410, 10, 60]\n", encoding="utf-8")
    back = assistant.translate(tmp_path / name, to="rapid", process=other, proving=Proving(runs=20))
    assert back.ok, [f for f in back.findings if f.severity == "error"]
    assert b"410,10,60" in next(iter(back.files.values()))


@pytest.mark.parametrize(
    ("language", "robot"), [("rapid", "irb1200-7-0.7"), ("melfa-basic-4", "rv-2aj")]
)
def test_what_is_written_of_a_drawing_moves_as_it_says(language: str, robot: str) -> None:
    source = SAMPLES / "plate.dxf"
    compiled = assistant.compile(source, language=language, robot=robot, proving=Proving())
    assert compiled.ok
    found = compiled.motion
    assert found is not None and found.found is not None
    assert (found.found.runs, found.found.visits, found.found.changes) == (1, 103, 12)
    assert 0.0 < found.found.apart < 0.01


def test_a_fault_in_what_is_written_of_a_table_is_found() -> None:
    table = SAMPLES / "positioning.csv"
    compiled = assistant.compile(table, language="rapid", robot="irb1200-7-0.7")
    found = with_fault(compiled, "MoveL positioning_30,", "MoveL positioning_29,")
    assert not found.holds
    assert "another flange" in found.findings[0].message


def test_data_alone_is_nothing_that_could_be_run(tmp_path: Path) -> None:
    data = HEAD + "ENDMODULE\n"
    found = proof(made(data, "melfa-basic-5", tmp_path))
    assert found.holds
    assert found.record()["runs"] == 0


def test_a_search_goes_on_behind_inputs_that_the_program_fails_with(tmp_path: Path) -> None:
    """A place of a pallet that inputs tell: with all of them off there is no such place."""
    source = tmp_path / "JOB.prg"
    source.write_text(
        "Def Plt 1,PS,PA,PB,,2,2,2\nMK=M_In8(11)\nMvs (Plt 1,MK)\n"
        "If M_In(3)=1 Then M_Out(4)=1\nEnd\nPS=(400,0,400,180,0,180)(7,0)\n"
        "PA=(420,0,400,180,0,180)(7,0)\nPB=(400,9,400,180,0,180)(7,0)\n"
    )
    made = assistant.translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert made.motion is not None
    assert made.motion.holds, made.findings
    assert made.motion.found is not None
    assert 0 < made.motion.found.failing < made.motion.found.runs


UNSET = """If M_In(39)=1 Then GoTo *ON
M1=0
*ON
M1=M1+1
Mvs P1
M_Out(8)=M1
End
P1=(400,0,450,180,0,180)(7,0)
"""


def test_a_number_that_nothing_was_given_stops_both_programs(tmp_path: Path) -> None:
    (tmp_path / "JOB.prg").write_text(UNSET)
    made = assistant.translate(
        tmp_path / "JOB.prg", to="melfa-basic-5", language="melfa-basic-5", proving=Proving()
    )
    assert made.motion is not None and made.motion.found is not None
    assert made.motion.holds, made.findings
    assert 0 < made.motion.found.failing < made.motion.found.runs
    found = with_fault(made.compiled, "M1=0\r\n", "M2=0\r\n")
    assert "the variable M1 has no value" in found.findings[0].message
    assert not found.holds


def test_files_that_are_loaded_while_the_program_runs(tmp_path: Path) -> None:
    """A program that calls another one becomes a module that loads another one."""
    place = "P1=(400,0,{z},180,0,180)(7,0)\n"
    (tmp_path / "MAIN.prg").write_text('Mvs P1\nCallP "SUB"\nEnd\n' + place.format(z=400))
    (tmp_path / "SUB.prg").write_text("Mvs P1\nM_Out(3)=1\nEnd\n" + place.format(z=300))
    made = assistant.translate(
        tmp_path / "MAIN.prg", to="rapid", language="melfa-basic-5", proving=Proving()
    )
    assert len(made.files) == 2
    assert made.motion is not None
    assert made.motion.holds, made.findings
    assert made.motion.found is not None
    assert (made.motion.found.visits, made.motion.found.changes) == (2, 1)
