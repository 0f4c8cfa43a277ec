"""From one dialect of MELFA-BASIC to another: what each construct becomes, and back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.languages.melfa_basic.convert.conversion import Converted, convert
from assistant.languages.melfa_basic.tree import syntax as s
from tests.tables import every_row

IV, V, VI = "melfa-basic-4", "melfa-basic-5", "melfa-basic-6"


def read(text: str, dialect: str) -> s.File:
    tree = languages.get(dialect).parse(SourceText(text, "WORK.prg", newline="\n"))
    assert not tree.findings
    return tree


def converted(text: str, dialect: str, to: str) -> Converted:
    return convert([read(text, dialect)], to)


def said(text: str, dialect: str, to: str) -> list[str]:
    """The converted lines without step numbers and layout, those of the heading left out."""
    result = converted(text, dialect, to)
    assert not [f for f in result.findings if f.severity is Severity.ERROR], result.findings
    lines = [line.strip() for line in languages.get(to).render(result.trees[0]).splitlines()]
    code = [line.split(" ", 1)[1].strip() if line[:1].isdigit() else line for line in lines]
    end = "' robot-assistant: end"
    return code[code.index(end) + 1 :] if end in code else code


def errors(text: str, dialect: str, to: str) -> list[str]:
    result = converted(text, dialect, to)
    assert not result.trees
    return [f.message for f in result.findings if f.severity is Severity.ERROR]


CASES = {
    "words and names": (
        "Mov pHome Wth M_Out(5)=1\nDly 0.5\n",
        ["MOV PHOME WTH M_OUT(5)=1", "DLY 0.5"],
    ),
    "comments and blank lines": (
        "' head\nMov P1 ' first\n\nRem next\nHlt\n",
        ["' head", "MOV P1 ' first", "", "Rem next", "HLT"],
    ),
    "a label before a statement": (
        "*Again:M1=M1+1\nGoTo *Again\n",
        ["*AGAIN", "M1=M1+1", "GOTO *AGAIN"],
    ),
    "a short block": ("If M1>0 Then\nM2=1\nElse\nM2=2\nEndIf\n", ["IF M1>0 THEN M2=1 ELSE M2=2"]),
    "a block": (
        "If M1>0 Then ' one\nMov P1\nMov P2\nElseIf M1<0 Then\nHlt\nElse\nEnd\nEndIf\n",
        [
            "IF M1>0 THEN *I1T1 ELSE *I1N1 ' one", "*I1T1", "MOV P1", "MOV P2", "GOTO *I1Z",
            "*I1N1", "IF M1<0 THEN *I1T2 ELSE *I1N2", "*I1T2", "HLT", "GOTO *I1Z",
            "*I1N2", "END", "*I1Z",
        ],
    ),
    "a wait for any condition": (
        "Wait M_In(5)<>0\nWait M_In(6)=1\n",
        ["*W1", "IF M_IN(5)<>0 THEN *W1Z ELSE *W1", "*W1Z", "WAIT M_IN(6)=1"],
    ),
    "leaving a loop": (
        "For M1=1 To 9\nIf M2=1 Then Break\nM2=M2+1\nNext M1\n",
        ["FOR M1=1 TO 9", "IF M2=1 THEN GOTO *B1Z", "M2=M2+1", "NEXT M1", "*B1Z"],
    ),
    "a selection in a selection": (
        "Select M1\nCase 1\nSelect M2\nCase 2 To 3\nM3=1\nDefault\nM3=2\nEnd Select\nEnd Select\n",
        [
            "SELECT M1", "CASE 1", "IF M2>=2 AND M2<=3 THEN *S1C1", "GOTO *S1C2",
            "*S1C1", "M3=1", "GOTO *S1Z", "*S1C2", "M3=2", "GOTO *S1Z", "*S1Z", "END SELECT",
        ],
    ),
    "groups of signals": ("M_Out8(16)=M_In16(32)\n", ["M_OUTB(16)=M_INW(32)"]),
    "type marks": (
        "Count%=1\nCName$=\"a\"\nHlt\n",
        ["DEF INTE COUNT", "COUNT=1", 'CNAME$="a"', "HLT"],
    ),
    "constants": ("Const LIMIT=11\nM1=LIMIT\n", ["LIMIT=11", "M1=LIMIT"]),
    "whole numbers of 32 bits": ("Def Long MBIG\nMBIG=1\n", ["DEF DOUBLE MBIG", "MBIG=1"]),
    "32 signals": ("Def Io PORT=DWord,64\nPORT=1\n", ["DEF IO PORT=INTEGER,64", "PORT=1"]),
    "the tool of the flange": ("Tool 0\nBase 0\n", ["TOOL P_NTOOL", "BASE P_NBASE"]),
    "long names": (
        "MLongCounter=1\nGoSub *Long_Subroutine\nEnd\n*Long_Subroutine\nMLongCountess=2\nReturn\n",
        [
            "MLONGCOU=1", "GOSUB *LONGSUBR", "END", "*LONGSUBR", "MLONGCO2=2", "RETURN",
        ],
    ),
}  # fmt: skip


@every_row("case", list(CASES))
def test_the_first_dialect_says_it(case: str) -> None:
    text, expected = CASES[case]
    assert said(text, V, IV) == expected


KEPT = {
    "comments and blank lines": [],
    "a block": [], "a wait for any condition": [], "leaving a loop": [],
    "a selection in a selection": [], "groups of signals": [], "constants": [],
    "whole numbers of 32 bits": [], "32 signals": [], "long names": [],
}  # fmt: skip


@every_row("case", list(KEPT))
def test_it_comes_back_as_it_was(case: str) -> None:
    text, _ = CASES[case]
    there = converted(text, V, IV)
    back = convert(there.trees, V)
    lines = languages.get(V).render(back.trees[0]).splitlines()
    code = [line.split(" ", 1)[1].strip() if line[:1].isdigit() else line for line in lines]
    assert code == text.splitlines()


def test_steps_become_labels_and_steps_again() -> None:
    text = "10 M1=0\n20 M1=M1+1\n30 IF M1<5 THEN 20\n40 GOSUB *SUB\n50 END\n60 *SUB\n70 RETURN\n"
    assert said(text, IV, V) == [
        "M1=0", "*L20", "M1=M1+1", "If M1<5 Then *L20", "GoSub *SUB", "End", "*SUB", "Return",
    ]  # fmt: skip
    back = convert(converted(text, IV, V).trees, IV)
    assert languages.get(IV).render(back.trees[0]) == text


def test_the_numbers_are_those_of_the_dialect() -> None:
    tree = converted("Mov P1\nHlt\n", V, IV).trees[0]
    assert [i.number for i in tree.items if isinstance(i, s.Line)] == [10, 20]
    tree = converted("10 MOV P1\n30 HLT\n", IV, V).trees[0]
    assert [i.number for i in tree.items if isinstance(i, s.Line)] == [1, 2]


def test_jumps_that_are_no_block_stay() -> None:
    text = "10 IF M1=1 THEN *I1T1 ELSE *I1N1\n20 *I1T1\n30 M2=1\n40 GOTO *I1Z\n50 *I1N1\n60 *I1Z\n"
    assert said(text, IV, V) == ["If M1=1 Then", "M2=1", "EndIf"]
    from_outside = text + "70 GOTO *I1T1\n"
    assert "*I1T1" in said(from_outside, IV, V)
    crossing = text.replace("30 M2=1", "30 FOR M2=1 TO 3") + "70 NEXT M2\n"
    assert "*I1T1" in said(crossing, IV, V)


def test_a_higher_dialect_takes_the_text_as_it_is() -> None:
    text = "1 mov p1   ' slow\n2 If m1 = 1 Then Break\n\n"
    (tree,) = converted(text, V, VI).trees
    assert languages.get(VI).render(tree) == text


UNSAYABLE = {
    "Fine 0.5,P": "`Fine 0.5,P`, in mm or degrees",
    "Tool 3": "`Tool 3`, a number",
    "Mov P1 Type 0,2": "`Type …,2`",
    "M1=ASin(0.5)": "`ASin`",
    "M1=M_In32(0)": "`M_In32`",
    "Fsc On,1,1,1": "`Fsc`",
    "*A\nConst X=1": "`Const` behind a jump or label",
    "Break": "`Break` outside of every block",
    "For M1=1 To 2\nFor M2=1 To 2\nBreak\nNext M2,M1": "whose `Next` ends several loops",
    "Dim MFIELD%(3)\nMFIELD%(1)=1": "the array `MFIELD%`",
    "MX$=\"a\"\nMX%=1\nHlt": "both",
    'Print #1,"' + "a" * 130 + '"': "a line of",
}  # fmt: skip


@every_row("text", list(UNSAYABLE))
def test_what_the_first_dialect_lacks_is_an_error(text: str) -> None:
    found = errors(text + "\n", V, IV)
    assert any(UNSAYABLE[text] in message for message in found), found


def test_groups_of_signals_of_a_kept_move_have_their_new_names(tmp_path: Path) -> None:
    file = tmp_path / "WORK.prg"
    file.write_text("1 Mov P_Base WthIf M_In(1)=1,M_Outb(8)=M_Inw(0)\n2 End\n", encoding="ascii")
    made = assistant.translate(file, to=V, language=VI)
    assert b",M_Out8(8)=M_In16(0)" in made.files["WORK.prg"]


def test_an_error_names_the_line() -> None:
    (finding,) = converted("Mov P1\nFine 0.5,P\n", V, IV).findings
    assert (finding.path, finding.line, finding.code) == ("WORK.prg", 2, "MB501")
    assert "Fine 100" in finding.cure


def test_long_comments_are_kept_on_lines_of_their_own() -> None:
    words = " ".join(["word"] * 40)
    lines = said(f"Mov P1 ' {words}\n", V, IV)
    assert lines[-1] == "MOV P1"
    assert " ".join(line.removeprefix("' ") for line in lines[:-1]) == words
    assert max(map(len, lines)) < 127


def test_files_that_call_each_other_share_their_names() -> None:
    main = read('M_SharedNumber=1\nCallP "PART"\nEnd\n', V)
    part = read("M_SharedNumbers=1\nM_SharedNumber=2\nEnd\n", V)
    first, second = convert([main, part], IV).trees
    texts = [languages.get(IV).render(t) for t in (first, second)]
    assert "M_SHARED=1" in texts[0]
    assert "M_SHARED=2" in texts[1]
    assert "M_SHARE2=1" in texts[1]


def test_compiling_goes_over_the_trees() -> None:
    text = "Mov P1 ' there\nIf M_In8(8)>3 Then\nHlt\nEndIf\n"
    text += "P1=(+1.00,+2.00,+3.00,+0.00,+90.00,+0.00)(7,0)\n"
    loaded = load_text(SourceText(text, "WORK.prg"), language=V)
    compiled = assistant.compile(loaded.program, language=IV)
    assert compiled.ok
    assert compiled.files["WORK.prg"].decode().splitlines() == [
        "10 MOV P1 ' there", "20 IF M_INB(8)>3 THEN HLT",
        "P1=(+1.00,+2.00,+3.00,+0.00,+90.00,+0.00)(7,0)",
    ]  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_what_is_written_is_proven(case: str) -> None:
    text, _ = CASES[case]
    data = "".join(f"P{n}=(+1.00,+2.00,+3.00,+0.00,+90.00,+0.00)(7,0)\n" for n in (1, 2))
    data += "PHOME=(+4.00,+2.00,+3.00,+0.00,+90.00,+0.00)(7,0)\n"
    loaded = load_text(SourceText(text + data, "WORK.prg"), language=V)
    compiled = assistant.compile(loaded.program, language=IV)
    assert compiled.ok, compiled.findings


def test_what_is_wrong_in_the_source_is_said_of_it() -> None:
    loaded = load_text(SourceText("Mov P1\nFine 0.5,P\n", "WORK.prg"), language=V)
    compiled = assistant.compile(loaded.program, language=IV)
    assert not compiled.files
    assert "MB501" in {f.code for f in compiled.findings}


def test_a_written_program_keeps_its_names(tmp_path: Path) -> None:
    source = tmp_path / "seam.pseudo"
    source.write_text(
        "program my_long_program\n\n"
        "target the_parking_position [400, 0, 500] [1, 0, 0, 0]\n\n"
        "procedure main\n"
        "  move joint the_parking_position speed 100 mm/s joint 10 % blend fine\n"
        "end\n"
    )
    later = assistant.compile(source, language=V)
    assert later.ok
    ((name, data),) = later.files.items()
    loaded = load_text(SourceText(data.decode(), name), language=V)
    earlier = assistant.compile(loaded.program, language=IV)
    assert earlier.ok
    ((name, data),) = earlier.files.items()
    back = load_text(SourceText(data.decode(), name), language=IV).program
    assert list(back.targets) == ["the_parking_position"]
    assert back.name == "my_long_program"


def test_programs_that_call_each_other_are_compiled_together(tmp_path: Path) -> None:
    (tmp_path / "MAIN.prg").write_text('Mov P1\nCallP "PART"\nEnd\nP1=(+1,+2,+3,+0,+0,+0)(7,0)\n')
    (tmp_path / "PART.prg").write_text("*Loop:Dly 0.5\nIf M_In(5)<>0 Then GoTo *Loop\nEnd\n")
    compiled = assistant.compile(tmp_path / "MAIN.prg", language=IV)
    assert compiled.ok, compiled.findings
    assert {name: data.decode().splitlines() for name, data in compiled.files.items()} == {
        "MAIN.prg": [
            "10 MOV P1",
            '20 CALLP "PART"',
            "30 END",
            "P1=(+1.00,+2.00,+3.00,+0.00,+0.00,+0.00)(7,0)",
        ],
        "PART.prg": ["10 *LOOP", "20 DLY 0.5", "30 IF M_IN(5)<>0 THEN GOTO *LOOP", "40 END"],
    }


def test_functions_go_through_the_pseudo_program() -> None:
    text = "Function Main\nM1=Twice(3)\nFEnd\nFunction M Twice(ByVal A)\nTwice=A*2\nFEnd\n"
    for dialect in (IV, V):
        loaded = load_text(SourceText(text, "WORK.prg"), language=VI)
        compiled = assistant.compile(loaded.program, language=dialect)
        assert compiled.ok, compiled.findings
        assert "GOSUB *TWICE" in compiled.files["WORK.prg"].decode().upper()


def test_another_robot_goes_through_the_pseudo_program() -> None:
    text = "10 MOV P1\n20 END\nP1=(+300.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"
    loaded = load_text(SourceText(text, "WORK.prg"), language=IV)
    compiled = assistant.compile(loaded.program, language=VI, robot="rv-4frl", from_robot="rv-7frl")
    assert compiled.ok, compiled.findings
    assert "robot: rv-4frl" in compiled.files["WORK.prg"].decode()


def test_the_robot_that_a_program_leaves_open_sets_nothing_in_it() -> None:
    text = "1 Mov P1\n2 End\nP1=(+300.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"
    loaded = load_text(SourceText(text, "WORK.prg"), language=V)
    translation = assistant.translate(loaded, to=IV, robot="rv-4frl")
    assert translation.ok, translation.findings
    written = translation.files["WORK.prg"].decode()
    assert not {"TOOL", "BASE", "SPD", "JOVRD", "CNT"} & set(written.split())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Servo On", "SERVO ON"),
        ("M_Timer(1)=M_In8(16)", "M_TIMER(1)=M_INB(16)"),
        ("Cmp Off", "CMP OFF"),
    ],
)
def test_what_the_pseudo_program_lacks_is_said_between_dialects(text: str, said: str) -> None:
    source = f"Function Main\n{text}\nFEnd\n"
    loaded = load_text(SourceText(source, "WORK.prg"), language=VI)
    compiled = assistant.compile(loaded.program, language=IV)
    assert compiled.ok, compiled.findings
    assert said in compiled.files["WORK.prg"].decode()


@pytest.mark.parametrize("text", ["Fine 0.5,P", "M1=M_In32(0)", "Fsc On,1,1,1"])
def test_what_a_dialect_lacks_is_refused_on_that_way_too(text: str) -> None:
    source = f"Function Main\n{text}\nFEnd\n"
    loaded = load_text(SourceText(source, "WORK.prg"), language=VI)
    compiled = assistant.compile(loaded.program, language=IV)
    assert not compiled.files
    assert "MB209" in {f.code for f in compiled.findings}


def test_blocks_far_too_deep_are_refused() -> None:
    deep = [f"For M{n}=1 To 2" for n in range(1200)] + ["Next"] * 1200
    assert any("too deep" in message for message in errors("\n".join(deep) + "\nEnd\n", VI, IV))


POINT = "P1=(+300.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"


def translated(code: str, to: str, from_robot: str | None = None) -> tuple[str, list[str]]:
    """What a program of MELFA-BASIC V becomes, and `code line` of what is found about it."""
    loaded = load_text(SourceText(code + POINT, "WORK.prg"), language=V)
    robot = None if from_robot is None else "rv-4frl"
    made = assistant.translate(loaded, to=to, robot=robot, from_robot=from_robot)
    found = [f"{f.code} {f.line}" for f in made.findings if f.severity != Severity.INFO]
    return "".join(data.decode() for data in made.files.values()), found


@pytest.mark.parametrize(
    ("code", "to", "has", "found"),
    [
        (
            "1 Mov P1\n2 Tool (0,0,9,0,0,0)\n3 Mvs P1\n4 Base P_NBase\n5 End\n",
            "rapid",
            "tool0",
            ["MB233 1", "MB233 1", "MB294 3", "RA302 None"],
        ),
        ("1 Mov P1\n2 End\n", "rapid", "tool0", ["MB233 1", "MB233 1"]),
        ("1 Mov P1\n2 End\n", IV, "TOOL P_NTOOL", ["MB233 1", "MB233 1"]),
        ("1 Tool P_NTool\n2 Base P_NBase\n3 Mov P1\n", IV, "TOOL P_NTOOL", []),
        ("1 M_Outb(8)=300\n2 M_Out16(32)=-1\n", "rapid", "_8,44;", []),
        ("1 M_Out16(32)=-1\n2 End\n", "rapid", "_32,65535;", []),
        ("1 M4=3\n2 For M3=1 To M4\n3 M4=M4-1\n4 Next\n", "rapid", "FOR M3", ["MB234 2"]),
        (
            "1 Dim M1(3)\n2 M1(1)=3\n3 M5=1\n4 For M3=1 To M1(1)\n5 M1(M5)=2\n6 Next\n",
            "rapid",
            "FOR M3",
            ["MB234 4"],
        ),
        (
            "1 Dim M1(3)\n2 M4=3\n3 For M3=1 To M4\n4 M1(M4)=M3\n5 Next\n",
            "rapid",
            "FOR M3",
            [],
        ),
        (
            "1 M4=3\n2 For M3=1 To M4\n3 M6=Less(M4)\n4 Next\n5 End\n"
            "Function M Less(ByRef M1)\nM1=M1-1\nLess=M1\nFEnd\n",
            "rapid",
            "FOR M3",
            ["MB234 2"],
        ),
        ("1 M4=3\n2 For M3=1 To M4\n3 M5=M4-1\n4 Next\n", "rapid", "FOR M3", []),
        ("1 M4=3\n2 For M3=1 To M4\n3 M3=M3+1\n4 Next\n", "rapid", "WHILE M3<=M4", []),
        ("1 Cnt 1,0,0\n2 End\n", "rapid", "main", ["MB235 1"]),
        ("1 M1=3\n2 M2=(M1=2)+M1 And 7\n", IV, "M2=(M1=2)+M1 AND 7", []),
        ("1 M1=3\n2 M2=M1\n3 M3=M1 And M2\n", IV, "M3=M1 AND M2", []),
        ("1 M1=2\n2 M2=2^M1^3\n", "rapid", "Pow(Pow(2,M1),3)", []),
        ("1 M1=2\n2 M2=2-(-M1)\n", IV, "M2=2-(-M1)", []),
        ("1 M1=2\n2 M2=2-(-M1)\n", "rapid", "M2:=2-(-M1)", []),
    ],
)
def test_what_was_meant_stays_or_is_told(code: str, to: str, has: str, found: list[str]) -> None:
    written, told = translated(code, to, "rv-7frl" if to == IV else None)
    assert has in written
    known = ("CO003", "RA306", "MB204")  # of the robot and of joint speeds
    assert [f for f in told if not f.startswith(known)] == found


def test_a_case_of_a_function_is_worked_out_in_front_of_its_select(tmp_path: Path) -> None:
    source = tmp_path / "NESTED.prg"
    inner = "Select FNHALF(M1)\nCase 0 To 4\nHlt\nEnd Select\n"
    source.write_text(f"Def FNHALF(MA)=MA/2\nSelect M1\nCase M2\n{inner}End Select\nEnd\n")
    done = assistant.translate(source, to="melfa-basic-4")
    assert [(f.code, f.line) for f in done.findings] == [("MB501", 4)]
    assert [(row.place.line, row.level) for row in done.rows][2] == (4, "not")


KEPT = "3 Mvs P1 WthIf M_In(3)=1,M_Out(3)=1\n"


@pytest.mark.parametrize(
    ("code", "lines"),
    [
        (f"1 Mvs P1\n{KEPT}4 Mvs P1\n5 End\n", []),
        (f"1 Spd 9\n2 Mvs P1\n{KEPT}4 End\n", ["Spd 9"]),
        (f"1 Spd 9\n2 While M_In(1)=1\n{KEPT}4 Mvs P1\n5 WEnd\n6 End\n", ["Spd 9"]),
        (f"1 Spd 9\n2 Mvs P1\n{KEPT}4 Spd 8\n5 Mvs P1\n6 End\n", ["Spd 9", "Spd 8"]),
        ("1 Mvs P1\n2 Mvc P1,P_Curr,P1\n3 GoSub *S\n4 End\n5 *S\n6 Mvs P1\n7 Return\n", []),
        ("1 Mvs P1\n2 End\n", ["Tool P_NTool", "Base P_NBase", "Spd M_NSpd", "Cnt 0"]),
    ],
)
def test_settings_that_texts_depend_on_are_said_once(code: str, lines: list[str]) -> None:
    written, told = translated(code, V)
    words = ("Spd", "Cnt", "Tool", "Base")
    steps = (line.split(" ", 1)[1].strip() for line in written.splitlines() if " " in line)
    assert [step for step in steps if step.startswith(words)] == lines
    assert [code.split()[0] for code in told] == ["MB233", "MB233"]


def test_a_move_that_is_said_to_have_no_tool_is_written_with_none() -> None:
    """Also beside a text that depends on it: what is not read from a controller has no other."""
    language = languages.get(V)
    read = language.lift([language.parse("1 Mvs P1\n" + KEPT + "4 End\n" + POINT)])
    written = {
        tool: language.render(language.build(language.adapt(program).program))
        for tool, program in (("kept", read), ("none", replace(read, origin=None)))
    }
    assert "Tool P_NTool" in written["none"]
    assert "Tool" not in written["kept"]
