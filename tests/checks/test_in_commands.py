"""The commands show what the rules find, at its line, and let it be ignored or turned down."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.test_commands import run

ARM = ("--robot", "irb1200-7-0.7")
QUICK = """MODULE quick
  CONST robtarget p1:=[[400,-100,300],[0,0.7071068,0.7071068,0],[-1,0,0,0],
                       [9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p2:=[[400,100,300],[0,0.7071068,-0.7071068,0],[0,0,3,0],
                       [9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST speeddata vQuick:=[2000,2000,5000,1000];
  PROC main()
    MoveJ p1,v1000,fine,tool0;
    MoveL p2,vQuick,fine,tool0;
  ENDPROC
ENDMODULE
"""


def write(file: Path, text: str) -> Path:
    file.write_text(text, encoding="utf-8")
    return file


def findings(out: str) -> list[dict]:
    return [f for f in json.loads(out)["findings"] if f["code"].startswith("CK")]


def test_check_shows_them_at_their_line(capsys, tmp_path):
    file = write(tmp_path / "quick.mod", QUICK)
    status, out, _ = run(capsys, "check", file, *ARM, "--format", "json")
    (finding,) = findings(out)
    assert (status, finding["code"], finding["line"]) == (1, "CK311", 9)
    assert finding["excerpt"] == "    MoveL p2,vQuick,fine,tool0;"
    status, out, _ = run(capsys, "check", file, "--format", "json")
    assert (status, findings(out)) == (0, [])


def test_a_comment_ignores_them(capsys, tmp_path):
    text = QUICK.replace("vQuick,fine,tool0;", "vQuick,fine,tool0; ! assistant: ignore CK311")
    file = write(tmp_path / "quick.mod", text)
    status, out, _ = run(capsys, "check", file, *ARM, "--format", "json")
    assert (status, json.loads(out)["findings"]) == (0, [])


def test_a_project_turns_them_down_or_up(capsys, tmp_path):
    file = write(tmp_path / "quick.mod", QUICK)
    settings = write(tmp_path / "assistant.toml", '[severity]\nCK311 = "info"\n')
    status, out, _ = run(capsys, "check", file, *ARM, "--format", "json")
    assert (status, findings(out)[0]["severity"]) == (0, "info")
    write(settings, '[severity]\nCK3 = "off"\n')
    status, out, _ = run(capsys, "check", file, *ARM, "--format", "json")
    assert (status, findings(out)) == (0, [])
    write(settings, '[severity]\nCK311 = "error"\n')
    arguments = ("compile", file, "-l", "rapid", *ARM, "-o", tmp_path / "out")
    status, _, err = run(capsys, *arguments)
    assert (status, "CK311 error" in err) == (1, True)
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_compile_and_translate_show_them(capsys, tmp_path):
    file = write(tmp_path / "quick.mod", QUICK)
    status, _, err = run(capsys, "compile", file, "-l", "rapid", *ARM, "-o", tmp_path / "rapid")
    assert (status, err.count("CK311 warning")) == (0, 1)
    assert "quick.mod:9" in err
    other = ("--to", "melfa-basic-6", "--from-robot", "irb1200-7-0.7", "--robot", "rv-4frl")
    status, out, err = run(capsys, "translate", file, *other, "-o", tmp_path / "melfa")
    assert (status, (out + err).count("CK311 J6")) == (0, 1)


def test_a_pseudo_program_has_them_at_their_line(capsys, tmp_path):
    file = write(tmp_path / "quick.mod", QUICK)
    _, text, _ = run(capsys, "show", file)
    pseudo = write(tmp_path / "quick.pseudo", text)
    _, out, _ = run(capsys, "check", pseudo, *ARM, "--format", "json")
    (finding,) = findings(out)
    assert finding["code"] == "CK311"
    assert "p2" in finding["excerpt"]
