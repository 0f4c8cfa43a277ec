"""Names whose uses allow data and signals alike: the cell file, or the controller's, decides."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.compiler import translate
from assistant.compiler.cell_defaults import cell_text
from assistant.compiler.translation import Translation
from assistant.sources.cell_values import read_cell

MODULE = """MODULE Cell
  VAR num n:=0;
  PROC main()
    n:=giOrder+nOther;
    IF bReady=1 THEN
      n:=1;
    ENDIF
    SetDO doOut,n;
  ENDPROC
ENDMODULE
"""
OUTPUT = '[signals.doOut]\nkind = "digital"\ndirection = "output"\nnumber = 7\n'
SIGNAL = '[signals.{name}]\nkind = "{kind}"\ndirection = "input"\nnumber = {number}\n'
DATA = '[data.{name}]\ntype = "num"\nvalue = {value}\n'


def made(folder: Path, cell: str) -> Translation:
    source, path = folder / "cell.mod", folder / "cell.toml"
    source.write_text(MODULE, encoding="utf-8")
    path.write_text(cell, encoding="utf-8")
    return translate(source, to="melfa-basic-6", cell=path)


def test_doubt_is_in_the_cell_file_and_in_the_draft(tmp_path: Path) -> None:
    done = made(tmp_path, OUTPUT)
    assert {one.name: (one.kind, one.perhaps) for one in done.wanting} == {
        "giOrder": ("signal", "data"), "nOther": ("data", "signal"), "bReady": ("signal", "data"),
    }  # fmt: skip
    text = cell_text(read_cell(tmp_path / "cell.toml"), done.wanting)
    assert "# Doubtful: if it is data, write [data.bReady] " in text
    assert "# Doubtful: if it is a signal, write [signals.nOther] " in text
    draft = b"".join(done.files.values()).decode("ascii")
    assert "to be filled in: digital input bReady (perhaps data)" in draft
    assert "to be filled in: data of type num nOther (perhaps a signal)" in draft


def test_a_type_that_no_use_shows_is_in_doubt(tmp_path: Path) -> None:
    source, path = tmp_path / "cell.mod", tmp_path / "cell.toml"
    source.write_text("MODULE Cell\nPROC main()\nx:=y;\nENDPROC\nENDMODULE\n", encoding="utf-8")
    done = translate(source, to="melfa-basic-6", cell=path, draft=True)
    text = cell_text(read_cell(path), done.wanting)
    assert "# Doubtful: no use shows the type; correct it if it is another one." in text
    path.write_text(
        '[data.x]\ntype = "string"\nvalue = "a"\n[data.y]\ntype = "string"\nvalue = "b"\n'
    )
    done = translate(source, to="melfa-basic-6", cell=path)
    assert done.ok, [f.message for f in done.findings]
    assert "Cx$=Cy$" in b"".join(done.files.values()).decode("ascii")


def test_the_cell_file_decides_either_way(tmp_path: Path) -> None:
    signals = SIGNAL.format(name="nOther", kind="group", number=32).replace(
        "number = 32", "number = 32\nbits = 8"
    )
    data = DATA.format(name="giOrder", value=3) + DATA.format(name="bReady", value=1)
    done = made(tmp_path, OUTPUT + signals + data)
    assert done.ok, [f.message for f in done.findings]
    program = done.compiled.program
    assert {"nother"} <= {name.lower() for name in program.signals}
    assert not {"giorder", "bready"} & {name.lower() for name in program.signals}
    other = SIGNAL.format(name="bReady", kind="digital", number=4) + DATA.format(
        name="nOther", value=5
    )
    other += SIGNAL.format(name="giOrder", kind="group", number=32) + "bits = 4\n"
    done = made(tmp_path, OUTPUT + other)
    assert done.ok, [f.message for f in done.findings]
    assert "M_In(4)=1" in b"".join(done.files.values()).decode("ascii")


def test_both_in_one_cell_file_are_refused(tmp_path: Path) -> None:
    both = SIGNAL.format(name="bReady", kind="digital", number=4)
    with pytest.raises(Refused) as told:
        made(tmp_path, OUTPUT + both + DATA.format(name="bReady", value=1))
    assert [f.code for f in told.value.findings] == ["CO078"]


def test_files_of_the_controller_decide(tmp_path: Path) -> None:
    (tmp_path / "SYSPAR").mkdir()
    (tmp_path / "SYSPAR" / "EIO.cfg").write_text(
        'EIO:CFG_1.0:6:1::\nEIO_SIGNAL:\n      -Name "nOther" -SignalType "GI" -UnitMap "0-7"\n'
    )
    done = made(tmp_path, OUTPUT)
    assert "nOther" not in {one.name for one in done.wanting}
    assert done.compiled.program.signals["nOther"].kind == "group"
