"""Layout: one form for every program, steps numbered anew, and nothing said otherwise."""

from __future__ import annotations

import random
from pathlib import Path as FilePath
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import SourceText
from assistant.compiler.formatter import format_text
from assistant.languages.melfa_basic.tables.dialects import LAST_STEP
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from tests.examples import drawn
from tests.languages.melfa_basic.files import files, of_type
from tests.languages.melfa_basic.layouts import scattered

LEVELS = (4, 5, 6)


def of(level: int) -> Any:
    return languages.get(f"melfa-basic-{level}")


def cases() -> list[tuple[str, int, str, str]]:
    """Title, level, text and its layout of each case in the file beside this one."""
    found = []
    text = (FilePath(__file__).parent / "fixtures" / "layouts.txt").read_text("utf-8")
    for case in text.split("\n= ")[1:]:
        title, rest = case.split("\n", 1)
        before, after = rest.split("\n-\n")
        level, title = title.split(" ", 1)
        found.append((title, int(level), before + "\n", after.removesuffix("\n") + "\n"))
    return found


@pytest.mark.parametrize(("title", "level", "before", "after"), cases())
def test_layout(title: str, level: int, before: str, after: str) -> None:
    formatted = format_text(SourceText(before), of(level))
    assert formatted.text == after, title
    assert not has_errors(formatted.findings)
    assert format_text(SourceText(after), of(level)).text == after


@pytest.mark.parametrize("level", LEVELS)
@given(data=st.data(), seed=st.integers(0, 99))
@settings(max_examples=drawn(20), deadline=None)
def test_layout_says_the_same_and_is_settled(level: int, data: st.DataObject, seed: int) -> None:
    language = of(level)
    plain = language.render(data.draw(files(level)))
    text = scattered(plain, random.Random(seed))
    tree = language.parse(text)
    formatted = format_text(SourceText(text), language)
    if not has_errors(tree.findings):
        assert not has_errors(formatted.findings)
        assert language.same(language.parse(formatted.text), tree)
        assert format_text(SourceText(formatted.text), language).text == formatted.text


@pytest.mark.parametrize("level", LEVELS)
@given(data=st.data())
@settings(max_examples=drawn(20), deadline=None)
def test_what_is_printed_is_laid_out(level: int, data: st.DataObject) -> None:
    language = of(level)
    text = language.render(data.draw(files(level)))
    if not has_errors(language.parse(text).findings):
        assert language.format(language.parse(text)) == text


def test_a_line_stays_short_enough_for_the_controller() -> None:
    comment = "'" + "x" * 200
    lines = ["Ovrd 10" + " " * 20 + comment, "Spd 100" + " " * 20 + comment]
    text = "\r\n".join(["If M1=1 Then"] * 8 + lines + ["EndIf"] * 8) + "\r\n"
    formatted = format_text(SourceText(text), of(5))
    assert formatted.changed and not formatted.findings
    assert all(len(line) <= 240 for line in formatted.text.splitlines())


def test_line_ends_are_those_of_most_lines() -> None:
    text = "1 Mov P1\r\n2 Mov P2\n3 End\r\nP1=(1,2,3,4,5,6)(7,0)"
    assert format_text(SourceText(text), of(5)).text.count("\r\n") == 4


# --------------------------------------------------------------------------- renumbering


def jumps(tree: s.File) -> list[tuple[int, int]]:
    """Which line, counted from 0, jumps to which by its number."""
    lines: list[tuple[int, Any]] = []
    for item in tree.items:
        if isinstance(item, MoveRows):
            lines += [(int(step), None) for step in item.steps]
        elif isinstance(item, s.Line):
            lines.append((item.number or 0, item.statement))
    places = {number: at for at, (number, _) in enumerate(lines)}
    return [
        (at, places[target.place])
        for at, (_, statement) in enumerate(lines)
        for target in of_type(statement, s.Target)
        if isinstance(target.place, int)
    ]


def numbers(tree: s.File) -> list[int]:
    """Step numbers of all lines."""
    found: list[int] = []
    for item in tree.items:
        if isinstance(item, MoveRows):
            found += item.steps.tolist()
        elif isinstance(item, s.Line):
            found.append(item.number or 0)
    return found


@st.composite
def numbered(draw: st.DrawFn) -> str:
    """Programs with gaps between their steps and jumps to all of them."""
    steps = sorted(draw(st.sets(st.integers(1, 300), min_size=1, max_size=12)))
    place = st.sampled_from(steps)
    lines = st.one_of(
        st.builds("GoTo {}".format, place),
        st.builds("GoSub {}".format, place),
        st.builds("If M1=1 Then {} Else {}".format, place, place),
        st.builds("On M1 GoTo {},,{}".format, place, place),
        st.builds("Def Act 1,M_In(3)=1 GoTo {},S".format, place),
        st.builds("On Com(1) GoSub {}".format, place),
        st.builds("If M1>{} Then M1={}".format, place, place),
        st.sampled_from(["Mov P1", "  Mvs  P2", "Mvr P1,P2,P3", "M1=10 ' 20", "*L", ""]),
    )
    text = "".join(f"{step} {draw(lines)}\r\n" for step in steps)
    return text + draw(st.sampled_from(["", "P1=(1,2,3,4,5,6)(7,0)\r\n", "\r\n"]))


@given(numbered(), st.integers(1, 40), st.integers(1, 40), st.sampled_from(LEVELS))
@settings(max_examples=drawn(80), deadline=None)
def test_renumbering_keeps_what_jumps_where(text: str, first: int, step: int, level: int) -> None:
    language = of(level)
    tree = language.parse(text)
    formatted = format_text(SourceText(text), language, (first, step))
    assert not has_errors(formatted.findings)
    again = language.parse(formatted.text)
    assert numbers(again) == [first + step * at for at in range(len(numbers(tree)))]
    assert jumps(again) == jumps(tree)
    settled = format_text(SourceText(formatted.text), language, (first, step))
    assert settled.text == formatted.text


def test_only_numbers_change() -> None:
    tree = of(5).parse("10  Spd 100   ' slow\n15    Mov P1\n16    Mov  P2\n20 GoTo 15\n")
    text = of(5).render(of(5).renumber(tree, 100, 10))
    assert text == "100  Spd 100   ' slow\n110    Mov P1\n120    Mov  P2\n130 GoTo 110\n"


def test_programs_without_numbers_get_some() -> None:
    text = "Mov P1\n\n' then\nIf M1=1 Then\nMov P2\nEndIf\n\nP1=(1,2,3,4,5,6)(7,0)\n"
    formatted = format_text(SourceText(text), of(5), (1, 1))
    assert formatted.text == (
        "1 Mov P1\n2 '\n3 ' then\n4 If M1=1 Then\n5     Mov P2\n6 EndIf\n\n"
        "P1=(+1.00,+2.00,+3.00,+4.00,+5.00,+6.00)(7,0)\n"
    )


def test_lines_without_a_number_get_one_but_for_variables() -> None:
    text = "10 Mov P1\n' note\n20 Mov P2\nP1=(1,2,3,4,5,6)(7,0) ' taught\n"
    formatted = format_text(SourceText(text), of(5), (10, 10))
    assert formatted.text == ("10 Mov P1\n20 ' note\n30 Mov P2\nP1=(1,2,3,4,5,6)(7,0) ' taught\n")


@pytest.mark.parametrize(
    ("text", "numbering", "code"),
    [
        ("10 GoTo 15\n20 End\n", (10, 10), "MB102"),
        ("10 End\n10 End\n", (10, 10), "MB108"),
        ("20 Mov P1\n10 Mov P2\n30 End\n", (10, 10), "MB108"),
        ("10 Mov P1\n20 End\n", (32767, 1), "MB401"),
    ],
)
def test_what_cannot_be_renumbered_stays(text: str, numbering: Any, code: str) -> None:
    formatted = format_text(SourceText(text), of(5), numbering)
    assert formatted.text == text
    assert [finding.code for finding in formatted.findings] == [code]


def test_the_last_step_is_a_step() -> None:
    text = "10 Mov P1\n20 End\n"
    formatted = format_text(SourceText(text), of(5), (LAST_STEP - 1, 1))
    assert formatted.text == "32766 Mov P1\n32767 End\n"


def test_rapid_has_no_steps() -> None:
    with pytest.raises(Refused) as refused:
        format_text(SourceText("MODULE m\nENDMODULE\n"), languages.get("rapid"), (1, 1))
    assert refused.value.exit_status == 2
