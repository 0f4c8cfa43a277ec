"""What parameter lists beside a program say, so that nobody is asked for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import Translation, translate
from assistant.compiler.motion_proof import Proving

COMMON = (
    'COMMON.PRMNARC parameter system V1.0;\r\nMECHA1=Ms,"RV-4FRL-D";\r\n{more}NETIP=Us,"10.0.0.2";'
)
ROBOT = (
    "RV-4FRL-DNARC parameter system V1.0;\r\nMEXTL=Uf,0,0,150,%r0,%r0,%r1.5707963267948966;\r\n"
    "MEXTL2=Uf,0,0,70,%r0,%r0,%r0;\r\nMEXBS=Uf,0,0,0,%r0,%r0,%r0;\r\n"
)
PLACE = "P1=(+400.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)\n"
RAPID = {"to": "rapid", "robot": "irb1200-7-0.7"}


def project(folder: Path, code: str, held: str = "Backup/20240101-1200", more: str = "") -> Path:
    """A program in a project as RT ToolBox3 keeps it, with the lists of one controller."""
    lists = folder / "RC1" / held
    lists.mkdir(parents=True)
    (lists / "COMMON.PRM").write_text(COMMON.replace("{more}", more))
    (lists / "RV-4FRL-D#1.PRM").write_text(ROBOT)
    (lists / "RV-7FR-D#1.PRM").write_text(ROBOT.replace("150", "90"))
    program = folder / "RC1" / "Program" / "PICK.prg"
    program.parent.mkdir()
    program.write_text(code + PLACE)
    return program


def translated(program: Path, process: Path | None = None) -> tuple[Translation, str]:
    done = translate(program, **RAPID, process=process, proving=Proving())
    return done, "".join(data.decode() for data in done.files.values())


@pytest.mark.parametrize("held", ["Backup/20240101-1200", "CoreSpace Online", "../RC1/Program"])
def test_the_tool_that_is_kept_is_that_of_the_parameters(tmp_path: Path, held: str) -> None:
    if held.endswith("Program"):
        (tmp_path / "RC1").mkdir()
        program = tmp_path / "PICK.prg"
        program.write_text("Spd 50\nMvs P1\nEnd\n" + PLACE)
        (tmp_path / "COMMON.PRM").write_text(COMMON.replace("{more}", ""))
        (tmp_path / "RV-4FRL-D#1.PRM").write_text(ROBOT)
    else:
        program = project(tmp_path, "Spd 50\nMvs P1\nEnd\n", held)
    done, text = translated(program)
    assert done.ok, [(f.code, f.message) for f in done.whole]
    assert done.motion is not None and done.motion.holds
    assert "[TRUE,[[0,0,150],[0.7071" in text
    assert not any(f.code == "MB233" and "tool" in f.message for f in done.findings)
    assert any(f.code == "CO046" and "`MEXTL`" in f.message for f in done.whole)
    assert any(f.code == "MB289" and "the tool" in f.message for f in done.whole)


def test_a_program_that_sets_its_tool_itself_keeps_it(tmp_path: Path) -> None:
    done, text = translated(project(tmp_path, "Spd 50\nTool (0,0,20,0,0,0)\nMvs P1\nEnd\n"))
    assert done.ok and "[0,0,150]" not in text and "[0,0,20]" in text
    assert not any(f.code == "MB289" and "the tool" in f.message for f in done.whole)


def test_a_sister_dialect_keeps_its_tool_as_before(tmp_path: Path) -> None:
    code = "1 Spd 50\n2 Mvs P1\n3 End\n"
    done = translate(project(tmp_path, code), to="melfa-basic-6", language="melfa-basic-5")
    (text,) = (data.decode() for data in done.files.values())
    assert done.ok, [(f.code, f.message) for f in done.findings]
    assert "Tool" not in text and "MEXTL" not in text


def test_tools_by_their_number_are_those_of_the_list(tmp_path: Path) -> None:
    done, text = translated(project(tmp_path, "Spd 50\nTool 2\nMvs P1\nEnd\n"))
    assert done.ok, [(f.code, f.message) for f in done.findings]
    assert "[0,0,70]" in text


def test_joint_moves_are_of_the_arm_that_the_list_names(tmp_path: Path) -> None:
    program = project(tmp_path, "JOvrd 50\nMov J1\nMov P1\nEnd\nJ1=(0,0,90,0,90,0)\n")
    done, _ = translated(program)
    assert any(f.code == "CO046" and "`rv-4frl`" in f.message for f in done.whole)
    assert not any(f.code == "CO503" for f in done.findings)


def test_lines_have_the_role_and_the_port_of_the_parameters(tmp_path: Path) -> None:
    code = 'Open "COM3:" As #1\nPrint #1,"on"\nClose #1\nEnd\n'
    more = 'COMDEV=Us,"RS232","","OPT13","","","","","";\r\n'
    done, text = translated(project(tmp_path, code, more=more))
    assert done.ok, [(f.code, f.message) for f in done.findings]
    assert '"10.0.0.2",10003' in text.replace(" ", "")


def test_how_a_slot_runs_the_program_is_told(tmp_path: Path) -> None:
    program = project(tmp_path, "Mvs P1\nEnd\n", more='SLT2=Us,"PICK","REP","ALWAYS","1";\r\n')
    done, _ = translated(program)
    assert [f.message for f in done.whole if f.code == "MB288"] == [
        "the list of slots has `PICK` in slot 2: REP ALWAYS"
    ]


def test_a_cell_file_that_says_the_rest_takes_the_tool_not_away(tmp_path: Path) -> None:
    program, cell = project(tmp_path, "Spd 50\nMvs P1\nMvs P2\nEnd\n"), tmp_path / "cell.toml"
    cell.write_text("[positions.P2]\nposition = [400, 50, 300]\nquaternion = [0, 0, 1, 0]\n")
    done = translate(program, **RAPID, cell=cell)
    (text,) = (data.decode() for data in done.files.values())
    assert done.ok, [(f.code, f.message) for f in done.whole]
    assert text.count("PMEXTL") >= 3
    assert "[0,0,150]" in text
