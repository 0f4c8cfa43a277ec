"""Programs of several sources written into one folder: none replaces another's file unseen."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import assistant
from assistant.base.diagnostics import Refused
from tests.cli.test_commands import run

MODULE = """MODULE Job
CONST robtarget p1:=[[{x},0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ p1,v100,fine,tool0;
ENDPROC
ENDMODULE
"""
PSEUDO = "program job\n\nprocedure main\n  wait {x} s\nend\n"
COMPILE = ("compile", "-l", "rapid", "-o", "out")
TRANSLATE = ("translate", "--to", "melfa-basic-6", "-o", "out")


@pytest.mark.parametrize(
    ("command", "suffix", "text", "written"),
    [(COMPILE, "pseudo", PSEUDO, "job.mod"), (TRANSLATE, "mod", MODULE, "JOB.prg")],
    ids=["compile", "translate"],
)
def test_a_file_of_another_source_is_not_replaced(
    command, suffix, text, written, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    one, other = Path(f"one.{suffix}"), Path(f"other.{suffix}")
    one.write_text(text.format(x=1))
    other.write_text(text.format(x=2))
    assert run(capsys, *command, one)[0] in (0, 1)
    before = Path("out", written).read_bytes()
    status, _, said = run(capsys, *command, other)
    assert status == 1
    assert "CO342" in said
    assert "one." in said
    assert Path("out", written).read_bytes() == before
    one.write_text(text.format(x=3))  # a source replaces its own file
    assert "CO342" not in run(capsys, *command, one)[2]
    assert Path("out", written).read_bytes() != before
    one.rename(f"renamed.{suffix}")  # and a file whose source has gone
    assert "CO342" not in run(capsys, *command, other)[2]
    Path("out", written).unlink()
    assert "CO342" not in run(capsys, *command, f"renamed.{suffix}")[2]
    memory = json.loads(Path("out/.robot-assistant/written/sources.json").read_text())
    assert memory == {written: f"../../../renamed.{suffix}"}


def test_overwriting_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("one", "other"):
        Path(f"{name}.pseudo").write_text(PSEUDO.format(x=len(name)))
        status = run(capsys, *COMPILE, f"{name}.pseudo", "--overwrite")[0]
        assert status == 0
    assert "WaitTime 5" in Path("out/job.mod").read_text()


def test_python_refuses_it_as_well(tmp_path):
    for name in ("one", "other"):
        (tmp_path / f"{name}.pseudo").write_text(PSEUDO.format(x=len(name)))
    made = [
        assistant.compile(tmp_path / f"{name}.pseudo", language="rapid")
        for name in ("one", "other")
    ]
    made[0].write(tmp_path / "out")
    made[0].write(tmp_path / "out")
    with pytest.raises(Refused, match="CO342"):
        made[1].write(tmp_path / "out")
    made[1].write(tmp_path / "out", overwrite=True)


def test_a_memory_that_is_broken_counts_as_none(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("one.pseudo").write_text(PSEUDO.format(x=1))
    Path("out/.robot-assistant/written").mkdir(parents=True)
    for memory in (b"", b"[1]", b"{", b'{"job.mod": 5}', b"\xff"):
        Path("out/.robot-assistant/written/sources.json").write_bytes(memory)
        assert run(capsys, *COMPILE, "one.pseudo")[0] == 0, memory
        Path("out/job.mod").unlink()
