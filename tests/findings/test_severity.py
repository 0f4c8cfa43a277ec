"""Severities of a project: which file counts, what may be turned down, what is odd."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.findings.severities import AS_THEY_ARE, severities_for

SPEED = Diagnostic("RA204", Severity.ERROR, "unknown speed")
ZONE = Diagnostic("RA205", Severity.ERROR, "unknown zone")
SYNTAX = Diagnostic("RA101", Severity.ERROR, "broken")
LOAD = Diagnostic("RA302", Severity.WARNING, "no load")


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def test_without_a_file_findings_are_as_they_are(tmp_path: Path) -> None:
    write(tmp_path / "pyproject.toml", "[project]\nname = 'x'\n")
    assert severities_for(tmp_path).of(SPEED) is SPEED
    assert AS_THEY_ARE.of(SYNTAX) is SYNTAX


def test_the_longest_beginning_of_a_code_counts(tmp_path: Path) -> None:
    write(tmp_path / "assistant.toml", '[severity]\nRA2 = "info"\nra204 = "warning"\nRA302="off"\n')
    wanted = severities_for(tmp_path)
    assert [wanted.of(f) for f in (SPEED, ZONE, LOAD)] == [
        Diagnostic("RA204", Severity.WARNING, "unknown speed"),
        Diagnostic("RA205", Severity.INFO, "unknown zone"),
        None,
    ]
    assert wanted.findings == ()


def test_the_nearest_file_counts_and_assistant_toml_before_pyproject(tmp_path: Path) -> None:
    ours = '[tool.robot-assistant.severity]\nRA204 = "{}"\n'
    write(tmp_path / "pyproject.toml", ours.format("info"))
    write(tmp_path / "cell" / "pyproject.toml", "[tool.other]\na = 1\n")
    write(tmp_path / "cell" / "left" / "pyproject.toml", ours.format("info"))
    write(tmp_path / "cell" / "left" / "assistant.toml", '[severity]\nRA204 = "warning"\n')

    def level(folder: str) -> str:
        found = severities_for(tmp_path / folder).of(SPEED)
        assert found is not None
        return found.severity

    assert level("cell/left") == "warning"
    assert level("cell/right") == "info"  # the pyproject.toml of `cell` is not about us


def test_errors_of_reading_are_never_turned_down_but_warnings_may_be_errors(tmp_path: Path) -> None:
    write(tmp_path / "assistant.toml", '[severity]\nR = "off"\nRA302 = "error"\n')
    wanted = severities_for(tmp_path)
    assert wanted.of(SYNTAX) is SYNTAX
    assert wanted.of(SPEED) is None
    assert wanted.of(LOAD) == Diagnostic("RA302", Severity.ERROR, "no load")


def test_a_finding_that_is_worse_than_its_rule_is_not_turned_down(tmp_path: Path) -> None:
    write(tmp_path / "assistant.toml", '[severity]\nRB = "off"\n')
    worse = Diagnostic("RB301", Severity.ERROR, "x")
    assert severities_for(tmp_path).of(worse) is worse


def test_what_is_odd_is_found_with_its_place(tmp_path: Path) -> None:
    text = 'color = 1\n\n[severity]\nRA999 = "off"\nRA101 = "info"\nRA204 = "off"\n'
    write(tmp_path / "assistant.toml", text)
    found = severities_for(tmp_path).findings
    assert [(f.code, f.line, f.column) for f in found] == [
        ("FN101", 1, 1),
        ("FN102", 4, 1),
        ("FN103", 5, 1),
    ]
    assert all(f.path == str(tmp_path / "assistant.toml") and f.cure for f in found)


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("[severity\n", "CT301", 1),
        ("a = 1\nb = \n", "CT301", 2),
        ('[severity]\nRA204 = "loud"\n', "FN104", 2),
        ("[severity]\nRA204 = 3\n", "FN104", 2),
        ("[severity]\nRA204 = ['off']\n", "FN104", 2),
        ('severity = "off"\n', "FN105", 1),
    ],
)
def test_a_broken_file_is_refused_with_its_place(
    tmp_path: Path, text: str, code: str, line: int
) -> None:
    write(tmp_path / "assistant.toml", text)
    with pytest.raises(Refused) as refused:
        severities_for(tmp_path / "deep" / "down")
    (finding,) = refused.value.findings
    assert (finding.code, finding.line) == (code, line)
    assert refused.value.exit_status == 2


def test_a_broken_table_of_pyproject_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "pyproject.toml", '[tool]\nrobot-assistant = "loud"\n')
    with pytest.raises(Refused) as refused:
        severities_for(tmp_path)
    assert [(f.code, f.line) for f in refused.value.findings] == [("FN105", 2)]
