"""Translating: what becomes of each statement, and drafts where not everything can be said."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler import Translation, load, translate
from assistant.program import expressions as e
from assistant.program import statements as p
from tests.examples import drawn

MODULE = """MODULE Cell
    VAR egmident path;
    PERS tooldata torch:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
    CONST robtarget p10:=[[350,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num n;
    PROC main()
        MoveJ p10,v1000,fine,torch;
        EGMReset path;
        MoveL Offs(p10,0,0,
            -50),v100,fine,torch;
        IF n>3 THEN
            TPWrite "hello";
            SetDO do1,1;
        ELSE
            n:=n+GetMotorTorque(2);
        ENDIF
    ENDPROC
ENDMODULE
"""
PROGRAM = """1 Spd 100
2 Cnt 0
3 Mov PHome
4 Torq 2,50
5 If M1>3 Then
6 Mvs PHome,-50
7 XRun 2,"OTHER"
8 EndIf
9 End
PHome=(350,0,400,180,0,180)(7,0)
"""
MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")
ARM = {"rapid": "irb1200-7-0.7", **dict.fromkeys(MELFA, "rv-4frl")}


def translated(folder: Path, text: str, to: str, **options: object) -> Translation:
    name = "cell.mod" if text.startswith("MODULE") else "CELL.prg"
    file = folder / name
    file.write_text(text, encoding="utf-8", newline="\n")
    return translate(file, to=to, robot=ARM[to], **options)


def levels(translation: Translation) -> dict[int, str]:
    return {row.place.line: row.level for row in translation.rows}


@pytest.mark.parametrize("to", MELFA)
def test_each_statement_of_rapid_has_its_level(tmp_path: Path, to: str) -> None:
    found = translated(tmp_path, MODULE, to)
    assert levels(found) == {
        2: "partial",
        3: "partial",
        4: "supported",
        5: "supported",
        6: "partial",
        7: "partial",
        8: "not",
        9: "supported",
        11: "supported",
        12: "partial",
        13: "not",
        15: "not",
    }
    assert found.totals == {"supported": 4, "partial": 5, "not": 3}
    assert not found.ok
    assert not found.files


@pytest.mark.parametrize("language", ["melfa-basic-5", "melfa-basic-6"])
def test_each_statement_of_melfa_basic_has_its_level(tmp_path: Path, language: str) -> None:
    found = translated(tmp_path, PROGRAM, "rapid", language=language)
    assert levels(found) == {
        1: "supported",
        2: "supported",
        3: "partial",
        4: "not",
        5: "partial",  # nothing gives M1 a value
        6: "supported",
        7: "not",
        10: "supported",
    }


def test_a_program_that_is_not_beside_changes_no_meaning(tmp_path: Path) -> None:
    text = '10 XLOAD 2,"OTHER"\n20 XRUN 2,"OTHER"\n30 END\n'
    translation = translated(tmp_path, text, "melfa-basic-5")
    assert translation.ok
    assert {row.level for row in translation.rows} == {"supported"}
    assert [f.code for row in translation.rows for f in row.reasons] == ["MB115"]


@pytest.mark.parametrize(("x", "codes"), [(350, set()), (3500, {"RB102"})])
def test_another_version_for_a_robot_is_within_its_reach(
    tmp_path: Path, x: int, codes: set[str]
) -> None:
    text = f"10 TOOL P_NTOOL\n20 MOV P1\n30 END\nP1=({x},0,400,180,0,180)(7,0)\n"
    translation = translated(tmp_path, text, "melfa-basic-5")
    assert {f.code for f in translation.findings} == codes
    assert translation.ok == (not codes)


def test_a_level_says_why(tmp_path: Path) -> None:
    rows = {row.place.line: row for row in translated(tmp_path, MODULE, "melfa-basic-5").rows}
    assert [f.code for f in rows[2].reasons] == ["RA342"]
    assert [f.code for f in rows[7].reasons] == ["MB204"]
    assert "EGMReset" in rows[8].reasons[0].message
    assert "do1" in rows[13].reasons[0].message
    assert rows[9].text == "MoveL Offs(p10,0,0, -50),v100,fine,torch"
    assert rows[11].text == "IF n>3 THEN"


def test_statements_tell_where_they_went(tmp_path: Path) -> None:
    text = MODULE.replace("EGMReset path;", "").replace("SetDO do1,1;", "")
    text = text.replace("GetMotorTorque(2)", "1").replace("VAR egmident path;", "")
    found = translated(tmp_path, text, "melfa-basic-5")
    assert found.ok, found.findings
    ((name, data),) = found.files.items()
    written = data.decode().splitlines()
    went = {row.place.line: row.went[0] for row in found.rows if row.went}
    assert {place.path for place in went.values()} == {name}
    assert {line: _word(written[place.line - 1]) for line, place in went.items()} == {
        7: "Mov",
        9: "Mvs",
        11: "If",
        12: "'",
        15: "MN=MN+1",
    }


def _word(line: str) -> str:
    """The statement's own word, behind the step number."""
    return line.split()[1]


@pytest.mark.parametrize("to", MELFA)
def test_a_draft_stops_at_what_it_cannot_say(tmp_path: Path, to: str) -> None:
    found = translated(tmp_path, MODULE, to, draft=True)
    assert found.draft
    assert not found.ok
    assert found.proof.holds
    ((name, data),) = found.files.items()
    (tmp_path / name).write_bytes(data)
    program = load(tmp_path / name, language=to).program
    assert program.comments[0].startswith("DRAFT")
    said = list(program.statements())
    stops = [said[i : i + 3] for i, x in enumerate(said) if isinstance(x, p.Stop) and not x.end]
    quoted = [[c.text for c in rest if isinstance(c, p.Comment)] for _, *rest in stops]
    assert quoted == [
        [],  # it stops at its start
        ["not translated, line 8:", "| EGMReset path"],
        ["not translated, line 13:", "| SetDO do1,1"],
        ["not translated, line 15:", "| n:=n+GetMotorTorque(2)"],
    ]


def test_settings_of_what_a_draft_leaves_out_do_not_take_the_moves_with_them(
    tmp_path: Path,
) -> None:
    text = (
        "Tool P_NTool\nBase P_NBase\nSpd 100\nMvs P1\nFsc On\nMvs P2\n"
        "P1=(400,0,300,180,0,180)(7,0)\nP2=(400,10,300,180,0,180)(7,0)\n"
    )
    found = translated(tmp_path, text, "melfa-basic-4", language="melfa-basic-5", draft=True)
    assert [row.text for row in found.rows if row.level == "not"] == ["Fsc On"]
    assert found.draft and found.proof.holds
    (data,) = found.files.values()
    words = [_word(line) for line in data.decode().splitlines() if line[0].isdigit()]
    assert words.count("MVS") == 2 and words.count("HLT") == 2  # at its start, and for FSC
    assert words.index("HLT") < words.index("MVS")


def test_a_draft_in_rapid(tmp_path: Path) -> None:
    found = translated(tmp_path, PROGRAM, "rapid", draft=True, language="melfa-basic-5")
    assert found.draft
    (data,) = found.files.values()
    lines = [line.strip() for line in data.decode().splitlines()]
    at = lines.index("! | 4 Torq 2,50")
    assert lines[at - 2 : at] == ["Stop;", "! not translated, line 4:"]
    assert lines[lines.index('! | 7 XRun 2,"OTHER"') - 2] == "Stop;"


def test_a_draft_of_what_can_be_said_is_the_program(tmp_path: Path) -> None:
    text = PROGRAM.replace("4 Torq 2,50\n", "").replace('7 XRun 2,"OTHER"\n', "")
    whole = translated(tmp_path, text, "rapid", language="melfa-basic-5")
    drafted = translated(tmp_path, text, "rapid", language="melfa-basic-5", draft=True)
    assert whole.ok
    assert whole.files == drafted.files
    assert not drafted.draft


def test_what_is_missed_after_something_was_left_out_is_left_out_too(tmp_path: Path) -> None:
    """The array cannot be said, so that what reads it cannot either."""
    text = MODULE.replace("VAR num n;", "VAR num n;\n    VAR num far{2,2,2,2};")
    text = text.replace("EGMReset path;", "n:=far{1,1,1,1};")
    found = translated(tmp_path, text, "melfa-basic-5", draft=True)
    assert found.proof.holds or not found.files


words = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=40)


@settings(max_examples=drawn(25), deadline=None)
@given(words)
def test_what_is_quoted_never_becomes_code(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    folder = tmp_path_factory.mktemp("draft")
    quoted = (
        text.replace("\\", "\\\\").replace('"', '""').encode("latin-1", "ignore").decode("latin-1")
    )
    module = MODULE.replace("EGMReset path;", f'Open "{quoted}",file;')
    found = translated(folder, module, "melfa-basic-5", draft=True)
    plain = translated(
        folder,
        MODULE.replace("EGMReset path;", "EGMStop path,EGM_STOP_HOLD;"),
        "melfa-basic-5",
        draft=True,
    )
    if found.files:
        assert code(found) == code(plain)


def code(translation: Translation) -> list[str]:
    """The lines of a program without comments and step numbers."""
    (data,) = translation.files.values()
    text = languages.get("melfa-basic-5").decode(data).text
    lines = [line.lstrip("0123456789 ") for line in re.split("\r?\n", text)]
    return [line for line in lines if not line.startswith("'")]


@pytest.mark.parametrize("call", ['CallP "SUB"', 'If M1>0 Then CallP "SUB"'])
def test_files_that_are_called_are_reported_in_their_place(tmp_path: Path, call: str) -> None:
    (tmp_path / "SUB.prg").write_text("1 Dly 1\n2 Dly 1\n3 Dly 1\n4 Torq 2,50\n5 End\n")
    (tmp_path / "MAIN.prg").write_text(f"1 Dly 2\n2 {call}\n3 End\n")
    found = translate(tmp_path / "MAIN.prg", to="rapid", language="melfa-basic-5")
    places = {(Path(r.place.path or "").name, r.place.line): r.level for r in found.rows}
    assert places["SUB.prg", 4] == "not"
    assert places["MAIN.prg", 1] == places["SUB.prg", 3] == "supported"


def test_signals_tools_and_frames_of_the_other_cell(tmp_path: Path) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text(
        '[signals.DO1]\nnumber = 7\n[signals.ready]\ndirection = "input"\nnumber = 3\n'
        "[tools.Torch]\ntip = [0, 0, 123]\n"
    )
    text = MODULE.replace("IF n>3", "IF ready=1")
    found = translated(tmp_path, text, "melfa-basic-5", process=process, draft=True)
    assert levels(found)[13] == "supported"
    (data,) = found.files.values()
    assert "M_Out(7)=1" in data.decode()
    assert "M_In(3)=1" in data.decode()
    assert "+123.00" in data.decode()


def test_a_tool_that_the_program_does_not_have_is_said(tmp_path: Path) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text("[tools.torsh]\ntip = [0, 0, 123]\n")
    found = translated(tmp_path, MODULE, "melfa-basic-5", process=process)
    assert "CO006" in {f.code for f in found.whole}


def test_what_a_process_file_says_of_drawings_is_told(tmp_path: Path) -> None:
    process = tmp_path / "cell.process.toml"
    process.write_text('robot = "rv-4frl"\ntolerance = 0.2\njoint_speed = 100\n')
    found = translated(tmp_path, MODULE, "melfa-basic-5", process=process)
    (told,) = [f.message for f in found.whole if f.code == "CO009"]
    assert "`robot`" in told and "`tolerance`" in told and "joint" not in told


def test_a_drawing_is_no_program_to_translate() -> None:
    with pytest.raises(Refused) as refused:
        translate(Path(__file__).parents[2] / "samples" / "plate.dxf", to="rapid")
    assert refused.value.findings[0].code == "CO005"
    assert refused.value.exit_status == 2


DATA = """MODULE Settings_of_cell
    ! What all programs of the cell share.
    CONST num nMost:=12;
    CONST string stName:="cell";
    VAR pose frZero:=[[0,0,0],[1,0,0,0]];
    VAR pose frTable:=[[310,-20.5,45],[0.7071068,0,0,0.7071068]];
    CONST num nLayers{3}:=[4,5,6];
ENDMODULE
"""


@pytest.mark.parametrize("to", MELFA)
def test_a_module_of_data_alone_keeps_its_name_comments_and_values(tmp_path: Path, to: str) -> None:
    found = translated(tmp_path, DATA, to)
    assert found.ok, found.findings
    proven = found.proof.lifted
    assert proven is not None
    assert proven.name == "Settings_of_cell"
    assert proven.comments == ("What all programs of the cell share.",)
    assert proven.variables["nMost"].initial == e.Number(12)
    assert proven.variables["stName"].initial == e.Text("cell")
    pose = proven.variables["frTable"].initial
    assert isinstance(pose, e.PoseValue)
    assert pose.pose.position == pytest.approx((310, -20.5, 45))
    (main,) = proven.procedures  # it gives the array its values
    assert [s.value for s in main.body if isinstance(s, p.Assign)] == [
        e.Number(4),
        e.Number(5),
        e.Number(6),
    ]


@pytest.mark.parametrize("to", MELFA)
def test_elements_of_arrays_of_a_procedures_own(tmp_path: Path, to: str) -> None:
    body = """        VAR string stLine{2};
        VAR num nCount{2,3};
        stLine{1}:="first";
        nCount{2,n}:=n+1;
"""
    text = MODULE[: MODULE.index("        MoveJ")] + body + "    ENDPROC\nENDMODULE\n"
    found = translated(tmp_path, text.replace("    VAR egmident path;\n", ""), to)
    assert found.ok, found.findings


def test_a_draft_leaves_out_first_values_that_cannot_be_said(tmp_path: Path) -> None:
    text = MODULE.replace("VAR num n;", 'VAR num n:=nElsewhere;\n    CONST string st:="a\tb";')
    text = text.replace("PROC main()\n", "PROC main()\n        VAR num nOwn:=nElsewhere;\n")
    found = translated(tmp_path, text, "melfa-basic-5", draft=True)
    assert found.draft, found.written.findings
    shown = {row.text.partition(":=")[0]: row.level for row in found.rows}
    assert shown["VAR num n"] == "not"
    (written,) = found.files.values()
    assert b"not translated, line 5:" in written


def test_a_comparison_of_positions_is_said_by_components(tmp_path: Path) -> None:
    text = MODULE.replace("IF n>3 THEN", "IF p10=p20 THEN")
    text = text.replace("    VAR num n;", "    VAR robtarget p20;\n    VAR num n;")
    found = translated(tmp_path, text, "melfa-basic-5", draft=True)
    (row,) = [r for r in found.rows if r.text.startswith("IF p10")]
    assert [f.code for f in row.reasons] == ["RA349", "CO127"]


@pytest.mark.parametrize("to", MELFA)
def test_a_line_that_is_too_long_has_its_place(tmp_path: Path, to: str) -> None:
    long = "+".join(f"n*{k}000" for k in range(1, 60))
    text = MODULE.replace("IF n>3", f"IF {long}>3").replace("    VAR egmident path;\n", "")
    text = text.replace("        EGMReset path;\n", "").replace("GetMotorTorque(2)", "1")
    found = translated(tmp_path, text, to, draft=True)
    assert found.draft, found.written.findings
    (row,) = [row for row in found.rows if row.text.startswith("IF n*1000")]
    assert row.level == "not"
    assert [f.code for f in row.reasons] == ["MB107"]


AXES = (
    "MODULE m\nCONST robtarget p:={};\nPROC main()\nMoveL p,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
)
PLACE = "[[350,0,400],[0,0,1,0],[0,0,0,0],[{},9E9,9E9,9E9]]"


@pytest.mark.parametrize("axes", ["9E9,9E9,5", "9E9,5,9E9"])
def test_a_declaration_that_is_left_out_is_the_reason_for_what_needs_it(
    tmp_path: Path, axes: str
) -> None:
    for draft in (False, True):
        found = translated(tmp_path, AXES.format(PLACE.format(axes)), "melfa-basic-5", draft=draft)
        about = {row.place.line: [r.code for r in row.reasons] for row in found.rows}
        assert about == {2: ["MB209"], 3: [], 4: ["CO007"]}
        assert found.draft == draft


@pytest.mark.parametrize("axes", ["9E9,9E9,5", "9E9,5,9E9"])
def test_external_axes_that_cannot_be_said_are_told_of_where_they_stand(
    tmp_path: Path, axes: str
) -> None:
    place = PLACE.format(axes)
    for data, move in ((f"VAR robtarget p:={place};", "p"), ("", place)):
        text = f"MODULE m\n{data}\nPROC main()\nMoveL {move},v100,fine,tool0;\nENDPROC\nENDMODULE\n"
        found = translated(tmp_path, text, "melfa-basic-5", draft=True)
        assert found.draft, found.written.findings
        lines = [line for line, level in levels(found).items() if level == "not"]
        assert lines == ([2, 4] if data else [4])  # without its value it is another place


def test_names_that_nothing_declares_are_told_of_as_such(tmp_path: Path) -> None:
    text = MODULE.replace("n:=n+GetMotorTorque(2)", "n:=nowhere")
    found = translated(tmp_path, text, "melfa-basic-5", draft=True)
    (row,) = (row for row in found.rows if row.text == "n:=nowhere")
    assert [r.code for r in row.reasons] == ["MB229"]


@pytest.mark.parametrize(
    "declared",
    ['VAR string t:="a ""b""";', 'CONST string t:="a ""b""";', 'PERS string t:="a ""b""";'],
)
def test_a_text_that_changes_is_told_of_at_its_declaration(tmp_path: Path, declared: str) -> None:
    text = f"MODULE m\n{declared}\nPROC main()\nTPWrite t;\nENDPROC\nENDMODULE\n"
    found = translated(tmp_path, text, "melfa-basic-5")
    (row,) = (row for row in found.rows if row.place.line == 2)
    assert "MB226" in [r.code for r in row.reasons]


def test_an_external_name_that_is_too_long_is_told_of(tmp_path: Path) -> None:
    text = "MODULE m\nPERS num M_LONGNAME9;\nPROC main()\nM_LONGNAME9:=1;\nENDPROC\nENDMODULE\n"
    assert translated(tmp_path, text, "melfa-basic-5").ok
    found = translated(tmp_path, text, "melfa-basic-4")
    assert [r.code for r in found.rows[0].reasons] == ["MB106"]
