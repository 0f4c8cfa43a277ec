"""Findings: where they are, how bad, and folded when there are many."""

from __future__ import annotations

import pytest

from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    Span,
    Unreadable,
    fold,
    has_errors,
    worst,
)

RULE = Rule("XX101", Severity.WARNING, "`{name}` is odd", "rename `{name}`")


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        ({"path": "a.mod", "line": 3, "column": 7}, "a.mod:3:7"),
        ({"path": "a.dxf", "place": "LINE 2F"}, "a.dxf LINE 2F"),
        ({"path": "a.csv", "line": 3, "place": "x"}, "a.csv:3 x"),
        ({"line": 3, "column": 7}, "3:7"),
        ({"place": "row 5"}, "row 5"),
        ({}, ""),
    ],
)
def test_a_finding_says_where(fields: dict[str, object], where: str) -> None:
    assert RULE(name="n", **fields).where() == where  # type: ignore[arg-type]


def test_a_rule_fills_in_its_fields() -> None:
    finding = RULE(path="a", span=Span(1, 2), excerpt="x", name="{odd}")
    assert finding == Diagnostic(
        "XX101",
        Severity.WARNING,
        "`{odd}` is odd",
        "rename `{odd}`",
        path="a",
        span=Span(1, 2),
        excerpt="x",
    )
    assert RULE(name="n", severity=Severity.ERROR).severity is Severity.ERROR
    with pytest.raises(KeyError):
        RULE()


def test_a_finding_keeps_the_file_that_it_names() -> None:
    assert RULE(name="n").within("b").path == "b"
    assert RULE(name="n", path="a").within("b").path == "a"
    assert RULE(name="n").within(None).path is None


def test_the_worst_comes_first() -> None:
    info, warning, error = (RULE(name="n", severity=s) for s in reversed(Severity))
    assert worst([info, error, warning]) is Severity.ERROR
    assert worst([info, warning]) is Severity.WARNING
    assert worst([]) is None
    assert has_errors([info, error]) and not has_errors([info, warning])


def test_equal_findings_are_folded_with_a_count_and_the_first_places() -> None:
    many = [RULE(name="n", path="a", place=f"row {i}") for i in range(1, 121)]
    other = RULE(name="m", path="a", line=4)
    (folded, rest) = fold([*many, other])
    assert folded.place == "120 times: row 1, row 2, row 3 and 117 more"
    assert folded.message == many[0].message
    assert rest == other
    lines = fold([RULE(name="n", line=i) for i in (4, 9)])
    assert [f.place for f in lines] == ["2 times: line 4, line 9"]
    assert fold([RULE(name="n", path=p) for p in "ab"])[0].path == "a"
    assert len(fold([RULE(name="n", path=p) for p in "ab"])) == 2
    assert fold([RULE(name="n"), RULE(name="n")])[0].place is None


def test_refusing_carries_the_findings() -> None:
    refused = Refused(RULE(name="n", path="a", line=1), RULE(name="m"))
    assert isinstance(refused, ValueError)
    said = "XX101 a:1: `n` is odd (rename `n`); XX101: `m` is odd (rename `m`)"
    assert str(refused) == said
    assert (refused.exit_status, len(refused.findings)) == (1, 2)
    assert Unreadable(RULE(name="n")).exit_status == 2
    assert Refused(RULE(name="n"), exit_status=2).exit_status == 2
