"""What findings are about: the fields that tell it, and the words that are made of them."""

from __future__ import annotations

import pytest

from assistant.base.diagnostics import (
    Declared,
    Inner,
    Neighbours,
    NumberedMove,
    PathRow,
    Rule,
    Several,
    Severity,
    SomeTargets,
    Subject,
)
from tests.tables import every_row

ODD = Rule("XX101", Severity.WARNING, "`{name}` is odd")
GONE = Rule("XX102", Severity.ERROR, "nothing declares `{name}` beside `{other}`", misses=True)
SOME = SomeTargets("seam", 6, 9, (Neighbours(PathRow("seam", 1), PathRow("seam", 4)),), 2)


@every_row(
    ("about", "words"),
    [
        (Declared("n"), "n"),
        (Declared("n", "variables", "main"), "n"),
        (Declared("n", "variables", in_full=True), "variable n"),
        (Declared("n", "variables", "main", in_full=True), "procedure main variable n"),
        (Declared("main", "procedures", in_full=True), "procedure main"),
        (Declared("rest", "joint_targets", in_full=True), "joint target rest"),
        (PathRow("seam", 3), "seam_3"),
        (PathRow("seam", 3, in_full=True), "path seam row 3"),
        (PathRow("seam", 3, 4, in_full=True), "path seam row 3 and 4 more"),
        (NumberedMove(2, "main"), "move 2 of main"),
        (SOME, "seam: 6 of 9 targets (seam_1 to seam_4 and 2 more)"),
        (
            Several((SOME, Declared("pick")), 0),
            "seam: 6 of 9 targets (seam_1 to seam_4 and 2 more); pick",
        ),
        (Several((Declared("a"), Declared("b")), 5), "a; b; and in 5 more paths"),
        (Inner(("targets", "pick", "pose")), "targets pick pose"),
    ],
)
def test_words_are_made_of_fields(about: Subject, words: str) -> None:
    finding = ODD(name="n", path="cell.mod", about=about)
    assert (finding.about, finding.place) == (about, words)
    assert finding.where() == f"cell.mod {words}"


def test_other_input_has_words_alone() -> None:
    finding = ODD(name="n", place="header")
    assert (finding.about, finding.place) == ("header", "header")


@pytest.mark.parametrize(
    ("steps", "declared"),
    [
        (("targets", "pick", "pose"), Declared("pick", "targets")),
        (("variables", "n", "initial"), Declared("n", "variables")),
        (("procedure", "main", "variables", "n"), Declared("n", "variables", "main")),
        (("procedure", "main", "body", "1"), None),
        (("path", "seam", "row 2"), None),
        (("robot",), None),
    ],
)
def test_what_holds_an_inner_part(steps: tuple[str, ...], declared: Declared | None) -> None:
    assert Inner(steps).declared == declared


def test_a_rule_of_missing_names_gives_the_name() -> None:
    finding = GONE(name="nFar", other="nNear")
    assert finding.missing == "nFar"
    assert ODD(name="nFar").missing is None
