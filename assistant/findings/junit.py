"""JUnit XML, which pipelines show as the results of tests.

Elements and attributes are those that Jenkins' `junit-10.xsd` (xunit-plugin) and GitLab's reports
know. The document is ASCII, so that no terminal and no pipe changes it; characters of names and
messages that no XML may hold, or that steer a terminal, are marks in it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from typing import Final

from assistant.findings.fail_on import FailOn
from assistant.program.diagnostics import Diagnostic
from assistant.program.visible import visible

JUNIT_COUNTS: Final = {"failures": "failure", "errors": "error", "skipped": "skipped"}
"""What a suite counts, and the element that stands in a test of it."""
SUITE_WITHOUT_FILE: Final = "robot-assistant"
"""The suite of findings that are about no file."""
TEST_WITHOUT_FINDINGS: Final = "check"
"""The test of a file that nothing was found in."""


def junit_document(name: str, suites: Sequence[ET.Element], time: str | None = None) -> bytes:
    """The report, whole; well-formed whatever names and messages hold. time: seconds."""
    root = ET.Element("testsuites", {"name": name, **({} if time is None else {"time": time})})
    for one in suites:
        one.set("tests", str(len(one.findall("testcase"))))
        for key, element in JUNIT_COUNTS.items():
            one.set(key, str(len(one.findall(f"testcase/{element}"))))
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(one.get(key, "0")) for one in suites)))
    root.extend(suites)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="us-ascii", xml_declaration=True)
    return text + b"\n"


def junit_case(suite: ET.Element, name: str) -> ET.Element:
    """A test of a suite that passes as long as nothing else is said of it."""
    given = {"classname": suite.get("name", ""), "name": visible(name)}
    return ET.SubElement(suite, "testcase", given)


def mark_skipped(case: ET.Element, why: str) -> None:
    ET.SubElement(case, "skipped", {"message": visible(why)})


def mark_failed(
    case: ET.Element, kind: str, code: str, said: str, findings: Iterable[Diagnostic]
) -> None:
    """kind: `failure` or `error`. code: the type of the failure. findings: what is told of it."""
    element = ET.SubElement(case, kind, {"type": code, "message": visible(said)})
    element.text = "\n".join(visible(line) for f in findings for line in _finding_lines(f))


def junit_report(
    findings: Sequence[Diagnostic], files: Iterable[str], fail_on: FailOn, name: str
) -> bytes:
    """A suite a file, in it a test a finding; a file without one is a test that passes.

    files: all that were looked at. Findings for which the command does not fail are skipped
    tests. What lies at other lines is the same test, so that pipelines tell what is new.
    """
    by_file: dict[str, list[Diagnostic]] = {file: [] for file in files}
    for finding in findings:
        by_file.setdefault(finding.path or SUITE_WITHOUT_FILE, []).append(finding)
    suites = by_file or {
        SUITE_WITHOUT_FILE: []
    }  # some readers take a report without a test for a fault
    return junit_document(name, [_junit_suite(*one, fail_on) for one in suites.items()])


def _junit_suite(file: str, findings: Sequence[Diagnostic], fail_on: FailOn) -> ET.Element:
    suite = ET.Element("testsuite", {"name": visible(file)})
    if not findings:
        junit_case(suite, TEST_WITHOUT_FINDINGS)
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
