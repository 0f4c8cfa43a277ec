"""Changed trees: what did not change keeps its bytes."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows, PositionRows
from tests.examples import drawn
from tests.languages.melfa_basic.files import files
from tests.languages.melfa_basic.layouts import scattered
from tests.languages.melfa_basic.statements import simple
from tests.tables import every_row

LEVELS = (4, 5, 6)
FIVE = languages.get("melfa-basic-5")


def of(level: int) -> Any:
    return languages.get(f"melfa-basic-{level}")


def with_items(tree: s.File, items: Any) -> s.File:
    return replace(tree, items=tuple(items))


@every_row(
    ("line", "statement", "after"),
    [
        ("20  Spd 100   ' slow", "Spd 50", "20  Spd 50   ' slow"),
        ("20\tmov  p1 , -50", "Mov p2,-50", "20\tmov  p2 , -50"),
        ("If ( M1 > 3 ) Then  *L", "If M1>4 Then *L", "If ( M1 > 4 ) Then  *L"),
        ("5 M1 = (M2+M3) * 2.50 Rem x", "M1=(M2+M4)*2.5", "5 M1 = (M2+M4) * 2.50 Rem x"),
        ("5 M_Out(8) = 1 dly 0.50", "M_Out(8)=0 Dly 0.5", "5 M_Out(8) = 0 dly 0.50"),
        ("5 M_Out(8) = 1", "M_Out(8)=1 Dly 0.5", "5 M_Out(8) = 1 Dly 0.5"),
        ("5 M_Out(8) = 1 Dly 2 'x", "M_Out(8)=1", "5 M_Out(8) = 1 'x"),
        ("5    Mov P1  'x", "Mvs P1", "5    Mvs P1  'x"),
        ("5    Mov P1  'x", "GoSub *L", "5    GoSub *L  'x"),
    ],
)
def test_within_a_line_only_what_changed_is_written(line: str, statement: str, after: str) -> None:
    tree = FIVE.parse(f"{line}\r\n")
    wanted = FIVE.parse(f"1 {statement}").items[0].statement
    assert (
        FIVE.render(with_items(tree, [replace(tree.items[0], statement=wanted)])) == f"{after}\r\n"
    )


@every_row(
    ("change", "after"),
    [
        ({"number": 7}, "7   *L : Mov  P1   ' go\n"),
        ({"number": None}, "  *L : Mov  P1   ' go\n"),
        ({"label": "NEW"}, "10   *NEW : Mov  P1   ' go\n"),
        ({"comment": "' gone"}, "10   *L : Mov  P1   ' gone\n"),
        ({"comment": None}, "10   *L : Mov  P1\n"),
        ({"label": None, "statement": None}, "10   ' go\n"),
        ({"statement": None, "comment": None}, "10   *L\n"),
    ],
)
def test_parts_of_a_line(change: Any, after: str) -> None:
    tree = FIVE.parse("10   *L : Mov  P1   ' go\n")
    changed = with_items(tree, [replace(tree.items[0], **change)])
    assert FIVE.render(changed) == after
    assert FIVE.parse(after) == changed


def test_a_new_line_stands_like_its_neighbours() -> None:
    tree = FIVE.parse("1 If M1=1 Then\n2   Mov  P1\n3 EndIf\n")
    new = s.Line(9, None, s.Command("Dly", (s.Number(1),)))
    first, inner, end = tree.items
    assert FIVE.render(with_items(tree, [first, new, inner, end])) == (
        "1 If M1=1 Then\n9   Dly 1\n2   Mov  P1\n3 EndIf\n"
    )
    assert FIVE.render(with_items(tree, [first, inner, end, new])).endswith("\n9 Dly 1\n")


@pytest.mark.parametrize("gone", [0, 1])
@pytest.mark.parametrize("put", [None, "Dly 1"])
def test_of_two_lines_that_say_the_same_the_one_that_is_kept_keeps_its_bytes(
    gone: int, put: str | None
) -> None:
    lines = ["1\tDef Inte\tM1 \r\n", "2  def inte M1\n"]
    tree = FIVE.parse("".join(lines))
    new = [] if put is None else [FIVE.parse(f"3 {put}").items[0]]
    items = [*tree.items]
    items[gone : gone + 1] = new
    text = FIVE.render(with_items(tree, items))
    assert lines[1 - gone] in text
    assert text.count("\n") == len(items)


@pytest.mark.parametrize("level", LEVELS)
@given(data=st.data(), seed=st.integers(0, 99))
@settings(max_examples=drawn(25), deadline=None)
def test_an_edit_keeps_all_other_bytes(level: int, data: st.DataObject, seed: int) -> None:
    language = of(level)
    text = scattered(language.render(data.draw(files(level))), random.Random(seed))
    tree = language.parse(text)
    at = data.draw(st.integers(0, len(tree.items)))
    kind = data.draw(st.sampled_from(["change", "remove", "insert"]))
    statement = data.draw(simple(level))
    old = tree.items[at] if at < len(tree.items) else None
    numbered = any(isinstance(i, s.Line) and i.number is not None for i in tree.items)
    if old is None or kind == "insert":
        items = [
            *tree.items[:at],
            s.Line(7 if numbered else None, None, statement),
            *tree.items[at:],
        ]
        start = end = len(text) if old is None else old.span.start
    else:
        new = [replace(old, statement=statement)] if isinstance(old, s.Line) else []
        items = [*tree.items[:at], *(new if kind == "change" else []), *tree.items[at + 1 :]]
        start, end = old.span.start, old.span.end
    changed = language.render(with_items(tree, items))
    assert changed.startswith(text[:start])
    assert changed.endswith(text[end:])
    again = language.parse(changed)
    if numbered and not has_errors((*tree.findings, *again.findings)):
        assert language.same(again, with_items(tree, items))


# -------------------------------------------------------------------------------- tables


def positions(n: int) -> tuple[str, s.File]:
    """Position lines in many forms, and their tree."""
    forms = ["P{0}=({0}.5,2,3,0,0,0)(7,0)\n", "P{0}=(+{0}.50,2.0,3,-0,0,0)(7,0)\r\n"]
    text = "".join(forms[k % 3 == 0].format(k) for k in range(1, n + 1))
    return text, FIVE.parse(text)


@given(st.sets(st.integers(0, 29), max_size=30), st.sets(st.integers(0, 29), max_size=29))
@settings(max_examples=drawn(50), deadline=None)
def test_rows_that_stay_keep_their_bytes(changed: set[int], gone: set[int]) -> None:
    text, tree = positions(30)
    (table,) = tree.items
    assert isinstance(table, PositionRows)
    values = table.values.copy()
    values[list(changed), 1] = -7.125
    kept = np.array([k not in gone for k in range(30)])
    new = PositionRows("P", table.numbers[kept], values[kept], table.flags[kept])
    after = FIVE.render(with_items(tree, [new])).splitlines(keepends=True)
    before = text.splitlines(keepends=True)
    assert [line for line in after if "-7.125" not in line] == [
        line for k, line in enumerate(before) if k not in changed | gone
    ]
    assert FIVE.same(FIVE.parse("".join(after)), with_items(tree, [new]))


def test_rows_move_with_their_text() -> None:
    text, tree = positions(9)
    (table,) = tree.items
    parts = [
        PositionRows("P", table.numbers[rows], table.values[rows], table.flags[rows])
        for rows in (slice(5, 9), slice(0, 4))
    ]
    note = s.Line(comment="' between")
    after = FIVE.render(with_items(tree, [parts[0], note, parts[1]]))
    lines = text.splitlines(keepends=True)
    assert after == "".join([*lines[5:9], "' between\n", *lines[:4]])


def test_moves_are_numbered_in_place() -> None:
    text = "10   mov P1\n20\tMvs P2\n30 Mvs  P3\n40   MVR P1,P2,P3\n50  Mvs P4\n"
    tree = FIVE.parse(text.replace("\t", " "))
    (table,) = tree.items
    assert isinstance(table, MoveRows)
    moved = replace(table, steps=table.steps + 95)
    assert FIVE.render(with_items(tree, [moved])) == (
        "105   mov P1\n115 Mvs P2\n125 Mvs  P3\n135   MVR P1,P2,P3\n145  Mvs P4\n"
    )
    end = table.end.copy()
    end[2] = 9
    changed = replace(table, end=end, steps=np.where(np.arange(5) == 4, 99, table.steps))
    assert FIVE.render(with_items(tree, [changed])) == (
        "10   mov P1\n20 Mvs P2\n30   Mvs P9\n40   MVR P1,P2,P3\n99  Mvs P4\n"
    )


def test_a_table_of_many_rows_is_changed_without_an_object_a_row() -> None:
    n = 40_000
    numbers = np.arange(1, n + 1)
    values = np.round(np.random.default_rng(0).uniform(-900, 900, (n, 6)), 2)
    table = PositionRows("P", numbers, values, np.tile([7, 0], (n, 1)))
    text = FIVE.render(s.File(FIVE.name, (table,)))
    tree = FIVE.parse(text)
    other = values.copy()
    other[::2, 2] = 0.25
    changed = with_items(tree, [replace(tree.items[0], values=other)])
    after = FIVE.render(changed)
    assert FIVE.parse(after).items == changed.items
    assert after.splitlines()[1::2] == text.splitlines()[1::2]
