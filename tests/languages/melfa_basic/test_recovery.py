"""Damaged lines: what is said about them, and that nothing else is."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.languages.melfa_basic.reading.mistakes import MISTAKES, foreign_words
from assistant.languages.melfa_basic.rules import SYNTAX
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.recovery.mistakes import Slip
from tests.examples import drawn
from tests.tables import every_row

FIVE = languages.get("melfa-basic-5")


@every_row("mistake", MISTAKES)
def test_usual_mistakes(mistake: Slip) -> None:
    before, _, behind = mistake.example.replace("{{", "{").replace("}}", "}").partition("¦")
    tree = FIVE.parse(before + behind + "\r\n")
    (finding,) = tree.findings
    assert finding.column == len(before) + 1
    assert mistake.cure.partition("{")[0] in finding.cure
    assert finding.code == (mistake.rule or SYNTAX).code
    assert not isinstance(tree.items[0], s.Unread)
    assert FIVE.render(tree) == before + behind + "\r\n"


@every_row("word", sorted(foreign_words()))
def test_words_of_other_languages(word: str) -> None:
    _, cure = foreign_words()[word]
    tails = ["", " M1", " P1", " M1=1", " 1,0", ' "A"', " M1=1 Then"]
    said = [FIVE.parse(f"10 {word}{tail}\r\n").findings for tail in tails]
    first = [findings[0] for findings in said if findings]
    assert (4, cure) in [(finding.column, finding.cure) for finding in first]


@every_row(
    ("line", "said", "cure"),
    [
        ("10 If M1=1 ¦Mov P1", "`Then` is missing", "write `Then`"),
        ("10 If (M1=1 And M2=2 ¦Then Mov P1", "`)` is missing", "take out the `(`"),
        ("10 M1=(M2+3)¦)*2", "`)` has no `(`", "take it out"),
        ("10 M1=Abs(M¦2", "`)` is missing", "write it"),
        ("10 Mvr P1 ¦P2,P3", "comma is missing", "write `,`"),
        ("10 For M1=1 ¦5", "`To` is missing", "first and last value"),
        ("10 M1¦=", "value is missing", "a number or a variable"),
        ("10 If ¦Then", "value is missing", "a number or a variable"),
        ("10 Mov P1 Wt¦h", "statement is missing", "what is to be done"),
        ("10 ¦Selct M1", "is it `Select`?", "write `Select`"),
        ("10 ¦Iff M1=1 Then *A", "is it `If`?", "write `If`"),
        ("10 If M1=1 ¦Thn *A", "is it `Then`?", "write `Then`"),
        ("10 If M1=1 Then *A ¦Esle *B", "is it `Else`?", "write `Else`"),
        ("10 Mvs P1 ¦With M_Out(1)=1", "is it `Wth`?", "write `Wth`"),
        ("10 ¦HOpne 1", "is it `HOpen`?", "write `HOpen`"),
        ("10 Def ¦Inteer X", "is it `Inte`?", "write `Inte`"),
        ("10 ¦EndIff", "is it `EndIf`?", "write `EndIf`"),
        ("10 ¦MOVP1", "no blank behind `MOV`", "write a blank"),
        ("10 ¦DLY5", "no blank behind `DLY`", "write a blank"),
        ("10 M1=3 ¦M2=4", "one statement", "`M2=4` on a line of its own"),
        ("10 Mov P1 ¦approach the part", "text stands behind", "write `'`"),
        ("10 ¦This is only text", "this is text", "write `'`"),
        ("10 ¦End While", "no word of MELFA-BASIC", "write `WEnd`"),
        ("10 ¦MoveL P1", "no word of MELFA-BASIC", "write `Mvs`"),
        ("10 M1=1" + "0" * 400, "number is too large", "that a variable can hold"),
    ],
)
def test_what_is_said(line: str, said: str, cure: str) -> None:
    before, mark, behind = line.partition("¦")
    tree = FIVE.parse(before + behind)
    (finding,) = tree.findings
    assert said in finding.message
    assert cure in finding.cure
    assert not mark or finding.column == len(before) + 1


def test_several_findings_of_a_line() -> None:
    tree = FIVE.parse("10 If M1==1 Mov P1 Else GoTo Again\r\n20 M1=M2[3]+(M4\r\n")
    assert [(f.line, f.column) for f in tree.findings] == [
        (1, 10),
        (1, 13),
        (1, 30),
        (2, 9),
        (2, 15),
    ]
    first, second = tree.items
    assert isinstance(first, s.Line)
    assert first.number == 10
    assert isinstance(first.statement, s.If)
    assert first.statement.otherwise == s.Jump("GoTo", s.Target("Again"))
    assert isinstance(second, s.Line)
    assert isinstance(second.statement, s.Assign)


DAMAGED_BLOCKS = """\
1 While M1=1 Do
2   If M_In(3)==1 Thn
3     Again: Mov P1;
4   EndIf
5   Selct M1
6   Case 1:
7     Mvs P1 ‘slowly
8   Break
9   End Select
10 Wend
11 For M2=1 5
12 Next
13 GoTo *Again
P1=(+1.00,+2.00,+3.00,+180.00,+0.00,+180.00)(7,0
"""


def test_a_damaged_line_makes_no_findings_elsewhere() -> None:
    tree = FIVE.parse(DAMAGED_BLOCKS)
    assert FIVE.render(tree) == DAMAGED_BLOCKS
    damaged = [1, 2, 3, 5, 6, 7, 11, 14]
    assert sorted({f.line or 0 for f in tree.findings}) == damaged
    assert {f.line for f in FIVE.check([tree]) if f.severity.value == "error"} <= {*damaged}


def test_places_in_mended_lines_are_those_of_the_text() -> None:
    text = "10 If  M1==1  Thn GoTo  Again\r\n"
    line = FIVE.parse(text).items[0]
    assert isinstance(line, s.Line)
    assert isinstance(line.statement, s.If)
    jump, condition = line.statement.then, line.statement.condition
    assert isinstance(condition, s.Binary)
    assert isinstance(condition.left, s.Variable)
    assert condition.left.span is not None
    assert text[condition.left.span.start : condition.left.span.end] == "M1"
    assert isinstance(jump, s.Jump)
    assert jump.target.span is not None
    assert text[jump.target.span.start : jump.target.span.end] == "Again"


PIECES = """( ) = , ; : * # & $ ' " < > + - / ^ . [ ] { } ! | ‘ ” ~ If_ Then_ Mov_ P1 M1 _10_
(1,2) Wth_ Rem_ GoTo_ *L Else_ Def_ Inte_ EndIf End_ For_ To_ x Print_"""
pieces = st.sampled_from(
    [piece.replace("_", " ").replace("~", "\u3000") for piece in PIECES.split()]
)


@given(st.lists(pieces, max_size=25).map("".join))
@settings(max_examples=drawn(300), deadline=None)
def test_any_line_is_kept_and_placed(line: str) -> None:
    tree = FIVE.parse(line)
    assert FIVE.render(tree) == line
    for finding in tree.findings:
        assert finding.line == 1
        assert finding.column is not None
        assert 1 <= finding.column <= max(len(line), 1)
        assert finding.cure


@pytest.mark.parametrize("line", ["M1=" + "(" * 500, "M1=" + "1+" * 400 + "1", "M1=" + "-" * 999])
def test_endless_lines_are_refused(line: str) -> None:
    tree = FIVE.parse(line)
    assert len(tree.findings) == 1
    assert isinstance(tree.items[0], s.Unread)


def test_every_line_of_a_text_that_is_no_program_is_found() -> None:
    text = "".join(f"{number} Mvs P1 P{number}\r\n" for number in range(1, 701))
    tree = FIVE.parse(text)
    assert FIVE.render(tree) == text
    assert [finding.line for finding in tree.findings] == list(range(1, 701))
    assert "comma is missing" in tree.findings[0].message
    assert tree.findings[-1].column == 12


@pytest.mark.parametrize(
    ("line", "plain"),
    [
        ("Mvs P1 ‘go to “there”", "Mvs P1 'go to “there”"),
        ("CallP “SUB”", 'CallP "SUB"'),
        ("Mvs P1\u3000Wth M_Out(1)=1", "Mvs P1 Wth M_Out(1)=1"),
        ("Mov P1,–50 ’up", "Mov P1,-50 'up"),
        ("Error 9100\tRaises an error.", "Error 9100\t'Raises an error."),
        ("GoTo *A\t\t.", "GoTo *A\t\t'."),
    ],
)
def test_what_is_certainly_meant_is_read_by_other_languages(line: str, plain: str) -> None:
    melfa = FIVE
    broken = melfa.parse(f"{line}\nEnd\n")
    assert has_errors(broken.findings)
    assert melfa.render(broken).startswith(line)
    read = melfa.mended(broken)
    assert read is not None
    assert melfa.render(read) == f"{plain}\nEnd\n"
    assert [f.code for f in read.findings] == [f.code for f in broken.findings]
    assert not has_errors(read.findings)


@pytest.mark.parametrize("line", ["CallP “SUB", "Mvs P1 ‘go\nMvs P2 P3", "Mov P1 go there"])
def test_what_may_mean_something_else_stays_broken(line: str) -> None:
    melfa = FIVE
    assert melfa.mended(melfa.parse(f"{line}\nEnd\n")) is None
