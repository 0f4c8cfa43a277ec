"""Names from outside become identifiers; programs give their statements in order."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from assistant.program.expressions import Number, Truth
from assistant.program.program import IDENTIFIER, Procedure, Program, bodies, identifier, walk
from assistant.program.statements import (
    Branch,
    Case,
    Comment,
    For,
    If,
    Label,
    Statement,
    Switch,
    While,
)
from tests import strategies
from tests.tables import every_row


@every_row(
    ("given_", "name"),
    [
        ("seam", "seam"),
        ("Glue line 1", "Glue_line_1"),
        ("1st", "n_1st"),
        ("", "unnamed"),
        ('x"; Stop; !', "x_Stop"),
        ("a\nb", "a_b"),
        ("Klebenaht-ü", "Klebenaht_ue"),
        ("Außenkontur", "Aussenkontur"),
        ("KLEBEN_ÄÖÜß", "KLEBEN_AEOEUESS"),
        ("a\u0308ußere", "aeussere"),
        ("Pièce à découper", "Piece_a_decouper"),
        ("Żółw", "Zolw"),
        ("穴", "Xue"),
        ("外形 2", "WaiXing_2"),
        ("シール", "shiiru"),
        ("ふち", "fuchi"),
        ("Внешний контур", "Vneshniy_kontur"),
        ("КОНТУР Ж", "KONTUR_ZH"),
        ("Εξωτερικό", "Exoteriko"),
        ("Ø 12 × 3", "D12_3"),
        ("\u200b", "unnamed"),
        ("___", "unnamed"),
        ("_a_", "a"),
        ("a__b", "a__b"),
    ],
)
def test_a_name_becomes_an_identifier_close_to_it(given_: str, name: str) -> None:
    assert identifier(given_) == name


def test_a_taken_name_gets_a_number() -> None:
    assert identifier("Seam", {"seam"}) == "Seam_2"
    assert identifier("seam", {"SEAM", "Seam_2"}) == "seam_3"


@given(st.text(max_size=100), st.sets(st.text(max_size=5), max_size=5))
def test_every_text_gives_a_free_identifier(text: str, taken: set[str]) -> None:
    name = identifier(text, taken)
    assert IDENTIFIER.fullmatch(name)
    assert name.isascii() and len(name) <= 68
    assert name.lower() not in {t.lower() for t in taken}
    assert identifier(name) == name.strip("_") or len(name) > 64


def test_statements_come_in_the_order_of_the_text() -> None:
    def said(name: str) -> Statement:
        return Label(name)

    body = (
        said("a"),
        If((Branch(Truth(True), (said("b"), While(Truth(True), (said("c"),)))),), (said("d"),)),
        Switch(Number(1), (Case((Number(1),), (said("e"),)),), (said("f"),)),
        For("i", Number(1), Number(2), (said("g"),)),
        Comment("end"),
    )
    labels = [s.name for s in walk(body) if isinstance(s, Label)]
    assert labels == list("abcdefg")
    program = Program("p", (Procedure("one", body), Procedure("Two", (said("h"),))))
    assert [s.name for s in program.statements() if isinstance(s, Label)] == list("abcdefgh")
    assert program.procedure("TWO") is program.procedures[1]
    assert program.procedure("three") is None


@given(strategies.statements())
def test_walking_visits_a_statement_and_what_it_holds(statement: Statement) -> None:
    visited = list(walk((statement,)))
    assert visited[0] is statement
    inner = [s for held in bodies(statement) for s in walk(held)]
    assert [id(s) for s in visited[1:]] == [id(s) for s in inner]
