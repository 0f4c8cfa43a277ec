"""What a program begins with: its main, or the procedure that is named."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from assistant.base.diagnostics import Refused
from assistant.cli.app import app
from assistant.compiler import compile, translate
from tests.compiler.same_motion import MELFA, moves_alike, translated

TARGET = "CONST robtarget p10:=[[350,20,250],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
MODULE = f"""MODULE cell
{TARGET}
PROC run()
MoveL p10,v100,fine,tool0;
up 20;
ENDPROC
PROC up(num by)
MoveL Offs(p10,0,0,by),v100,fine,tool0;
ENDPROC
FUNC num half(num by)
RETURN by/2;
ENDFUNC
ENDMODULE
"""


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("draft", [False, True])
def test_a_program_that_would_do_nothing_is_not_written(
    tmp_path: Path, to: str, draft: bool
) -> None:
    found = translated(tmp_path, MODULE, to, draft=draft)
    assert not found.ok
    assert not found.files
    assert [f.code for f in found.findings if f.severity == "error"] == ["MB245"]
    assert any("--entry" in f.cure for f in found.findings)


@pytest.mark.parametrize("to", MELFA)
def test_the_procedure_that_is_named_is_what_runs_first(tmp_path: Path, to: str) -> None:
    moves_alike(tmp_path, MODULE, to, 2, entry="RUN")


def test_compile_takes_an_entry_too(tmp_path: Path) -> None:
    file = tmp_path / "cell.mod"
    file.write_text(MODULE, encoding="utf-8")
    assert not compile(file, language="melfa-basic-5").ok
    assert compile(file, language="melfa-basic-5", entry="run").ok
    assert compile(file, language="rapid").ok  # a module beside others


@pytest.mark.parametrize("to", MELFA)
def test_a_list_of_targets_begins_with_nothing(tmp_path: Path, to: str) -> None:
    assert translated(tmp_path, f"MODULE cell\n{TARGET}\nENDMODULE\n", to).ok


@pytest.mark.parametrize(("entry", "code"), [("walk", "CO011"), ("up", "CO012"), ("half", "CO012")])
def test_what_nothing_can_begin_with_is_refused(tmp_path: Path, entry: str, code: str) -> None:
    file = tmp_path / "cell.mod"
    file.write_text(MODULE, encoding="utf-8")
    with pytest.raises(Refused) as refused:
        translate(file, to="melfa-basic-5", entry=entry)
    (finding,) = refused.value.findings
    assert finding.code == code
    assert "`run`" in finding.cure or "choose one of run" in finding.cure
    assert refused.value.exit_status == 2


def test_the_command_line_names_it(tmp_path: Path) -> None:
    file = tmp_path / "cell.mod"
    file.write_text(MODULE, encoding="utf-8")
    call = ["translate", str(file), "--to", "melfa-basic-5", "-o", str(tmp_path / "out")]
    assert CliRunner().invoke(app, call).exit_code == 1
    assert CliRunner().invoke(app, [*call, "--entry", "run"]).exit_code == 0
    shown = CliRunner().invoke(app, ["show", str(file), "--entry", "run"])
    assert "entry run" in shown.output
    simulated = ["simulate", str(file), "--entry", "run", "-r", "irb1200-7-0.7"]
    assert CliRunner().invoke(app, simulated).exit_code == 0
    assert CliRunner().invoke(app, [*call, "--entry", "up"]).exit_code == 2


def test_where_nothing_can_begin_the_cure_says_what_could(tmp_path: Path) -> None:
    file = tmp_path / "cell.mod"
    file.write_text("MODULE cell\nPROC up(num by)\nWaitTime by;\nENDPROC\nENDMODULE\n", "utf-8")
    with pytest.raises(Refused) as refused:
        translate(file, to="melfa-basic-5", entry="walk")
    (finding,) = refused.value.findings
    assert finding.cure == "choose a procedure without parameters"
