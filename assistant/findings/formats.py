"""Formats of findings: records, SARIF 2.1.0, GitLab code quality, GitHub annotations, JUnit XML.

Elements and attributes of JUnit are those that Jenkins' `junit-10.xsd` (xunit-plugin) and GitLab's
reports have. That document is ASCII, so that no terminal and no pipe changes it; characters of
names and messages that no XML may hold, or that steer a terminal, are marks in it.
"""

from __future__ import annotations

import hashlib
import os
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Any, Final
from urllib.parse import quote

from assistant import __version__
from assistant.base.diagnostics import (
    LONGEST_EXCERPT,
    Diagnostic,
    FailOn,
    Rule,
    Severity,
    notes_last,
)
from assistant.base.source_text import visible
from assistant.findings.rulebook import Page, cure_in_general, page_address, pages, rule_of

_SARIF_SCHEMA: Final = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
_SARIF_LEVELS: Final = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.INFO: "note",
}
_GITLAB_LEVELS: Final = {
    Severity.ERROR: "critical",
    Severity.WARNING: "minor",
    Severity.INFO: "info",
}
_GITHUB_LEVELS: Final = {
    Severity.ERROR: "error",
    Severity.WARNING: "warning",
    Severity.INFO: "notice",
}
_RECORDED: Final = (
    "code", "severity", "message", "cure", "path", "span", "line", "column", "place", "excerpt",
    "end_line", "end_column",
)  # fmt: skip
"""Fields of a finding's record, in this order; its subject in words."""
BASE: Final = "ROOT"
"""Base of the relative file addresses in a SARIF log."""


def finding_record(finding: Diagnostic) -> dict[str, Any]:
    """A finding as plain data, without the fields that it does not have.

    A line that is too long to be shown is left out.
    """
    said = {key: value for key in _RECORDED if (value := getattr(finding, key)) is not None}
    if finding.span is not None:
        said["span"] = asdict(finding.span)
    if len(said.get("excerpt", "")) > LONGEST_EXCERPT:
        del said["excerpt"]
    return said


def records_of(findings: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    """Findings as plain data; notes come after errors and warnings, as in text."""
    return [finding_record(finding) for finding in notes_last(findings)]


def github_line(finding: Diagnostic) -> str:
    """A workflow command that shows the finding beside the line in a pull request."""
    where = {
        "file": finding.path,
        "line": finding.line,
        "col": finding.column,
        "endLine": finding.end_line,
        # GitHub takes columns only within a single line.
        "endColumn": finding.end_column if finding.end_line == finding.line else None,
        "title": finding.code,
    }
    given = ",".join(f"{k}={_escaped(v, ':,')}" for k, v in where.items() if v is not None)
    text = " ".join(part for part in (finding.place, finding.message) if part)
    said = f"{text}\n{finding.cure}" if finding.cure else text
    return f"::{_GITHUB_LEVELS[finding.severity]} {given}::{_escaped(said)}"


def gitlab(findings: Sequence[Diagnostic], root: FilePath) -> list[dict[str, Any]]:
    """Return a code quality report: the fields of Code Climate issues that GitLab reads.

    https://docs.gitlab.com/ci/testing/code_quality/#code-quality-report-format. root: the absolute
    folder of the repository; files inside it are named relative to it. The fingerprint of a finding
    contains no line number, so that a finding that only moved is not reported as new.
    """
    seen: Counter[tuple[object, ...]] = Counter()
    report: list[dict[str, Any]] = []
    for finding in findings:
        path = _relative(finding.path or "", root)
        same = (finding.code, path, finding.place, finding.message, finding.excerpt)
        # Equal findings are counted, so that each has a fingerprint of its own.
        seen[same] += 1
        digest = hashlib.sha256(repr((*same, seen[same])).encode(errors="backslashreplace"))
        text = " ".join(part for part in (finding.place, finding.message) if part)
        report.append(
            {
                "description": f"{text}: {finding.cure}" if finding.cure else text,
                "check_name": finding.code,
                "fingerprint": digest.hexdigest(),
                "severity": _GITLAB_LEVELS[finding.severity],
                "location": {"path": path, "lines": _lines(finding)},
            }
        )
    return report


def _relative(path: str, root: FilePath) -> str:
    """The name of a file as GitLab knows it: from the root, without `./` before it."""
    file = FilePath(os.path.normpath(root / path))
    return file.relative_to(root).as_posix() if file.is_relative_to(root) else file.as_posix()


def _lines(finding: Diagnostic) -> dict[str, int]:
    lines = {"begin": finding.line or 1}
    return lines if finding.end_line is None else {**lines, "end": finding.end_line}


def sarif(
    findings: Sequence[Diagnostic], ignored: Sequence[Diagnostic], root: FilePath
) -> dict[str, Any]:
    """A SARIF 2.1.0 log of one run.

    ignored: findings that a comment ignores, marked as suppressed. root: an absolute folder;
    files inside it are named relative to it.
    """
    codes = sorted({f.code for f in (*findings, *ignored)})
    index = {code: number for number, code in enumerate(codes)}
    results = [_result(f, index, root) for f in findings]
    results += [
        {**_result(f, index, root), "suppressions": [{"kind": "inSource"}]} for f in ignored
    ]
    return {
        "$schema": _SARIF_SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "robot-assistant",
                        "version": __version__,
                        "informationUri": page_address("").rstrip("#"),
                        "rules": [_rule(rule) for code in codes if (rule := rule_of(code))],
                    }
                },
                "originalUriBaseIds": {BASE: {"uri": root.as_uri().rstrip("/") + "/"}},
                "columnKind": "unicodeCodePoints",
                "results": results,
            }
        ],
    }


def _rule(rule: Rule) -> dict[str, Any]:
    said = {
        "id": rule.code,
        "shortDescription": {"text": rule.sentence(rule.message)},
        "help": {"text": cure_in_general(rule) or "Nothing needs to be done."},
        "helpUri": page_address(rule.code),
        "defaultConfiguration": {"level": _SARIF_LEVELS[rule.severity]},
    }
    if why := pages().get(rule.code, Page()).why:
        said["fullDescription"] = {"text": why.strip()}
    return said


def _result(finding: Diagnostic, index: dict[str, int], root: FilePath) -> dict[str, Any]:
    text = f"{finding.message}\n{finding.cure}" if finding.cure else finding.message
    said: dict[str, Any] = {
        "ruleId": finding.code,
        "ruleIndex": index[finding.code],
        "level": _SARIF_LEVELS[finding.severity],
        "message": {"text": text},
    }
    location: dict[str, Any] = {}
    if finding.path:
        location["physicalLocation"] = {"artifactLocation": _artifact(finding.path, root)}
        if finding.line is not None:
            location["physicalLocation"]["region"] = _region(finding)
    if finding.place:
        location["logicalLocations"] = [{"fullyQualifiedName": finding.place}]
    return {**said, "locations": [location]} if location else said


def _artifact(path: str, root: FilePath) -> dict[str, str]:
    file = root / path
    if file.is_relative_to(root) and ".." not in file.parts:
        inside = file.relative_to(root).as_posix()
        # File names are bytes: those that are no text are quoted as well.
        return {"uri": quote(os.fsencode(inside)), "uriBaseId": BASE}
    return {"uri": FilePath(file).resolve().as_uri()}


def _region(finding: Diagnostic) -> dict[str, int]:
    parts = {
        "startLine": finding.line,
        "startColumn": finding.column,
        "endLine": finding.end_line,
        "endColumn": finding.end_column,
    }
    return {name: value for name, value in parts.items() if value is not None}


def _escaped(text: object, more: str = "") -> str:
    """Text of a workflow command: what would end it or a property of it is written in hex."""
    return "".join(f"%{ord(c):02X}" if c in "%\r\n" + more else c for c in str(text))


_JUNIT_COUNTS: Final = {"failures": "failure", "errors": "error", "skipped": "skipped"}
"""Count attributes of a suite, each with the element in a test that it counts."""
_SUITE_WITHOUT_FILE: Final = "robot-assistant"
"""The suite of findings that are about no file."""
_TEST_WITHOUT_FINDINGS: Final = "check"
"""The test of a file that nothing was found in."""


def junit_document(name: str, suites: Sequence[ET.Element], time: str | None = None) -> bytes:
    """The report, whole; well-formed whatever names and messages hold. time: seconds."""
    root = ET.Element("testsuites", {"name": name, **({} if time is None else {"time": time})})
    for one in suites:
        one.set("tests", str(len(one.findall("testcase"))))
        for key, element in _JUNIT_COUNTS.items():
            one.set(key, str(len(one.findall(f"testcase/{element}"))))
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(one.get(key, "0")) for one in suites)))
    root.extend(suites)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="us-ascii", xml_declaration=True)
    return text + b"\n"


def junit_case(suite: ET.Element, name: str) -> ET.Element:
    """Add a test to a suite; it passes unless a failure is added to it."""
    given = {"classname": suite.get("name", ""), "name": visible(name)}
    return ET.SubElement(suite, "testcase", given)


def mark_skipped(case: ET.Element, why: str) -> None:
    ET.SubElement(case, "skipped", {"message": visible(why)})


def mark_failed(
    case: ET.Element, kind: str, code: str, said: str, findings: Iterable[Diagnostic]
) -> None:
    """Add a failure to a test. kind: `failure` or `error`. code: the type of the failure. findings:
    listed in its text.
    """
    element = ET.SubElement(case, kind, {"type": code, "message": visible(said)})
    element.text = "\n".join(visible(line) for f in findings for line in _finding_lines(f))


def junit_report(
    findings: Sequence[Diagnostic], files: Iterable[str], fail_on: FailOn, name: str
) -> bytes:
    """Return a JUnit report: one suite per file with one test per finding; a file without a finding
    is a test that passes.

    files: all checked files. Findings for which the command does not fail are skipped tests. A
    finding that only moved to other lines is the same test, so that pipelines report only new ones.
    """
    by_file: dict[str, list[Diagnostic]] = {file: [] for file in files}
    for finding in findings:
        by_file.setdefault(finding.path or _SUITE_WITHOUT_FILE, []).append(finding)
    suites = by_file or {
        _SUITE_WITHOUT_FILE: []
    }  # some readers take a report without a test for a fault
    return junit_document(name, [_junit_suite(*one, fail_on) for one in suites.items()])


def _junit_suite(file: str, findings: Sequence[Diagnostic], fail_on: FailOn) -> ET.Element:
    suite = ET.Element("testsuite", {"name": visible(file)})
    if not findings:
        junit_case(suite, _TEST_WITHOUT_FINDINGS)
    named: dict[str, int] = {}
    for finding in findings:
        about = " ".join(word for word in (finding.code, finding.place) if word)
        test = f"{about}: {finding.message}"
        named[test] = count = named.get(test, 0) + 1
        one = junit_case(suite, test if count == 1 else f"{test} ({count})")
        if fail_on.counts(finding):
            mark_failed(one, "failure", finding.code, finding.message, [finding])
        else:
            said = f"{finding.message}: {finding.cure}" if finding.cure else finding.message
            mark_skipped(one, f"{finding.severity}: {said}")
    return suite


def _finding_lines(finding: Diagnostic) -> Iterable[str]:
    where = finding.where()
    yield f"{finding.code} {finding.severity}{f' {where}' if where else ''}: {finding.message}"
    if finding.cure:
        yield f"  = {finding.cure}"
