"""The benchmark of whole tasks: what it prints of a folder of programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.tasks.report import Plan, report

MAIN = """MODULE m
    PROC main()
        count;
        SetDO doGrip,1;
    ENDPROC
ENDMODULE
"""
COUNTING = """MODULE a
    VAR num n:=0;
    PROC count()
        n:=n+1;
    ENDPROC
ENDMODULE
"""


@pytest.mark.slow
def test_a_task_is_whole_and_proven_in_the_neutral_cell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "rapid" / "someone+cell"
    folder.mkdir(parents=True)
    (folder / "RAPID__m.mod").write_text(MAIN, encoding="utf-8")
    (folder / "RAPID__a.mod").write_text(COUNTING, encoding="utf-8")
    (folder / "alone.mod").write_text(COUNTING.replace("count", "other"), encoding="utf-8")
    report(Plan(tmp_path, proof=2.0))
    said = capsys.readouterr().out
    (line,) = (line for line in said.splitlines() if line.endswith("someone+cell/RAPID/m.mod"))
    assert line.split()[2:6] == ["0", "no", "whole", "equal"]
    assert "rapid to melfa-basic-6: 1 tasks" in said
    assert "whole and proven equal: 1 of 1 (100 %)" in said
