"""Text to tree and back: identity of each construct, tables, damaged input."""

from __future__ import annotations

import re
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.languages.melfa_basic.reading.line import TooLarge, read_line
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.line_tables import gathered, rows_as_lines
from assistant.languages.recovery.syntax import Stop
from tests.examples import drawn
from tests.tables import every_row

FIXTURES = FilePath(__file__).parent / "fixtures"
IDENTITY = (FIXTURES / "identity.txt").read_text().splitlines()
FIVE = languages.get("melfa-basic-5")


@every_row("line", IDENTITY)
def test_identity(line: str) -> None:
    tree = FIVE.parse(line + "\n")
    assert not tree.findings
    assert FIVE.render(tree) == line + "\n"
    again = FIVE.parse(FIVE.format(tree))
    assert again.items == tree.items
    assert FIVE.format(again) == FIVE.format(tree)


def test_identity_of_all_lines_together() -> None:
    for newline in ("\n", "\r\n"):
        text = newline.join(IDENTITY)
        tree = FIVE.parse(text)
        assert FIVE.render(tree) == text


@every_row(
    ("line", "column"),
    [
        ("10 MOV P1 P2", 11),
        ("20 M1=(1+2", 11),
        ("30 IF M1=1 THE *L", 12),
        ("40 \x01", 4),
        ("50 M1=3;M2=4", 8),
        ("60 C1$=“text”", 8),
        ("70 DEF", 7),
    ],
)
def test_bad_line_is_one_finding(line: str, column: int) -> None:
    text = f"5 MOV P1\r\n{line}\r\n99 END\r\n"
    tree = FIVE.parse(SourceText(text, "bad.prg"))
    (finding,) = tree.findings
    assert finding.line == 2
    assert abs((finding.column or 0) - column) <= 1
    assert finding.excerpt == line
    assert finding.path == "bad.prg"
    assert finding.cure
    assert "42" in finding.message or "43" in finding.message
    assert FIVE.render(tree) == text
    assert len(tree.items) == 3


def test_tokenised_file_is_named() -> None:
    tree = FIVE.parse("ROBPRG\x00\x01\x02")
    (finding,) = tree.findings
    assert finding.code == "MB001"
    assert FIVE.render(tree) == "ROBPRG\x00\x01\x02"


@given(st.lists(st.sampled_from(IDENTITY), max_size=30))
@settings(max_examples=drawn(60), deadline=None)
def test_any_lines_are_checked_and_lifted(lines: list[str]) -> None:
    text = "\r\n".join(lines)
    tree = FIVE.parse(text)
    assert FIVE.render(tree) == text
    FIVE.check([tree])
    FIVE.lift(tree)


# ------------------------------------------------------------------------------ tables


def by_grammar(text: str) -> list[s.Item]:
    """What the grammar alone makes of each line."""
    at, items = 0, []
    for line in re.findall(r"[^\n]*\n|[^\n]+", text):
        bare = line.rstrip("\r\n")
        node = read_line(text, at, at + len(bare), at + len(line))
        items.append(s.Unread(bare) if isinstance(node, Stop | TooLarge) else node)
        at += len(line)
    return items


def expanded(items: tuple[s.Item, ...]) -> list[s.Item]:
    made: list[s.Item] = []
    for item in items:
        made += rows_as_lines(item) if isinstance(item, PositionRows | MoveRows) else [item]
    return made


def as_code(item: s.Item) -> s.Item:
    """A variable line as the assignment that it looks like."""
    if isinstance(item, s.Data) and not item.type:
        return s.Line(statement=s.Assign(item.variable, item.value))
    return item


def same_as_grammar(text: str) -> None:
    tree = parse(text, "melfa-basic-5")
    for item, line in zip(expanded(tree.items), by_grammar(text), strict=True):
        assert isinstance(line, s.Unread) or as_code(item) == line


stems = st.sampled_from(["P", "PA", "p", "P_"])
reals = st.one_of(
    st.floats(-1e6, 1e6).map(lambda v: f"{v:+.2f}"),
    st.integers(-999, 999).map(str),
    st.sampled_from(["", "1.", "-.5", "1e3", "+0.0000001", "99999999999.5"]),
)
flags = st.sampled_from(["(7,0)", "(6,1048576)", "(7,&H00F00000)", "(,)", "", "(7,-1)"])


@st.composite
def rows(draw: st.DrawFn) -> str:
    """Position lines and moves of which some are odd."""
    stem, lines = draw(stems), []
    for number in range(draw(st.integers(1, 6))):
        if draw(st.booleans()):
            values = (
                ["+1.00"] * 6
                if draw(st.booleans())
                else draw(st.lists(reals, min_size=2, max_size=8))
            )
            flag = draw(flags) if draw(st.integers(0, 3)) == 0 else "(7,0)"
            blank = draw(st.sampled_from(["", "", " ", "\t "]))
            listed = f"{blank},{blank}".join(values)
            lines.append(f"{stem}{number}{blank}={blank}({blank}{listed}){blank}{flag}{blank}")
        else:
            word = draw(st.sampled_from(["MOV", "Mvs", "mvr"]))
            ends = f"{stem}{number}"
            if word == "mvr" or draw(st.integers(0, 9)) == 0:
                ends += f",{stem}{number + 1},{stem}{number + 2}"
            lines.append(f"{number + 1} {word}  {ends}")
    newline = draw(st.sampled_from(["\n", "\r\n"]))
    return newline.join(lines) + draw(st.sampled_from(["", newline]))


@given(rows())
@settings(max_examples=drawn(200), deadline=None)
def test_tables_mean_what_the_grammar_says(text: str) -> None:
    same_as_grammar(text)


@given(rows(), st.integers(0, 200), st.sampled_from("(),.=+-PM1 'x\n"))
@settings(max_examples=drawn(200), deadline=None)
def test_damaged_tables_mean_what_the_grammar_says(text: str, at: int, mark: str) -> None:
    at = min(at, len(text))
    same_as_grammar(text[:at] + mark + text[at + 1 :])


def test_rows_stay_columns() -> None:
    n = 5000
    rng = np.random.default_rng(0)
    kinds = rng.integers(0, 3, n)
    number = np.arange(1, n + 1)
    arc = kinds == 2
    moves = MoveRows("P", number, kinds, np.where(arc, 3, -1), np.where(arc, 4, -1), number)
    values = np.round(rng.uniform(-999, 999, (n, 7)), 2)
    table = PositionRows("P", number, values, np.tile([7, 1048576], (n, 1)))
    tree = s.File("melfa-basic-5", (moves, table))
    again = FIVE.parse(FIVE.render(tree))
    assert [type(item) for item in again.items] == [MoveRows, PositionRows]
    assert again.items == tree.items
    assert list(gathered(expanded(tree.items))) == list(tree.items)


def test_changed_item_is_printed_anew() -> None:
    text = "1  Mov   P1 ' go\r\n2 Mvs P2\r\nP1=(1,2,3,0,0,0)(7,0)"
    tree = FIVE.parse(text)
    line = s.Line(2, None, s.Command("Dly", (s.Number(0.5),)))
    changed = s.File(
        tree.dialect, (tree.items[0], line, *tree.items[2:]), (), tree.source, tree.parsed
    )
    assert FIVE.render(changed) == "1  Mov   P1 ' go\r\n2 Dly 0.5\r\nP1=(1,2,3,0,0,0)(7,0)"


@pytest.mark.parametrize("encoding", ["utf-8", "cp932"])
def test_encodings(encoding: str) -> None:
    data = "10 ' ロボット\r\n20 END\r\n".encode(encoding)
    source = FIVE.decode(data)
    tree = FIVE.parse(source)
    assert FIVE.encode(tree) == data


def test_position_list() -> None:
    text = "DEF POS P1=(-11.06,-228.23,333.95,201.45,180.14,0.00)(6,0)\r\n" * 2
    language = languages.of_file("points.pos", text.encode())
    assert language is not None
    assert language.name == "melfa-basic-4"
    tree = language.parse(text)
    assert not tree.findings
    program = language.lift(tree)
    assert program.entry is None
    assert program.targets["P1"].pose.position == (-11.06, -228.23, 333.95)
