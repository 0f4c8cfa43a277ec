"""A deployment to many controllers as JUnit XML, which pipelines show as the results of tests.

A suite a controller, in it a test a program and one of the deployment itself. Elements and
attributes are those that Jenkins' `junit-10.xsd` (xunit-plugin) and GitLab's reports know.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from typing import Final

from assistant.cli.presentation import visible
from assistant.deploy import CellState, FileState, Outcome, Rollout
from assistant.program.diagnostics import Diagnostic, Severity

NAME: Final = "robot-assistant deploy"
WHOLE: Final = "deployment"
"""The test that a deployment as a whole is."""
THERE: Final = (FileState.SAME, FileState.INSTALLED)
COUNTED: Final = {"failures": "failure", "errors": "error", "skipped": "skipped"}
"""What a suite counts, and the element that stands in a test of it."""


def junit(rollout: Rollout) -> bytes:
    """The report, whole; well-formed whatever names and messages hold."""
    suites = [_suite(one) for one in rollout.outcomes]
    root = ET.Element("testsuites", {"name": NAME, "time": _seconds(rollout.outcomes)})
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in suites)))
    root.extend(suites)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _suite(one: Outcome) -> ET.Element:
    name = visible(one.name)
    suite = ET.Element("testsuite", {"name": name, "time": _seconds([one])})
    properties = ET.SubElement(suite, "properties")
    told = {"address": str(one.address), "state": str(one.state)}
    if one.deployment is not None and one.deployment.folder is not None:
        told["kept in"] = str(one.deployment.folder)
    for key, value in told.items():
        ET.SubElement(properties, "property", {"name": key, "value": visible(value)})
    for program in one.plan.files if one.plan else ():
        state = one.deployment.states.get(program.name) if one.deployment else None
        case = _case(suite, name, program.name)
        if one.state is CellState.NOT_BEGUN or (state is None and one.deployment is None):
            _skipped(case, str(CellState.NOT_BEGUN))
        elif state not in THERE:
            about = [f for f in one.findings if f.place == program.name]
            _failed(case, "failure", str(state), about)
    case = _case(suite, name, WHOLE)
    if one.state is CellState.NOT_BEGUN:
        _skipped(case, "; ".join(finding.message for finding in one.findings))
    elif one.state is CellState.FAILED:
        errors = [f for f in one.findings if f.severity is Severity.ERROR]
        said = errors[0].message if errors else str(one.state)
        _failed(case, "error" if one.status > 1 else "failure", said, one.findings)
    suite.set("tests", str(len(suite.findall("testcase"))))
    for key, element in COUNTED.items():
        suite.set(key, str(len(suite.findall(f"testcase/{element}"))))
    return suite


def _case(suite: ET.Element, cell: str, name: str) -> ET.Element:
    return ET.SubElement(suite, "testcase", {"classname": cell, "name": visible(name)})


def _skipped(case: ET.Element, why: str) -> None:
    ET.SubElement(case, "skipped", {"message": visible(why)})


def _failed(case: ET.Element, kind: str, said: str, findings: Iterable[Diagnostic]) -> None:
    codes = [f.code for f in findings if f.severity is Severity.ERROR]
    element = ET.SubElement(
        case, kind, {"type": codes[0] if codes else "deployment", "message": visible(said)}
    )
    element.text = "\n".join(visible(line) for f in findings for line in _lines(f))


def _lines(finding: Diagnostic) -> Iterable[str]:
    where = finding.where()
    yield f"{finding.code} {finding.severity}{f' {where}' if where else ''}: {finding.message}"
    if finding.cure:
        yield f"  = {finding.cure}"


def _seconds(outcomes: Iterable[Outcome]) -> str:
    return f"{sum(one.seconds for one in outcomes):.3f}"
