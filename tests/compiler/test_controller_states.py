"""What a controller tells of itself, as its cell file says it for another one."""

from __future__ import annotations

from pathlib import Path

from assistant.compiler import load, translate
from assistant.compiler.cell_defaults import neutral_cell, with_values_of_file
from assistant.compiler.motion_proof import Proving

ASKING = """MODULE Asking
  CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR num state;
  PROC main()
    IF GetTaskName()="T_ROB1" THEN
      MoveL p10,v100,fine,tool0;
    ENDIF
    IF RobOS() MoveL Offs(p10,0,0,9),v100,fine,tool0;
    IF OpMode()=OP_AUTO AND RunMode(\\Main)=RUN_CONT_CYCLE SetDO doAuto,1;
    %s
    IF NOT RobOS() SetDO doAuto,0;
  ENDPROC
ENDMODULE
"""


def file(folder: Path, more: str = "") -> Path:
    path = folder / "asking.mod"
    path.write_text(ASKING % more, encoding="utf-8", newline="\n")
    return path


def test_the_cell_is_asked_for_it_and_both_do_the_same(tmp_path: Path) -> None:
    loaded = load(file(tmp_path))
    text = neutral_cell(loaded)
    assert '[data.controller_task]\ntype = "string"\nvalue = "T_ROB1"' in text
    cell = tmp_path / "cell.toml"
    cell.write_text(text, encoding="utf-8")
    done = translate(
        with_values_of_file(loaded, cell), to="melfa-basic-6", proving=Proving(seconds=5)
    )
    assert done.totals["not"] == 0
    assert [f.code for f in done.findings].count("RA391") == 4
    assert done.motion is not None
    assert done.motion.holds


def test_units_and_networks_are_as_the_cell_says(tmp_path: Path) -> None:
    asking = (
        'IOBusState "net",state\\Phys;\n'
        "IF state=BUSSTATE_RUN SetDO doAuto,1;\n"
        'IF IOUnitState("d1"\\Phys)=IOUNIT_PHYS_STATE_RUNNING SetDO doAuto,0;'
    )
    loaded = load(file(tmp_path, asking))
    cell = tmp_path / "cell.toml"
    cell.write_text(neutral_cell(loaded), encoding="utf-8")
    done = translate(
        with_values_of_file(loaded, cell), to="melfa-basic-6", proving=Proving(seconds=5)
    )
    assert done.totals["not"] == 0
    assert done.motion is not None
    assert done.motion.holds


def test_texts_of_the_system_and_constants_of_its_types(tmp_path: Path) -> None:
    asking = (
        'IF GetSysInfo(\\SerialNo)="14-21858" SetDO doAuto,0;\n'
        "IF StrLen(GetSysInfo(\\CtrlLang))=2 SetDO doAuto,1;\n"
        "state:=DINT*10+iconWarning+UINT; SetDO doAuto,0; WaitTime 0.2;\n"
        "MoveL Offs(p10,0,state,0),v100,fine,tool0;"
    )
    loaded = load(file(tmp_path, asking))
    cell = tmp_path / "cell.toml"
    text = neutral_cell(loaded)
    assert '[data.controller_serial_number]\ntype = "string"\nvalue = "14-21858"' in text
    cell.write_text(text, encoding="utf-8")
    done = translate(
        with_values_of_file(loaded, cell), to="melfa-basic-6", proving=Proving(seconds=5)
    )
    assert done.totals["not"] == 0, [f.message for row in done.rows for f in row.reasons]
    assert done.motion is not None
    assert done.motion.holds


def test_without_a_cell_it_is_not_said(tmp_path: Path) -> None:
    done = translate(load(file(tmp_path)), to="melfa-basic-6")
    assert "the function `gettaskname`" in " ".join(f.message for f in done.findings)
