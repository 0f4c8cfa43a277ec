"""Texts that are wrong: every one gives findings with the place, and never a traceback."""

from __future__ import annotations

import re
from pathlib import Path as FilePath

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.base.diagnostics import Refused, Rule, Unreadable
from assistant.base.source_text import SourceText
from assistant.program.program import Program
from assistant.program.pseudo import parse, print_program, read, words
from tests.examples import drawn
from tests.strategies import programs
from tests.tables import every_row

BROKEN = re.findall(
    r"=== (\w+) (\d+):(\d+)\n((?:(?!===).*\n)*)",
    (FilePath(__file__).parent / "fixtures" / "broken.txt").read_text(encoding="utf-8"),
)
RULES = {rule.code: rule for rule in vars(words).values() if isinstance(rule, Rule)}


@every_row(("code", "line", "column", "text"), BROKEN)
def test_a_broken_program_is_refused_at_its_place(
    code: str, line: str, column: str, text: str
) -> None:
    with pytest.raises(Refused) as refused:
        parse(SourceText(text, "broken.pseudo") if code != "PS411" else text)
    found = refused.value.findings
    assert (code, int(line), int(column)) in [(f.code, f.line, f.column) for f in found]
    assert refused.value.exit_status == 1
    for finding in found:
        assert finding.message and finding.cure
        assert finding.excerpt == (text.split("\n")[(finding.line or 1) - 1])


def test_every_rule_but_those_of_files_has_a_broken_program() -> None:
    shown = {code for code, *_ in BROKEN}
    elsewhere = {"PS105", "PS106", "PS413", "PS414", "PS415"}
    assert set(RULES) - elsewhere == shown


def test_several_things_that_are_wrong_are_found_at_once() -> None:
    text = """\
program a
tool gripper tip [0, 0]
target t [0, 0, 0] [1, 1, 0, 0]
procedure main
  mov linear t
  if a >
    wait 5
  end
  follow seam
    linear [0, 0] [1, 0, 0, 0] speed 1 mm/s blend fine
    linear [0, 0, 0] [1, 0, 0, 0] speed 1 blend fine
  end
end
"""
    with pytest.raises(Refused) as refused:
        parse(text)
    assert [f.line for f in refused.value.findings] == [2, 3, 5, 6, 7, 10, 11]


def test_a_word_near_a_known_one_is_named() -> None:
    with pytest.raises(Refused) as refused:
        parse("program a\nprocedure main\n  folow seam\nend\n")
    assert refused.value.findings[0].cure == "write `follow`"


def test_a_text_of_another_kind_is_given_up_soon() -> None:
    with pytest.raises(Refused) as refused:
        parse("MODULE a\n" * 5000)
    assert len(refused.value.findings) == 101
    assert refused.value.findings[-1].code == "PS106"


@pytest.mark.parametrize(
    "line",
    [
        "x = " + "(" * 2000 + "1" + ")" * 2000,
        "x = " + "1 + " * 2000 + "1",
        "x = " + "-" * 2000 + "a",
    ],
)
def test_a_deep_line_is_refused(line: str) -> None:
    with pytest.raises(Refused) as refused:
        parse(f"program a\nprocedure main\n{line}\nend\n")
    assert [f.code for f in refused.value.findings] == ["PS105"]


def test_deep_blocks_are_refused_without_a_second_finding() -> None:
    with pytest.raises(Refused) as refused:
        parse("program a\nprocedure main\n" + "while a\n" * 51 + "end\n" * 51 + "end\n")
    assert [(f.code, f.line) for f in refused.value.findings] == [("PS105", 53)]


def test_no_control_character_of_a_text_reaches_a_message() -> None:
    with pytest.raises(Refused) as refused:
        parse("program a\n\x1b[2Jx\n")
    assert all(f.message.isprintable() and f.cure.isprintable() for f in refused.value.findings)


@pytest.mark.parametrize("data", [b"", b"\xff\xfe\x00p"])
def test_what_is_no_text_cannot_be_read(tmp_path: FilePath, data: bytes) -> None:
    file = tmp_path / "a.pseudo"
    file.write_bytes(data)
    with pytest.raises(Unreadable) as refused:
        read(file)
    assert refused.value.exit_status == 2


@settings(deadline=None, max_examples=drawn(150))
@given(programs(2), st.data())
def test_a_damaged_text_is_read_or_refused(program: Program, data: st.DataObject) -> None:
    """Lines lost, doubled or swapped, characters changed: findings, or a program that prints."""
    text = print_program(program).text
    lines = text.split("\n")
    at = data.draw(st.integers(0, len(lines) - 1))
    damage = data.draw(st.sampled_from(["lose", "double", "swap", "character"]))
    if damage == "lose":
        del lines[at]
    elif damage == "double":
        lines.insert(at, lines[at])
    elif damage == "swap":
        lines[at], lines[at - 1] = lines[at - 1], lines[at]
    elif lines[at]:
        column = data.draw(st.integers(0, len(lines[at]) - 1))
        lines[at] = lines[at][:column] + data.draw(st.characters()) + lines[at][column + 1 :]
    _read_or_refused("\n".join(lines))


@settings(deadline=None, max_examples=drawn(200))
@given(st.text(st.sampled_from("program a end\n\t\"`#|[]()1.-=\\'{}\r\x00é")))
def test_any_text_is_read_or_refused(text: str) -> None:
    _read_or_refused(text)
    _read_or_refused(f"program a\nprocedure main\n{text}\nend\n")


def _read_or_refused(text: str) -> None:
    try:
        program = parse(text)
    except Refused as refused:
        assert refused.findings
        assert all(f.line and f.column and f.message for f in refused.findings)
    else:
        printed = print_program(program)
        assert print_program(parse(printed.text)) == printed
