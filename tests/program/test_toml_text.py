"""TOML is read within a bound of work: no key of very many parts, nothing beyond its budget."""

from __future__ import annotations

import tomllib
from collections.abc import Callable

import pytest

from assistant.base.budgets import FACTOR_VARIABLE, MEMORY, TIME
from assistant.base.diagnostics import Refused, Unreadable
from assistant.base.source_text import SourceText
from assistant.base.toml_text import LONG_KEY, MOST_PARTS, parse_toml
from assistant.robots.robot_file import read as read_robot
from assistant.sources.process.file import parse_process
from tests.tables import every_row


def dotted(parts: int, part: str = "a", dot: str = ".") -> str:
    return dot.join([part] * parts)


def process(text: str) -> object:
    return parse_process(SourceText(text, "x.toml"))


def robot(text: str) -> object:
    return read_robot(text.encode(), "x.toml")


LONG = dotted(MOST_PARTS + 1)


@every_row("read", [process, robot, lambda text: parse_toml(text, "x.toml")])
@every_row(
    "line",
    [
        f"{LONG} = 1",
        f"  [{LONG}]",
        f"[[ {LONG} ]]",
        f"x = {{{LONG} = 1}}",
        f"x = {{y = 1, {LONG} = 1}}",
        dotted(MOST_PARTS + 1, '"a.\\"b"', " . ") + " = 1",
        dotted(MOST_PARTS + 1, "'a b'", "\t.") + " = 1",
        dotted(1_000_000) + " = 1",
    ],
)
def test_a_key_of_too_many_parts_is_refused_at_its_line(
    read: Callable[[str], object], line: str
) -> None:
    with pytest.raises(Unreadable) as caught:
        read(f"# a comment\n\n{line}\n")
    (finding,) = caught.value.findings
    assert (finding.code, finding.path, finding.line) == (LONG_KEY.code, "x.toml", 3)


@pytest.mark.parametrize(
    "text",
    [
        f"[{dotted(MOST_PARTS)}]\nb = 1\n",
        f"{dotted(MOST_PARTS)} = 1\n",
        "x = [\n  [" + ", ".join(["1.5"] * 300) + "],\n[" + ",".join(["-2.5"] * 300) + "]]\n",
        'x = """\n[' + "." * 500 + '\n"""\n',
        f"'{LONG}' = '{LONG}'\n# {LONG}\n",
    ],
)
def test_an_honest_text_is_read_as_the_standard_library_reads_it(text: str) -> None:
    assert parse_toml(text) == tomllib.loads(text)


def test_what_takes_more_than_the_budget_ends_with_a_finding(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv(FACTOR_VARIABLE, "0.001")
    text = "".join(f"[t{i}]\nx = [0.5, 1.5, 2.5]\n" for i in range(20_000))
    with pytest.raises(Refused) as caught:
        process(text)
    (finding,) = caught.value.findings
    assert finding.code in {TIME.code, MEMORY.code}  # whichever is used up first
    assert finding.path == "x.toml"
