"""What pipelines read of `check`: GitLab's code quality, JUnit XML, and which findings fail it.

The reports are held against what their readers know: the schema by which GitLab validates an issue
(app/validators/json_schemas/codeclimate.json) with the severities of its documentation, and the
elements of Jenkins' junit-10.xsd.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft7Validator

from tests.cli.tables import each
from tests.cli.test_check import BROKEN, CLEAN, ODD, write
from tests.cli.test_commands import SAMPLES, run
from tests.cli.test_many_cells import NASTY, read

_BEGIN = {"type": "object", "required": ["begin"], "properties": {"begin": {"type": "integer"}}}
GITLAB = {
    "type": "array",
    "items": {
        "type": "object",
        "required": ["description", "check_name", "fingerprint", "severity", "location"],
        "properties": {
            "description": {"type": "string", "minLength": 1},
            "check_name": {"type": "string"},
            "fingerprint": {"type": "string"},
            "severity": {"enum": ["info", "minor", "major", "critical", "blocker"]},
            "location": {
                "type": "object",
                "required": ["path", "lines"],
                "properties": {"path": {"type": "string", "pattern": "^[^./]"}, "lines": _BEGIN},
            },
        },
    },
}


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Here: one program that is clean, one with a warning, one with an error."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("clean", CLEAN), ("odd", ODD), ("broken", BROKEN)):
        write(tmp_path / name / f"{name}.mod", text)
    return tmp_path


def quality(capsys: Any, *arguments: str) -> list[dict[str, Any]]:
    _, out, err = run(capsys, "check", *arguments, "--format", "gitlab")
    report: list[dict[str, Any]] = json.loads(out)
    Draft7Validator(GITLAB).validate(report)
    assert err == ""
    return report


def test_code_quality_tells_files_lines_and_severities(programs, capsys):
    told = {one["check_name"]: one for one in quality(capsys, ".")}
    assert told["RA204"]["location"] == {"path": "odd/odd.mod", "lines": {"begin": 4, "end": 4}}
    assert told["RA204"]["severity"] == "minor" and "v25" in told["RA204"]["description"]
    assert told["RA101"]["location"]["path"] == "broken/broken.mod"
    assert told["RA101"]["severity"] == "critical"
    assert quality(capsys, "clean") == []


def test_a_finding_that_moved_is_the_same_and_two_alike_are_two(programs, capsys):
    def marks() -> list[str]:
        return [one["fingerprint"] for one in quality(capsys, "./odd/../odd/odd.mod")]

    before = marks()
    (programs / "odd" / "odd.mod").write_text("! a line\n" + ODD, encoding="utf-8")
    assert marks() == before
    move = "    MoveL p1,v25,fine,tool0;\n"
    assert move in ODD
    (programs / "odd" / "odd.mod").write_text(ODD.replace(move, move * 2), encoding="utf-8")
    twice = marks()
    assert len(set(twice)) == len(twice) == len(before) + 1 and set(before) < set(twice)


def test_what_has_no_line_stands_at_the_first(programs, capsys):
    plate = write(programs / "plate.dxf", (SAMPLES / "plate.dxf").read_text("utf-8"))
    report = quality(capsys, plate.name)
    assert report
    assert {(one["location"]["path"], one["location"]["lines"]["begin"]) for one in report} == {
        ("plate.dxf", 1)
    }


def test_junit_has_a_suite_a_file_and_fails_what_fails_the_command(programs, capsys):
    status, out, err = run(capsys, "check", ".", "--format", "junit", "--fail-on", "error")
    root = read(out.encode())
    suites = {suite.get("name"): suite for suite in root}
    assert (status, err) == (1, "")
    assert suites.keys() == {"./clean/clean.mod", "./odd/odd.mod", "./broken/broken.mod"}
    assert [len(list(one)) for one in suites["./clean/clean.mod"]] == [0]
    assert [one.tag for one in suites["./odd/odd.mod"].iterfind("testcase/*")] == ["skipped"]
    (failure,) = suites["./broken/broken.mod"].iter("failure")
    assert failure.get("type") == "RA101" and "broken.mod:3:" in failure.text
    for fail_on, failing in (("warning", 1), ("never", 0)):
        _, out, _ = run(capsys, "check", "odd", "--format", "junit", "--fail-on", fail_on)
        assert read(out.encode()).get("failures") == str(failing)


def test_junit_is_well_formed_whatever_is_in_a_name(programs, capsys):
    name = "".join(c for c in NASTY if c not in "/\0\ud800").strip()[:60] + ".mod"
    (programs / "odd" / name).write_text(ODD.replace("MODULE odd", "MODULE o"), encoding="utf-8")
    _, out, _ = run(capsys, "check", "odd", "--format", "junit")
    assert out.isascii()
    (suite,) = (one for one in read(out.encode()) if "<x a='1'>" in one.get("name"))
    assert len(list(suite.iter("failure"))) >= 1


FAILING = (
    ("clean", (0, 0, 0)),
    ("odd", (0, 1, 0)),
    ("broken", (1, 1, 0)),
    ("none.mod", (2, 2, 2)),
)


def test_what_fails_a_check(programs, capsys):
    def check(checked, statuses):
        levels = ("error", "warning", "never")
        said = [run(capsys, "check", checked, "--fail-on", one)[0] for one in levels]
        assert tuple(said) == statuses
        assert run(capsys, "check", checked)[0] == statuses[1], "as it is without the option"

    each(FAILING, check)


def test_a_project_fails_by_the_same_option(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run(capsys, "init", ".")
    process = tmp_path / "drawings" / "plate.process.toml"
    process.write_text(process.read_text("utf-8").replace("[330,", "[3300,"), encoding="utf-8")
    assert run(capsys, "check")[0] == 1
    status, out, _ = run(capsys, "check", "--fail-on", "never", "--format", "junit")
    assert status == 0
    assert [suite.get("name") for suite in read(out.encode())] == ["drawings/plate.dxf"]
    report = quality(capsys)
    assert {"critical"} <= {one["severity"] for one in report}
    assert {one["location"]["path"] for one in report} == {"drawings/plate.dxf"}


def test_a_refusal_is_told_in_these_forms_too(programs, capsys):
    (programs / "assistant.toml").write_text('[severity]\nRA204 = "of"\n', encoding="utf-8")
    status, out, _ = run(capsys, "check", "odd", "--format", "gitlab")
    assert status == 2 and [one["check_name"] for one in json.loads(out)] == ["FN104"]
    status, out, _ = run(capsys, "check", "odd", "--format", "junit")
    assert status == 2 and read(out.encode()).get("failures") == "1"


def test_a_command_that_finds_nothing_has_a_test_that_passed(programs, capsys):
    table = write(programs / "taught.toml", (SAMPLES / "taught.toml").read_text("utf-8"))
    status, out, _ = run(capsys, "compile", table, "-l", "rapid", "-o", "out", "--format", "junit")
    root = read(out.encode())
    assert (status, root.get("failures")) == (0, "0") and int(root.get("tests")) >= 1
    assert list(programs.joinpath("out").glob("*.mod"))
