"""Cell files that write themselves: what a program uses and nobody declares, with its values."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from assistant.base.diagnostics import Refused
from assistant.cli.app import app
from assistant.compiler import load, translate
from assistant.compiler.cell_defaults import cell_text, neutral_cell, with_neutral_cell
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation
from assistant.sources.cell_values import read_cell

USES = """MODULE Cell
  VAR num n:=0;
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL p10,vFast,zBig,tGrip\\WObj:=wTable;
    MoveL pPick,v100,fine,tGrip;
    SetDO doGrip,1;
    WaitDI diPart,1;
    IF diReady=1 AND bOn THEN
      n:=nOther+parts{3};
    ENDIF
    count:=count+1;
    rHome;
    rMoveTo p10,5;
    n:=fCount(3);
    MoveL p10,v100,fine,tool0;
  ENDPROC
ENDMODULE
"""


def program(folder: Path, text: str = USES) -> Path:
    file = folder / "cell.mod"
    file.write_text(text, encoding="utf-8", newline="\n")
    return file


def test_every_missing_thing_has_an_entry_with_its_type_and_uses(tmp_path: Path) -> None:
    text = neutral_cell(load(program(tmp_path)))
    for entry in (
        "# speed vFast, used in cell.mod:5\n[speeds.vFast]\nspeed = 100 ",
        '[blends.zBig]\nblend = "fine" ',
        "# tool tGrip, used in cell.mod:5, cell.mod:6\n[tools.tGrip]\ntip = [0, 0, 0] ",
        "[frames.wTable]\nposition = [0, 0, 0] ",
        "[positions.pPick]\nposition = [400, 0, 400] ",
        "number = 4\n\n# digital input diPart",
        '[signals.diReady]\nkind = "digital"\ndirection = "input"\nnumber = 7',
        '# data of type bool bOn, used in cell.mod:9\n[data.bOn]\ntype = "bool"\nvalue = false',
        '[data.parts]\ntype = "num"\nvalue = [0, 0, 0]',
        '[data.count]\ntype = "num"\nvalue = 0',
        "# routine rMoveTo(robtarget, num), used in cell.mod:14\n[routines.rMoveTo]",
        "# routine fCount(num) that gives num",
    ):
        assert entry in text, entry


def test_a_program_with_a_filled_cell_is_whole_and_proven(tmp_path: Path) -> None:
    file, cell = program(tmp_path), tmp_path / "cell.toml"
    cell.write_text(neutral_cell(load(file)), encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=cell, proving=Proving())
    assert done.ok, [*done.findings]
    assert not done.draft
    assert done.motion is not None and done.motion.holds


CALLING = ("While 1", "cycle()", "WEnd", "FEnd", "Function V cycle()")
"""Lines that lead to the first one of a cycle."""


def test_what_is_not_filled_in_makes_a_draft_that_says_so(tmp_path: Path) -> None:
    file, cell = program(tmp_path), tmp_path / "cell.toml"
    done = translate(file, to="melfa-basic-6", cell=cell)
    assert (done.ok, done.draft, done.compiled.ok) == (False, True, True)
    (made,) = done.files.values()
    text = made.decode("ascii")
    assert "DRAFT: not for production" in text
    assert "to be filled in: tool tGrip" in text
    assert text.count("PtGrip=(") == 1
    body = [line.split(maxsplit=1)[1].strip() for line in text.splitlines() if line[:1].isdigit()]
    begun = body[body.index("Function V Main()") + 1 :]
    first = [line for line in begun[: begun.index("Hlt")] if line not in CALLING]
    assert all(line[0] == "M" and "=" in line for line in first if line[0] != "'")
    assert not [line for line in first if line.startswith("M_")]
    assert "CO071" in {f.code for f in done.whole}
    assert not [row for row in done.rows if row.level == "not"]


MELFA = """\
1 Tool PGRIP
2 JOvrd 20
3 Mov P1
4 End
PGRIP=(+0.00,+0.00,+60.00,+0.00,+0.00,+0.00)(0,0)
P1=(+400.00,-60.00,+300.00,+180.00,+0.00,+0.00)(7,0)
"""


def test_a_draft_asks_for_loads_that_the_source_keeps_in_parameters(tmp_path: Path) -> None:
    file, cell = tmp_path / "G.prg", tmp_path / "cell.toml"
    file.write_text(MELFA)

    def again() -> Translation:
        return translate(
            file, language="melfa-basic-5", to="rapid", robot="irb1200-7-0.7", cell=cell
        )

    done = again()
    (made,) = done.files.values()
    assert b"to be filled in: load of tool PGRIP; the least mass is a stand-in" in made
    assert b"to be filled in: speed joint_speed; 100 mm/s is a stand-in" in made
    asked = cell_text(read_cell(cell), done.wanting)
    assert "tip = [0, 0, 60]" in asked and 'mass = "?"' in asked and 'centre = "?"' in asked
    filled = asked.replace('mass = "?"', "mass = 2.5").replace('centre = "?"', "centre = [1, 2, 3]")
    cell.write_text(filled.replace('speed = "?"', "speed = 50"))
    done = again()
    (made,) = done.files.values()
    assert b"[[0,0,60],[1,0,0,0]],[2.5,[1,2,3]," in made and b"DRAFT" not in made
    assert not done.wanting


def test_the_number_of_a_signal_that_stands_in_is_marked(tmp_path: Path) -> None:
    file = program(tmp_path)
    done = translate(file, to="melfa-basic-6", cell=tmp_path / "cell.toml")
    (made,) = done.files.values()
    assert re.search(rb"to be filled in: digital \w+ \w+; number \d+ is a stand-in", made)


def test_a_draft_is_not_proven_by_motion(tmp_path: Path) -> None:
    file, cell = program(tmp_path), tmp_path / "cell.toml"
    done = translate(file, to="melfa-basic-6", cell=cell, proving=Proving(seconds=1))
    assert done.motion is None and done.draft
    assert "CO074" in {f.code for f in done.whole}


def test_the_proof_of_a_draft_that_stops_at_statements_is_said_not_to_have_run(
    tmp_path: Path,
) -> None:
    file = program(tmp_path, DECLARED.replace("vFast", "v100").replace("tGrip", "tool0"))
    file.write_text(file.read_text().replace("rHome;", 'Open "HOME:/log.txt",ioFile;'))
    cell = tmp_path / "cell.toml"
    cell.write_text(neutral_cell(load(file)), encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=cell, draft=True, proving=Proving(seconds=1))
    assert done.draft and not done.wanting and done.motion is None
    (finding,) = (one for one in done.whole if one.code == "CO016")
    assert "a draft" in finding.message
    done = translate(file, to="melfa-basic-6", cell=cell, draft=True)
    assert "CO016" not in {one.code for one in done.whole}


def test_the_file_is_taken_back_in_and_keeps_what_people_wrote(tmp_path: Path) -> None:
    file, path = program(tmp_path), tmp_path / "cell.toml"
    first = cell_text(read_cell(path), translate(file, to="melfa-basic-6", cell=path).wanting)
    assert first.count('"?"') > 10
    told = first.replace('tip = "?"', "tip = [0, 0, 120]  # measured by Ada")
    path.write_text(told, encoding="utf-8")
    again = translate(file, to="melfa-basic-6", cell=path)
    assert "tGrip" not in {one.name for one in again.wanting}
    assert b"PtGrip=(+0.00,+0.00,+120.00" in b"".join(again.files.values())
    assert cell_text(read_cell(path), again.wanting) == told


def test_a_routine_that_was_not_read_comes_from_a_file_beside(tmp_path: Path) -> None:
    text = "MODULE Cell\n PROC main()\n  rWash;\n ENDPROC\nENDMODULE\n"
    file, path = program(tmp_path, text), tmp_path / "cell.toml"
    path.write_text('[routines.rWash]\nroutine = "wash.mod"\n', encoding="utf-8")
    with pytest.raises(Refused, match=r"wash\.mod"):
        translate(file, to="melfa-basic-6", cell=path)
    wash = "MODULE Wash\n PROC rWash()\n  SetDO doWater,1;\n ENDPROC\nENDMODULE\n"
    (tmp_path / "wash.mod").write_text(wash, encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=path)
    assert [one.name for one in done.wanting] == ["doWater"]
    path.write_text('[routines.rWash]\nroutine = "empty"\n', encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=path)
    assert done.ok and b"Hlt" not in b"".join(done.files.values())


def test_an_array_has_as_many_elements_as_the_cell_file_says(tmp_path: Path) -> None:
    file, path = program(tmp_path), tmp_path / "cell.toml"
    text = neutral_cell(load(file)).replace("value = [0, 0, 0]", "value = [1, 2, 3, 4, 5]")
    path.write_text(text, encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=path, proving=Proving())
    assert done.ok and b"(5)" in b"".join(done.files.values())


@pytest.mark.parametrize("value", ["true", '"5"', "[1, 2]"])
def test_data_of_another_type_are_refused(tmp_path: Path, value: str) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(f'[data.nOther]\ntype = "num"\nvalue = {value}\n', encoding="utf-8")
    with pytest.raises(Refused, match="no value of the type num"):
        translate(program(tmp_path), to="melfa-basic-6", cell=path)


def test_what_a_cell_file_says_wrongly_is_told_at_its_line(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text('[speeds.vFast]\nspeed = "fast"\n', encoding="utf-8")
    with pytest.raises(Refused) as told:
        translate(program(tmp_path), to="melfa-basic-6", cell=path)
    assert [(f.code, f.line) for f in told.value.findings] == [("CT303", 2)]


TAUGHT = """MODULE Cell
  CONST num N:=3;
  VAR speeddata vX:=v200;
  PERS zonedata zX:=fine;
  PERS speeddata vY:=vX;
  VAR num a{N};
  CONST jointtarget jHome:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    VAR num key;
    MoveAbsJ jHome,vX,zX,tool0;
    MoveAbsJ jHome,vY,zX,tool0;
    a{N}:=2;
    TPReadFK key,"what?","A","B",stEmpty,stEmpty,stEmpty;
    SetDO do1,key-1;
  ENDPROC
ENDMODULE
"""


def test_joint_angles_and_an_operators_keys_are_in_the_cell_file(tmp_path: Path) -> None:
    file, cell = program(tmp_path, TAUGHT), tmp_path / "cell.toml"
    done = translate(file, to="melfa-basic-6", cell=cell)
    names = [one.name for one in done.wanting]
    assert names == ["do1", "operator_key_1", "operator_key_2", "taught_on"]
    assert done.draft and done.compiled.ok
    known = translate(file, to="melfa-basic-6", cell=cell, from_robot="rv-4frl", robot="rv-4frl")
    assert "taught_on" not in [one.name for one in known.wanting]


def test_data_that_are_named_after_constants_are_constants(tmp_path: Path) -> None:
    file, cell = program(tmp_path, TAUGHT), tmp_path / "cell.toml"
    cell.write_text(neutral_cell(load(file)), encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=cell, proving=Proving())
    assert done.ok, [f.message for row in done.rows for f in row.reasons]


def test_the_arm_of_a_cell_file_is_that_of_its_joint_angles(tmp_path: Path) -> None:
    file, cell = program(tmp_path, TAUGHT), tmp_path / "cell.toml"
    cell.write_text('[arms.taught_on]\narm = "irb1200-7-0.7"\n', encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=cell, robot="rv-4frl")
    told = [f.code for row in done.rows for f in row.reasons]
    assert "CO501" in told and "CO503" not in told


def test_answers_on_a_terminal_are_written_and_used(tmp_path: Path) -> None:
    text = "MODULE Cell\n PROC main()\n  rWash;\n  SetDO doX,1;\n ENDPROC\nENDMODULE\n"
    file, path = program(tmp_path, text), tmp_path / "cell.toml"
    command = ["translate", str(file), "--to", "melfa-basic-6", "--cell", str(path), "--ask"]
    first = CliRunner().invoke(app, [*command, "-o", str(tmp_path)], input="no.mod\n-1\n7\n")
    assert first.exit_code == 1, first.output
    assert "number = 7" in path.read_text(encoding="utf-8")
    path.write_text(path.read_text(encoding="utf-8").replace("no.mod", "?"), encoding="utf-8")
    again = CliRunner().invoke(app, [*command, "-o", str(tmp_path)], input="empty\n")
    assert again.exit_code == 0, again.output
    assert 'routine = "empty"' in path.read_text(encoding="utf-8")


def test_first_values_stand_behind_those_that_they_are_made_of(tmp_path: Path) -> None:
    text = """MODULE Cell
  VAR num high:=size*1.25;
  CONST num size:=50;
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL Offs(p10,0,0,high),v100,fine,tool0;
  ENDPROC
ENDMODULE
"""
    done = translate(program(tmp_path, text), to="melfa-basic-6", proving=Proving())
    assert done.ok, [f.message for f in done.findings]


def test_a_process_file_counts_beside_a_cell_file(tmp_path: Path) -> None:
    text = """MODULE Cell
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveL p10,vFast,fine,tGrip;
  ENDPROC
ENDMODULE
"""
    process, cell = tmp_path / "cell.process.toml", tmp_path / "cell.toml"
    process.write_text("[tools.tGrip]\ntip = [0, 0, 77]\n", encoding="utf-8")
    cell.write_text("[speeds.vFast]\nspeed = 33\n", encoding="utf-8")
    file = program(tmp_path, text)
    done = translate(file, to="melfa-basic-6", process=process, cell=cell)
    made = b"".join(done.files.values())
    assert done.ok and b"Spd 33" in made and b"PtGrip=(+0.00,+0.00,+77.00" in made


def test_data_of_the_cell_stands_before_its_routines(tmp_path: Path) -> None:
    moves = "rFirst;\nMoveL [[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    text = f"MODULE Cell\nPROC main()\n{moves},v100,fine,tGrip;\nENDPROC\nENDMODULE\n"
    loaded = with_neutral_cell(load(program(tmp_path, text)))
    assert translate(loaded, to="melfa-basic-6").ok


def test_a_neutral_cell_names_no_arm_though_the_files_of_the_controller_do(tmp_path: Path) -> None:
    path = program(
        tmp_path,
        "MODULE Cell\nCONST jointtarget home:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "PROC main()\nMoveAbsJ home,v100,fine,tool0;\nENDPROC\nENDMODULE\n",
    )
    (tmp_path / "SYSPAR").mkdir()
    (tmp_path / "SYSPAR" / "MOC.cfg").write_text(
        'MOC:CFG_1.0:6:1::\nROBOT:\n      -name "ROB_1" -use_robot_type "ROB1_1200_0.9_5_TypeB"\n'
    )
    loaded = load(path)
    assert loaded.arm == "irb1200-5-0.9"
    done = translate(with_neutral_cell(loaded), to="melfa-basic-6")
    assert done.ok, [f.message for f in done.findings]


def test_a_tool_that_another_task_gives_its_value_is_asked_for(tmp_path: Path) -> None:
    text = (
        "MODULE seen\nPERS tooldata held;\nPERS wobjdata place;\nPERS tooldata unused;\n"
        "CONST robtarget near:=[[400,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        "VAR num high;\nPROC main()\nVAR robtarget at;\nMoveL near,v100,fine,held\\WObj:=place;\n"
        "at:=CRobT(\\Tool:=held\\WObj:=place);\nhigh:=at.trans.z;\n"
        "MoveL Offs(at,0,0,10),v50,fine,held\\WObj:=place;\nENDPROC\nENDMODULE\n"
    )
    source = tmp_path / "seen.mod"
    source.write_text(text, "ascii")
    cell = tmp_path / "cell.toml"
    first = translate(source, to="melfa-basic-6", cell=cell)
    assert not first.totals["not"]
    assert {one.name for one in first.wanting} == {"held", "place"}
    cell.write_text(
        "[tools.held]\ntip = [0, 0, 55]\n[frames.place]\nposition = [10, 20, 30]\n", "ascii"
    )
    second = translate(source, to="melfa-basic-6", cell=cell, proving=Proving(seconds=2.0))
    assert second.ok and not second.wanting
    assert second.motion is not None and second.motion.holds
    assert second.compiled.program.tools["held"].tip.position == (0, 0, 55)
    assert second.compiled.program.frames["place"].pose.position == (10, 20, 30)


DECLARED = """MODULE Home
  CONST jointtarget jHome:=[[0,-10,20,0,80,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  RECORD pair
    num a;
  ENDRECORD
  CONST num nHigh:=300;
  VAR pair two;
  PROC main()
    MoveAbsJ jHome,vFast,fine,tGrip;
    WaitTime nHigh;
    rHome;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(
    ("entry", "said", "cure"),
    [
        ("[positions.jHome]\njoints = [0, 0, 0, 0, 30, 0]", "`jHome` itself", "delete the entry"),
        ('[data.JHOME]\ntype = "num"\nvalue = 1', "`jHome` itself", "delete the entry"),
        ("[data.nHigh]\nvalue = 1", "`nHigh` itself", "delete the entry"),
        ('[routines.main]\nroutine = "empty"', "`main` itself", "delete the entry"),
        ("[data.tGrip]\nvalue = 1", "uses `tGrip` as tool", "write `[tools.tGrip]`"),
        ('[records.Pair]\ncomponents = ["num b"]', "type `pair`", "delete the entry, and correct"),
        ('[records.other]\ncomponents = ["num b"]', "", ""),
        ('[arms.taught]\narm = "irb120-3-0.58"', "only arm", "write `[arms.taught_on]`"),
        ('[arms.taught_on]\narm = "irb120-3-0.58"', "", ""),
        ("[speeds.vFast]\nspeed = 20", "", ""),
        ("[positions.pOfAnotherProgram]\nposition = [1, 2, 3]", "", ""),
    ],
)
def test_a_value_of_the_cell_file_that_changes_nothing_is_told_of(
    tmp_path: Path, entry: str, said: str, cure: str
) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(entry + "\n", encoding="utf-8")
    done = translate(program(tmp_path, DECLARED), to="melfa-basic-6", cell=cell)
    told = [one for one in done.whole if one.code == "CO079"]
    if not said:
        assert not told
        return
    (finding,) = told
    assert entry.splitlines()[0].lower() in finding.message.lower() and said in finding.message
    assert finding.cure.startswith(cure) and finding.path == str(cell)


@pytest.mark.parametrize(
    ("arm", "told"), [("irb120-3-0.58", True), ("same", True), ("irb1200-7-0.7", False)]
)
def test_another_arm_in_the_cell_file_than_the_one_that_is_named_is_told_of(
    tmp_path: Path, arm: str, told: bool
) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(f'[arms.taught_on]\narm = "{arm}"\n', encoding="utf-8")
    file = program(tmp_path, DECLARED)
    done = translate(file, to="melfa-basic-6", cell=cell, from_robot="irb1200-7-0.7")
    found = [one.message for one in done.whole if one.code == "CO079"]
    assert len(found) == told and all("`irb1200-7-0.7` is named" in one for one in found)


def test_a_cell_file_written_for_a_program_has_no_entry_that_changes_nothing(
    tmp_path: Path,
) -> None:
    file, cell = program(tmp_path), tmp_path / "cell.toml"
    cell.write_text(neutral_cell(load(file)), encoding="utf-8")
    done = translate(file, to="melfa-basic-6", cell=cell)
    assert "CO079" not in {one.code for one in done.whole}


@pytest.mark.parametrize(
    ("statements", "routine", "said"),
    [
        ('ReadCfgData "/MOC/ARM/rob1_1","upper",most;', "ReadCfgData", "`most` keeps what it has"),
        ('ReadCfgData "/MOC/ARM/rob1_1","upper",row{2};', "ReadCfgData", "`row` keeps"),
        ("most:=fCount(3);", "fCount", "always 0"),
        ("st:=TextGet(1,2);", "TextGet", 'always ""'),
        ("rMoveTo most,5;", "rMoveTo", ""),
        ('WriteCfgData "/MOC/ARM/rob1_1","upper",most;', "WriteCfgData", ""),
    ],
)
def test_a_routine_without_contents_gives_no_values(
    tmp_path: Path, statements: str, routine: str, said: str
) -> None:
    text = (
        "MODULE cell\nVAR num most;\nVAR num row{3};\nVAR string st;\n"
        f"PROC main()\n{statements}\nENDPROC\nENDMODULE\n"
    )
    cell = tmp_path / "cell.toml"
    for value in ("empty", "stop"):
        cell.write_text(f'[routines.{routine}]\nroutine = "{value}"\n', encoding="utf-8")
        done = translate(program(tmp_path, text), to="melfa-basic-6", cell=cell, draft=True)
        told = [one.message for one in done.whole if one.code == "CO082"]
        assert len(told) == (value == "empty" and bool(said))
        assert all(said in one and "cell.mod:6" in one for one in told)
