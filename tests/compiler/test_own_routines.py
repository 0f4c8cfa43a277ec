"""Routines of a name that several modules have: each means its own, on both sides."""

from __future__ import annotations

from pathlib import Path

from assistant.compiler import load, translate
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation

MAIN = r"""MODULE Main
CONST robtarget p10:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR string device:="TOOLS";
PROC main()
  close 10;
  handle;
  %device+":close"% 30,40;
ENDPROC
PROC close(num x\num y)
  MoveL Offs(p10,x,0,0),v100,fine,tool0;
  IF Present(y) MoveL Offs(p10,0,y,0),v100,fine,tool0;
ENDPROC
ENDMODULE
"""
TOOLS = r"""MODULE Tools
PROC handle()
  close 20,5\fast;
ENDPROC
LOCAL PROC close(num x,num z\switch fast)
  MoveL Offs(p10,x,0,z),v50,fine,tool0;
  IF NOT Present(fast) MoveL p10,v50,fine,tool0;
ENDPROC
ENDMODULE
"""


def _translated(folder: Path, main: str = MAIN) -> Translation:
    (folder / "Main.mod").write_text(main, encoding="utf-8", newline="\n")
    (folder / "Tools.mod").write_text(TOOLS, encoding="utf-8", newline="\n")
    pgf = '<?xml version="1.0" encoding="ISO-8859-1" ?>\n<Program>\n{}</Program>\n'
    names = "".join(f"<Module>{name}.mod</Module>\n" for name in ("Main", "Tools"))
    (folder / "cell.pgf").write_text(pgf.format(names), encoding="utf-8", newline="\n")
    return translate(load(folder / "cell.pgf"), to="melfa-basic-6", proving=Proving())


def test_each_module_calls_its_own_routine(tmp_path: Path) -> None:
    done = _translated(tmp_path)
    assert done.ok, [f.message for row in done.rows for f in row.reasons]
    assert done.motion is not None and done.motion.holds
    assert done.motion.found is not None and done.motion.found.visits == 4
    told = [row.text for row in done.rows for f in row.reasons if f.code == "RA394"]
    assert told == ['%device+":close"% 30,40']


def test_a_call_that_two_routines_fit_stays(tmp_path: Path) -> None:
    main = MAIN.replace("num x\\num y", "num x,num y").replace("close 10;", "")
    done = _translated(tmp_path, main.replace("IF Present(y) ", ""))
    (row,) = (row for row in done.rows if row.level == "not" and row.text.startswith("%"))
    assert row.reasons
