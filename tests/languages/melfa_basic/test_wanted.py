"""What programs of MELFA-BASIC use without a value, and a cell's values in their position lists."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.cell_defaults import cell_text, neutral_cell
from assistant.compiler.loader import load
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import translate
from assistant.program.geometry import Frame, Pose, Target
from assistant.program.undeclared_names import Wanted
from assistant.sources.cell_values import read_cell
from tests.tables import every_row

FIVE = languages.get("melfa-basic-5")
PLACES = "P1=(400,0,400,180,0,180)(7,0)\n"


def wanted(text: str) -> list[Wanted]:
    return list(FIVE.wanted([FIVE.parse(SourceText(text, "JOB.prg"))]))


@every_row(
    ("text", "found"),
    [
        ("Mvs P1\nMvs P2\n" + PLACES, [("P2", "position")]),
        ("Mov Home\nMov PHome\n" + PLACES, [("Home", "data"), ("PHome", "position")]),
        ("Mov J1\n", [("J1", "joints")]),
        ("P2=P1\nMvs P2\nM1=1\nDly M1\nDly Wait1\n" + PLACES, [("Wait1", "data")]),
        ("P2.Z=5\nMvs P2\nP1.X=3\nMvs P1\n" + PLACES, [("P2", "position")]),
        ("Mvs P2\nP2=(0,0,0,0,0,0)(,)\n", [("P2", "position")]),
        ("Def Pos Place\nMvs Place\n", [("Place", "position")]),
        ("Def Char Name\nCallP Name\n", [("Name", "data")]),
        ("FPrm P2,M1\nMvs P2\nDly M1\n", []),
        ("Dim P2(3)\nMvs P2(1)\nFor M1=1 To 2\nNext\nMvs P_Curr\n", []),
        ("Mvs P_01\n", [("P_01", "position")]),
        ("M_01=1\nDly M_01\nP_01=P_Curr\nMvs P_01\n", []),
        ("Dly M_01\nM_01=1\n", [("M_01", "data")]),
        ("Tool 2\nBase 1\nBase 1\nTool 0\n", [("MEXTL2", "tool"), ("WK1CORD", "frame")]),
    ],
)  # fmt: skip
def test_names_without_a_value(text: str, found: list[tuple[str, str]]) -> None:
    assert sorted((one.name, one.kind) for one in wanted(text)) == sorted(found)


def test_uses_are_told() -> None:
    (one,) = wanted("Mvs P2\nM1=1\nIf M1=1 Then Mvs P2\n")
    assert one.uses == ("JOB:1", "JOB:3")


def test_values_stand_in_the_list_of_positions() -> None:
    tree = FIVE.parse(SourceText("1 Mvs P1\n2 Mvs P2\nP2=(0,0,0,0,0,0)(,)\n", "JOB.prg"))
    place = Target(Pose((1, 2, 3.5), (0.0, 0.0, 1.0, 0.0)))
    given = [(one, place) for one in FIVE.wanted([tree])]
    (made,) = FIVE.with_supplied([tree], given, "cell")
    text = FIVE.render(made)
    assert text.startswith("1 Mvs P1\n2 Mvs P2\nP2=(1,2,3.5,")
    assert text.splitlines()[-1].startswith("P1=(1,2,3.5,")
    assert FIVE.wanted([made]) == ()


def test_programs_of_one_job_have_their_own(tmp_path: Path) -> None:
    (tmp_path / "MAIN.prg").write_text('1 Mvs P1\n2 CallP "SUB"\n3 End\n')
    (tmp_path / "SUB.prg").write_text("1 Mvs P1\n2 End\n")
    loaded = load(tmp_path / "MAIN.prg", language="melfa-basic-5")
    cell = tmp_path / "cell.toml"
    text = neutral_cell(loaded)
    assert "[positions.P1]" in text
    assert "[positions.SUB_P1]" in text
    cell.write_text(text.replace("400, 0, 400", "400, 0, 300", 1))
    found = translate(loaded, to="rapid", cell=cell, proving=Proving())
    assert found.ok, found.findings
    written = "".join(data.decode() for data in found.files.values())
    assert "[[400,0,300]" in written
    assert "[[400,0,400]" in written


def test_work_coordinates_are_seen_from_the_robot(tmp_path: Path) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    source.write_text("Base 1\nMvs P1\nBase 0\nTool 1\nMov P1\nEnd\n" + PLACES)
    cell.write_text(
        "joint_speed = 100\n[frames.WK1CORD]\nposition=[50,20,-100]\neuler_zyx=[30,0,0]\n"
        "[tools.MEXTL1]\ntip=[0,0,120]\n"
    )
    found = translate(source, to="rapid", language="melfa-basic-5", cell=cell, proving=Proving())
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds
    frame = found.compiled.source.frames["WK1CORD"]
    assert isinstance(frame, Frame)
    assert frame.user.position == (50, 20, -100)
    assert "WK1CORD" in next(iter(found.files.values())).decode()


def test_numbers_that_nobody_sets(tmp_path: Path) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    source.write_text("Dly MPause\nMov P1\nMvs P1,-Above\nEnd\n" + PLACES)
    text = neutral_cell(load(source, language="melfa-basic-5"))
    assert "joint_speed = 100" in text
    cell.write_text(text.replace("value = 0", "value = 20"))
    found = translate(source, to="rapid", language="melfa-basic-5", cell=cell, proving=Proving())
    assert found.ok, found.findings
    assert "20" in next(iter(found.files.values())).decode()


def test_slow_joint_moves_and_lines_of_communication(tmp_path: Path) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    opened = 'Open "COM2:" As #1\nJOvrd 50\nMov P1\nPrint #1,"DONE"\nClose #1\nEnd\n'
    source.write_text(opened + PLACES)
    lacking = translate(source, to="rapid", language="melfa-basic-5", cell=cell)
    assert [(one.name, one.kind) for one in lacking.wanting] == [
        ("line_2", "line"), ("joint_speed", "speed"),
    ]  # fmt: skip
    text = cell_text(read_cell(cell), lacking.wanting)
    text = text.replace('role = "?"', 'role = "client"').replace('port = "?"', "port = 2001")
    text = text.replace('address = "?"', 'address = "10.0.0.5"')
    cell.write_text(text.replace('speed = "?"', "speed = 80"))
    found = translate(source, to="rapid", language="melfa-basic-5", cell=cell, proving=Proving())
    assert found.ok, found.findings
    assert not found.wanting
    made = next(iter(found.files.values())).decode()
    assert 'SocketConnect channel_1,"10.0.0.5",2001' in made
    assert "MoveJ P1,v80,fine" in made
    assert not translate(source, to="melfa-basic-6", language="melfa-basic-5", cell=cell).wanting


FORCE = """P_FsStf0=(0,0,2.5,0,0,0)(0,0)
M_FsCod0=1
Mvs P1
Fsc On,0,0,1 'soft
Dly 1
FsGChg 50,500,-1
MX=P_FsCurD.Z
Fsc Off
Mvs P1
End
"""


@pytest.mark.parametrize(("value", "stops"), [("stop", 3), ("empty", 0)])
def test_force_control_is_said_by_routines_of_the_cell(
    value: str, stops: int, tmp_path: Path
) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    source.write_text(FORCE + PLACES)
    text = neutral_cell(load(source, language="melfa-basic-5"))
    for entry in ("routines.FscOn", "routines.FscOff", "routines.FsGChg", "positions.P_FsCurD"):
        assert f"[{entry}]" in text
    cell.write_text(text.replace('routine = "stop"', f'routine = "{value}"'))
    found = translate(source, to="rapid", language="melfa-basic-5", cell=cell, proving=Proving())
    assert found.ok, found.findings
    assert found.motion is not None
    assert found.motion.holds
    rows = {row.text: row for row in found.rows}
    assert [reason.code for reason in rows["Fsc On,0,0,1 'soft"].reasons] == ["MB256"]
    state = rows["P_FsStf0=(0,0,2.5,0,0,0)(0,0)"]
    assert [reason.code for reason in state.reasons] == ["MB258"]
    written = "".join(data.decode() for data in found.files.values())
    assert written.count("Stop;") == stops
    assert " FSCON " in written and "PROC FSCON(" in written


def test_force_control_without_a_cell_stays_as_it_is(tmp_path: Path) -> None:
    source = tmp_path / "JOB.prg"
    source.write_text(FORCE + PLACES)
    found = translate(source, to="rapid", language="melfa-basic-5")
    assert not found.ok
    assert found.totals["not"] >= 4


def test_a_signal_whose_number_the_list_of_values_holds(tmp_path: Path) -> None:
    source = tmp_path / "JOB.prg"
    text = "If M_In(MPart)=1 Then M_Out(MPart)=1\nMvs P1\nEnd\nMPart=5\n"
    source.write_text(text + PLACES)
    found = translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert found.ok, found.findings
    assert {signal.number for signal in found.compiled.program.signals.values()} == {5}
    source.write_text(text.replace("Mvs P1", "MPart=M_Inb(8)") + PLACES)
    assert not translate(source, to="rapid", language="melfa-basic-5").ok


def test_moments_that_are_no_angles_stay_as_they_are(tmp_path: Path) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    source.write_text("P_FsFLm0=(9,9,9,120,5,5)(0,0)\nFsc On,0,0,1\nMvs P1\nEnd\n" + PLACES)
    cell.write_text(neutral_cell(load(source, language="melfa-basic-5")))
    found = translate(source, to="rapid", language="melfa-basic-5", cell=cell)
    assert not found.ok
    assert [row.text[:8] for row in found.rows if row.level == "not"] == ["P_FsFLm0"]


FUNCTIONS = """M1=fnRead()
fnWrite(M1,"a",P1)
End
Function V Mine()
FEnd
"""
SIX = languages.get("melfa-basic-6")


def test_functions_that_stand_in_no_file_are_routines_of_the_cell() -> None:
    tree = SIX.parse(SourceText(FUNCTIONS + PLACES, "JOB.prg"))
    found = SIX.wanted([tree])
    assert [(one.name, one.kind, one.type) for one in found] == [
        ("fnWrite", "routine", ""),
        ("fnRead", "routine", "num"),
    ]
    (made,) = SIX.with_supplied([tree], [(one, "empty") for one in found], "cell")
    assert SIX.wanted([made]) == ()


@pytest.mark.parametrize("routine", ["stop", "empty", "MORE.prg"])
def test_a_function_of_the_cell_is_called(routine: str, tmp_path: Path) -> None:
    source, cell = tmp_path / "JOB.prg", tmp_path / "cell.toml"
    source.write_text("Mvs P1\nM1=fnRead()\nDly M1+1\nEnd\n" + PLACES)
    (tmp_path / "MORE.prg").write_text("Function M fnRead()\nfnRead=5\nFEnd\n")
    cell.write_text(f'[routines.fnRead]\nroutine = "{routine}"\n')
    found = translate(source, to="rapid", language="melfa-basic-6", cell=cell, proving=Proving())
    assert found.ok, found.findings
    assert found.motion is not None and found.motion.holds
    text = "".join(data.decode() for data in found.files.values())
    assert {"stop": "Stop;", "empty": "RETURN 0;", "MORE.prg": "RETURN 5;"}[routine] in text


def test_a_place_that_was_never_taught_has_no_value(tmp_path: Path) -> None:
    source = tmp_path / "JOB.prg"
    zeros = ",".join(["0.000"] * 8)
    text = f"Dim PA(2)\nPA(2)=P1\nMvs PA(2)\nEnd\nPA(1)=({zeros})\nPA(2)=({zeros})\n"
    source.write_text(text + PLACES)
    found = translate(source, to="rapid", language="melfa-basic-6", proving=Proving())
    assert found.ok, found.findings
    assert found.motion is not None and found.motion.holds
