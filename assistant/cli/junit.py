"""A deployment to many controllers as JUnit XML, which pipelines show as the results of tests.

A suite a controller, in it a test a program and one of the deployment itself.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from typing import Final

from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.source_text import visible
from assistant.deploy import CellState, FileState, Outcome, Rollout
from assistant.findings.formats import junit_case, junit_document, mark_failed, mark_skipped

SUITE_NAME: Final = "robot-assistant deploy"
DEPLOYMENT_TEST: Final = "deployment"
"""The test that a deployment as a whole is."""
INSTALLED_STATES: Final = (FileState.SAME, FileState.INSTALLED)


def junit_report(rollout: Rollout) -> bytes:
    """The report, whole; well-formed whatever names and messages hold."""
    return junit_document(
        SUITE_NAME,
        [_controller_suite(one) for one in rollout.outcomes],
        _total_seconds(rollout.outcomes),
    )


def _controller_suite(one: Outcome) -> ET.Element:
    suite = ET.Element("testsuite", {"name": visible(one.name), "time": _total_seconds([one])})
    properties = ET.SubElement(suite, "properties")
    told = {"address": str(one.address), "state": str(one.state)}
    if one.deployment is not None and one.deployment.folder is not None:
        told["kept in"] = str(one.deployment.folder)
    for key, value in told.items():
        ET.SubElement(properties, "property", {"name": key, "value": visible(value)})
    for program in one.plan.files if one.plan else ():
        state = one.deployment.states.get(program.name) if one.deployment else None
        test = junit_case(suite, program.name)
        if one.state is CellState.NOT_BEGUN or (state is None and one.deployment is None):
            mark_skipped(test, str(CellState.NOT_BEGUN))
        elif state not in INSTALLED_STATES:
            about = [f for f in one.findings if f.place == program.name]
            _add_failure(test, "failure", str(state), about)
    test = junit_case(suite, DEPLOYMENT_TEST)
    if one.state is CellState.NOT_BEGUN:
        mark_skipped(test, "; ".join(finding.message for finding in one.findings))
    elif one.state is CellState.FAILED:
        errors = [f for f in one.findings if f.severity is Severity.ERROR]
        said = errors[0].message if errors else str(one.state)
        _add_failure(test, "error" if one.status > 1 else "failure", said, one.findings)
    return suite


def _add_failure(test: ET.Element, kind: str, said: str, findings: Sequence[Diagnostic]) -> None:
    codes = [f.code for f in findings if f.severity is Severity.ERROR]
    mark_failed(test, kind, codes[0] if codes else "deployment", said, findings)


def _total_seconds(outcomes: Iterable[Outcome]) -> str:
    return f"{sum(one.seconds for one in outcomes):.3f}"
