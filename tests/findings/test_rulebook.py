"""The book of rules: every code once, and pages whose examples have what they tell of."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path
from string import Formatter

import pytest

from assistant.base.diagnostics import Refused, Rule, Severity
from assistant.cell.cell_file import read_scene
from assistant.compiler import check_files
from assistant.findings.rulebook import (
    adjustable,
    codes,
    cure_in_general,
    explain,
    families,
    page_address,
    pages,
    rule_of,
    rules,
    section,
)
from assistant.report.scenes import record

SUFFIXES = {"RA": ".mod", "MB": ".prg", "CK": ".pseudo", "PS": ".pseudo"}
CELLS = "CK4"
"""What the codes begin with whose examples are cell files."""


def found(folder: Path, code: str, text: str) -> set[str]:
    """Codes of what is found in a text of the language that a code is about, or a cell file."""
    if code.startswith(CELLS):
        return found_in_cell(folder, text)
    file = folder / f"example{SUFFIXES[code[:2]]}"
    file.write_text(text, encoding="utf-8")
    return {finding.code for finding in check_files([file]).findings}


def found_in_cell(folder: Path, text: str) -> set[str]:
    file = folder / "cell.toml"
    file.write_text(text, encoding="utf-8")
    try:
        scene, findings = read_scene(file)
        record(scene)
    except Refused as refused:
        findings = refused.findings
    return {finding.code for finding in findings}


def test_every_rule_is_of_a_known_family() -> None:
    assert {code[:2] for code in rules()} == set(families())


def test_a_rule_is_found_by_its_code_alone() -> None:
    assert codes() == set(rules())
    assert {code: rule_of(code) for code in codes()} == rules()
    assert rule_of("RA000") is None


def test_a_page_needs_no_other_room() -> None:
    """What a drawing or a language brings takes seconds to be imported."""
    rooms = ("assistant.compiler", "assistant.robots", "ezdxf", "matplotlib", "scipy", "lsprotocol")
    script = (
        "import sys; from assistant.cli import main\n"
        "try: main(['explain', 'CN301'])\n"
        f"except SystemExit as end: print(end.code, {{*sys.modules}} & {{*{rooms}}})"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert said.stdout.endswith("0 set()\n"), said


def test_no_rule_takes_the_name_of_another() -> None:
    """The one above would be lost, and what finds it would say the one below."""
    package = Path(inspect.getfile(Rule)).parents[1]
    for file in package.rglob("*rules.py"):
        names = re.findall(
            r"^([A-Z_]+)(?:: Final)? = (?:error|warning|info)\(", file.read_text("utf-8"), re.M
        )
        assert len(names) == len(set(names)), file


def test_there_are_pages_for_rules_only() -> None:
    assert pages()
    assert set(pages()) <= set(rules())


@pytest.mark.parametrize("code", sorted(code for code, page in pages().items() if page.example))
def test_an_example_has_its_finding_and_what_is_better_has_not(code: str, tmp_path: Path) -> None:
    page = pages()[code]
    assert code in found(tmp_path, code, page.example)
    assert code not in found(tmp_path, code, page.better)
    assert page.better


def test_what_is_better_has_no_error(tmp_path: Path) -> None:
    bad = {
        code: found(tmp_path, code, page.better) for code, page in pages().items() if page.better
    }
    errors = {
        code: left
        for code, codes in bad.items()
        if (left := {c for c in codes if rules()[c].severity is Severity.ERROR})
    }
    assert errors == {}


def test_a_page_tells_severity_cure_and_example() -> None:
    page = section(rules()["RA204"])
    assert page.startswith("### RA204\n\n**error**: unknown speed `NAME`\n")
    assert "What to do: write NEAR" in page
    assert "MoveL p1, v25, fine, tool0;" in page
    assert page_address("RA204").endswith("docs/findings.md#ra204")
    assert explain(["ra204"]) == page


def test_what_to_do_is_said_in_words() -> None:
    told = {code: cure_in_general(rule) for code, rule in rules().items()}
    assert {
        code: cure for code, cure in told.items() if cure and not re.search("[a-z]", cure)
    } == {}


def test_the_page_says_what_to_do_where_each_finding_has_a_cure_of_its_own() -> None:
    assert "What to do: give the work its place: `position`" in explain(["CO340"])
    assert "What to do: read both" in explain(["RA306"])
    assert "What to do: follow the cure below the message" in explain(["CO002"])


def test_a_code_that_is_none_is_refused() -> None:
    with pytest.raises(Refused) as refused:
        explain(["RA204", "RA000", "x"])
    assert [f.code for f in refused.value.findings] == ["FN001", "FN001"]
    assert refused.value.exit_status == 2


@pytest.mark.parametrize(
    ("code", "may"),
    [
        ("RA204", True),  # a check of a program that somebody wrote
        ("MB101", True),
        ("RA101", False),  # it cannot be read
        ("MB002", False),
        ("PS101", False),
        ("RA305", False),  # it cannot be said
        ("CK101", False),  # nothing is written
        ("CO101", False),
        ("RB101", False),
        ("IN001", False),
        ("RA302", True),  # a warning
        ("CO302", True),  # an info
    ],
)
def test_which_findings_a_project_may_turn_down(code: str, may: bool) -> None:
    assert adjustable(rules()[code]) is may


def test_fields_are_shown_in_capitals() -> None:
    rule = Rule("XX001", Severity.INFO, "`{name}` is {off:.2f} {{away}}")
    assert rule.sentence(rule.message) == "`NAME` is OFF {away}"


def test_what_only_some_findings_add_is_not_shown() -> None:
    rule = Rule("XX001", Severity.INFO, "{count} cell{s} in [0]{hint} {place}{more}; mend it")
    assert rule.sentence(rule.message) == "COUNT cell in [0] PLACE; mend it"


def test_no_field_of_a_message_is_called_like_what_every_finding_has() -> None:
    taken = set(inspect.signature(Rule.__call__).parameters)
    for rule in rules().values():
        parts = (*Formatter().parse(rule.message), *Formatter().parse(rule.cure))
        assert taken.isdisjoint(field for _, field, _, _ in parts if field), rule.code
