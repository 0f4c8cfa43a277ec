"""Random programs from dialect to dialect and back."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import zip_longest

import numpy as np
from hypothesis import HealthCheck, assume, example, given, settings

from assistant import languages
from assistant.languages.melfa_basic.convert import dialect_words
from assistant.languages.melfa_basic.convert.conversion import (
    COMPARISON_TOLERANCE,
    compared_programs,
    convert,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.control_flow import with_labelled_jumps
from assistant.languages.melfa_basic.tree.line_tables import gathered
from assistant.program.comparison import compare
from tests.examples import drawn
from tests.languages.melfa_basic.files import files

IV, V, VI = "melfa-basic-4", "melfa-basic-5", "melfa-basic-6"


def parsed(tree: s.File) -> s.File:
    language = languages.get(tree.dialect)
    return language.parse(language.render(tree))


def through(tree: s.File, *dialects: str) -> s.File | None:
    """The tree after one conversion after another, None if one is refused."""
    for dialect in dialects:
        converted = convert([tree], dialect)
        if not converted.trees:
            assert converted.findings
            return None
        (tree,) = converted.trees
        assert not tree.findings, [languages.get(dialect).render(tree), tree.findings]
    return tree


def sayable(tree: s.File, to: str) -> s.File:
    """The tree without the lines that the other dialect is said to lack words for."""
    language = languages.get(tree.dialect)
    for _ in range(4):
        wrong = {f.line for f in convert([tree], to).findings}
        if not wrong - {None}:
            break
        lines = language.render(tree).splitlines(keepends=True)
        kept = (line for number, line in enumerate(lines, 1) if number not in wrong)
        tree = language.parse("".join(kept))
    return tree


def normal(tree: s.File) -> list[s.Item]:
    """What every conversion keeps: not the steps, the case of names, labels beside statements."""
    items, _ = dialect_words.take_original_names(tree.items)
    items, _ = with_labelled_jumps(items)
    order = {label: f"LABEL{n}" for n, label in enumerate(_defined(items))}
    items = dialect_words.with_names(items, dialect_words.Names(labelled=order), upper=True)
    return [
        _without_step(i)
        for item in gathered(items)
        for i in _apart(item)
        if not isinstance(i, s.Blank)  # the layout decides on their number
    ]


def _without_step(item: s.Item) -> s.Item:
    if isinstance(item, MoveRows):
        return replace(item, steps=np.zeros_like(item.steps))
    return replace(item, number=None) if isinstance(item, s.Line) else item


def _defined(items: list[s.Item]) -> Iterator[str]:
    yield from dict.fromkeys(
        i.label.upper() for i in items if isinstance(i, s.Line) and i.label is not None
    )


def _apart(item: s.Item) -> tuple[s.Item, ...]:
    if isinstance(item, s.Line) and item.label is not None and item.statement is not None:
        return s.Line(label=item.label), replace(item, label=None)
    return (item,)


def _is_first(line: str) -> bool:
    """Whether the first version takes a line too: its length, and two arguments."""
    return len(line.encode()) < 120 and not re.search(r"(?i)def act.*,f\b|type .*,2\b", line)


@settings(max_examples=drawn(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(files(4))
def test_the_first_dialect_comes_back(tree: s.File) -> None:
    tree = parsed(tree)
    assume(all(map(_is_first, languages.get(IV).render(tree).splitlines())))
    back = through(tree, V, VI, V, IV)
    assert back is not None
    for came, went in zip_longest(normal(back), normal(tree)):
        assert came == went


@settings(max_examples=drawn(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@example(languages.get(V).parse("1 If M1=1 Then\n2 Close\n3 EndIf\n"))
@example(
    languages.get(V).parse("1 On M1 GoTo *Assembly_Error_1\n2 *Assembly_Error_1 P1=P_CavDir\n")
)
@example(languages.get(V).parse("1 If M1=1 Then\n2 GoTo *X\n3 Else\n4 XRun 2\n5 EndIf\n"))
@example(
    languages.get(V).parse(
        "1 Select M1\n2 Case M1\n3 Close\n4 Default\n"
        "5 Select 0\n6 Case Is =0\n7 End Select\n8 End Select\n"
    )
)
@given(files(5))
def test_a_lower_dialect_says_the_same_or_says_why_not(tree: s.File) -> None:
    tree = sayable(parsed(tree), IV)
    lower = through(tree, IV)
    assume(lower is not None)
    assert lower is not None
    assert compare(*compared_programs([tree], [lower], None), COMPARISON_TOLERANCE).same


@settings(max_examples=drawn(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(files(5))
def test_a_higher_dialect_takes_the_lower_as_it_stands(tree: s.File) -> None:
    tree = parsed(tree)
    higher = through(tree, VI)
    assert higher is not None
    assert languages.get(VI).render(higher) == languages.get(V).render(tree)
