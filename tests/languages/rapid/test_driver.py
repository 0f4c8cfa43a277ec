"""The driver of lark's tables and lark itself read every text alike, places included."""

from __future__ import annotations

import random
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lark.exceptions import UnexpectedInput

from assistant import languages
from assistant.languages.grammar import lark
from assistant.languages.lalr import Stack
from assistant.languages.rapid.reading.parser import Nodes
from assistant.languages.rapid.reading.scanner import grammar, table_words
from assistant.languages.rapid.tree import syntax as s
from assistant.resources import read_grammar
from tests.examples import drawn
from tests.languages.lark_trees import everything, node_of
from tests.languages.rapid.layouts import scattered
from tests.languages.rapid.modules import files
from tests.tables import every_row

RAPID = languages.get("rapid")
LARK = lark(read_grammar("rapid.lark"), ("start",))


def driven(text: str) -> Any:
    tables = grammar().tables["start"]
    stack = Stack(tables.first)
    read = table_words().sound(text, tables.rows, stack.states)
    if tables.drive(stack, read, Nodes(text, int, ())) is not None:
        return None
    return everything(stack.values[0])


def by_lark(text: str) -> Any:
    try:
        tree = LARK.parse(text)
    except UnexpectedInput:
        return None
    return everything(node_of(tree, Nodes(text, int, ())))


@settings(
    deadline=None,
    max_examples=drawn(60),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(files(), st.integers(0, 2**32))
def test_sound_texts_are_read_alike(tree: s.File, seed: int) -> None:
    text = RAPID.render(tree)
    assert driven(text) == by_lark(text) is not None
    chance = random.Random(seed)
    text = scattered(text, chance)
    assert driven(text) == by_lark(text) is not None
    at = chance.randrange(len(text))
    cut = text[:at] + text[at + chance.randrange(9) :]
    assert driven(cut) == by_lark(cut)


@every_row(
    "statement",
    [
        "a:=b<exp>c;",
        "a:=1.5.6;",
        "l:=:=1;",
        "a:=b//c;",
        "q ! said\n ! twice\n 1 ! again\n;",
        "IF a ! why\n b;",
        "%a%%b%;",
        "p.5:=1;",
        "a:=[[1,2],[3]];",
        "a:=[[1,2],[3],];",
        "<SMT>\n<VAR>:=<EXP>;",
        "q\\A:=1\\B?c,\\D;",
        'TPWrite "a;',
        "a:=0x1F+.5;",
    ],
)
def test_odd_statements_are_read_alike(statement: str) -> None:
    text = f"MODULE m\nPROC p()\n{statement}\nENDPROC\nENDMODULE\n"
    assert driven(text) == by_lark(text)
