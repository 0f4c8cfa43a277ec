"""Programs of several files, from a list of them, from a folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import translate
from assistant.compiler.loader import whole_programs
from assistant.program import statements as p
from tests.compiler.test_translating import ARM, MELFA, MODULE

MAIN = """MODULE Station
    PROC main()
        VAR num nOwn;
        Prepare;
        Carry pHome;
        EGMReset path;
    ENDPROC
    LOCAL PROC Prepare()
        nDone:=0;
    ENDPROC
ENDMODULE
"""
SHARED = """MODULE Shared
    ! What all share.
    PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
    CONST robtarget pHome:=[[350,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
    VAR num nDone:=nElsewhere;
    PROC Carry(robtarget pTo)
        Prepare;
        MoveL Offs(pTo,0,0,-50),v100,fine,tGrip;
    ENDPROC
    LOCAL PROC Prepare()
        Rewind ioFile;
    ENDPROC
ENDMODULE
"""
LISTED = (
    "<?xml version='1.0'?>\n<Program>\n<Module>a.mod</Module>\n<Module>b.mod</Module>\n</Program>"
)


def station(folder: Path) -> Path:
    (folder / "b.mod").write_text(MAIN, encoding="utf-8")
    (folder / "a.mod").write_text(SHARED, encoding="utf-8")
    (folder / "cell.pgf").write_text(LISTED, encoding="utf-8")
    return folder / "cell.pgf"


@pytest.mark.parametrize("to", MELFA)
def test_modules_of_a_list_are_one_program(tmp_path: Path, to: str) -> None:
    found = translate(station(tmp_path), to=to, robot=ARM[to], draft=True)
    assert found.draft, found.written.findings
    assert list(found.files) == ["STATION.prg"]
    wrong = {
        (Path(row.place.path or "").name, row.place.line)
        for row in found.rows
        if row.level == "not"
    }
    assert wrong == {("b.mod", 6), ("a.mod", 5), ("a.mod", 11)}
    for row in found.rows:  # each row is what stands in its file at its line
        assert row.place.path is not None
        lines = Path(row.place.path).read_text("utf-8").splitlines()
        assert lines[row.place.line - 1].strip().startswith(row.text.split(";")[0])
    lifted = found.proof.lifted
    assert lifted is not None
    bodies = {q.name: q.body for q in lifted.procedures}
    assert bodies["main"][:2] == (p.Stop(), p.Call("Station_Prepare"))
    assert p.Call("Shared_Prepare") in bodies["Carry"]
    assert b"not translated, b.mod line 6:" in found.files["STATION.prg"]


def test_a_folder_is_its_programs(tmp_path: Path) -> None:
    station(tmp_path)
    (tmp_path / "alone.mod").write_text(MODULE, encoding="utf-8")
    files = [str(file) for file in sorted(tmp_path.iterdir())]
    names = [Path(file).name for file in whole_programs(files)]
    assert names == ["alone.mod", "cell.pgf"]


def test_of_programs_that_call_each_other_one_stays(tmp_path: Path) -> None:
    for name, other in (("A", "B"), ("B", "A"), ("C", "A")):
        (tmp_path / f"{name}.prg").write_text(f'1 CallP "{other}"\n2 End\n', encoding="ascii")
    files = [str(tmp_path / f"{name}.prg") for name in "ABC"]
    assert whole_programs(files, "melfa-basic-5") == files[2:]
    (tmp_path / "C.prg").write_text("1 End\n", encoding="ascii")
    assert whole_programs(files, "melfa-basic-5") == [files[0], files[2]]
