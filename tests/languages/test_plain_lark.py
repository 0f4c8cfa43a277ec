"""The grammars describe every line: plain lark reads what our readers read, with no code of ours.

Both read every text alike: each refuses what the other refuses, and nodes made of lark's trees are
those of the reader.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Final

import pytest
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedInput

from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.compiler import compile
from assistant.languages.melfa_basic.reading.line import Nodes as MelfaNodes
from assistant.languages.melfa_basic.reading.parser import parse as parse_melfa
from assistant.languages.melfa_basic.tree import syntax as m
from assistant.languages.rapid.reading.parser import Nodes as RapidNodes
from assistant.languages.rapid.reading.parser import parse as parse_rapid
from docs.grammars import GRAMMAR, current
from tests.languages.lark_trees import everything, node_of
from tests.tables import every_row

ROOT: Final = Path(__file__).parent.parent.parent
HERE: Final = Path(__file__).parent
MELFA: Final = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")
ALL: Final = ("rapid", *MELFA)


def plain(language: str) -> Lark:
    return lark_of("rapid.lark" if language == "rapid" else "melfa_basic.lark")


@cache
def lark_of(file: str) -> Lark:
    text = (ROOT / "grammars" / file).read_text("utf-8")
    return Lark(text, parser="lalr", propagate_positions=True)


def parsed(language: str, text: str) -> Tree[Token] | None:
    try:
        return plain(language).parse(text)
    except UnexpectedInput:
        return None


def sound(language: str, text: str) -> bool:
    """True if the reader of the language finds no syntax error."""
    found = languages.get(language).parse(text).findings
    return not any(f.code.startswith(("RA1", "RA0", "MB0")) and has_errors([f]) for f in found)


def files_of(language: str) -> list[Path]:
    if language == "rapid":
        folders = [HERE / "rapid" / "data", ROOT / "samples" / "rapid"]
        return sorted(p for folder in folders for p in folder.rglob("*.mod"))
    folders = [HERE / "melfa_basic" / "data", ROOT / "samples" / "melfa"]
    known = languages.get(language)
    found = (p for folder in folders for p in folder.rglob("*") if p.suffix in known.suffixes)
    return sorted(p for p in found if known.recognises(p.read_bytes(), p.suffix))


def lines_of(language: str) -> Iterator[str]:
    """The texts of the fixtures that come back as they are, which no version refuses to read."""
    folder = HERE / "rapid" if language == "rapid" else HERE / "melfa_basic" / "fixtures"
    for name in ("identity.txt", "layouts.txt"):
        for line in (folder / name).read_text("utf-8").splitlines():
            yield line.replace("¶", "\n")


def text_of(language: str, path: Path) -> str:
    known = languages.get(language)
    return known.decode(path.read_bytes(), str(path)).text


# ---------------------------------------------------------------------------- the same trees


def same_trees(language: str, text: str) -> bool:
    tree = parsed(language, text)
    assert tree is not None
    if language == "rapid":
        header, parts = node_of(tree, RapidNodes(text, int, ()))
        read = parse_rapid(text, runs=False)
        return bool(everything((header, parts)) == everything((read.header, read.parts)))
    rows = [row_of(row) for row in tree.children]
    if not text or text.endswith("\n"):
        rows.pop()
    items = [as_line(item) for item in parse_melfa(text, language, runs=False).items]
    return list(map(everything, rows)) == list(map(everything, items))


def row_of(row: Any) -> m.Line | m.Data:
    number, line = row.children
    node: m.Line | m.Data = node_of(line, MelfaNodes())
    if isinstance(node, m.Data):
        return replace(node, span=None)
    return replace(node, number=None if number is None else int(number), span=None)


def as_line(item: Any) -> m.Line | m.Data:
    """An item of a file as the line that the grammar makes of it."""
    match item:
        case m.Blank():
            return m.Line(None, None, None, None)
        case m.Data(variable, value, ""):
            return m.Line(None, None, m.Assign(variable, value, None), None)
    assert isinstance(item, m.Line | m.Data)
    return replace(item, span=None)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("language", ALL)
def test_plain_lark_reads_samples_and_data_as_the_reader_does(language: str) -> None:
    files = files_of(language)
    assert files
    for path in files:
        text = text_of(language, path).replace("\r\n", "\n")
        assert same_trees(language, text), path


@pytest.mark.parametrize("language", ALL)
def test_plain_lark_reads_the_identity_fixtures_as_the_reader_does(language: str) -> None:
    read = [text for text in lines_of(language) if sound(language, text)]
    assert len(read) > 40
    for text in read:
        assert same_trees(language, text), text
    for text in set(lines_of(language)) - set(read):
        assert parsed(language, text) is None, text


# ---------------------------------------------------------------------------- what is emitted


SOURCES: Final[dict[str, dict[str, str | None]]] = {
    "rapid": dict.fromkeys(["taught.toml", "positioning.csv", "plate.dxf"], "irb1200-7-0.7"),
    "melfa": {"positioning.csv": "rv-4frl", "melfa/MULTITASK.prg": None, "plate.dxf": "rv-2aj"},
}


@cache
def emitted(language: str) -> tuple[str, ...]:
    known = languages.get(language)
    made = []
    for source, robot in SOURCES["rapid" if language == "rapid" else "melfa"].items():
        compiled = compile(ROOT / "samples" / source, language=language, robot=robot)
        assert compiled.files, compiled.findings
        made += [known.decode(data).text.replace("\r\n", "\n") for data in compiled.files.values()]
    return tuple(made)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("language", ALL)
def test_plain_lark_reads_every_emitted_line(language: str) -> None:
    for text in emitted(language):
        assert same_trees(language, text)
        assert parsed(language, text.replace("\n", "\r\n")) is not None


EACH_GRAMMAR: Final = [
    *("rapid", "melfa-basic-6"),
    *(pytest.param(name, marks=pytest.mark.slow) for name in MELFA[:2]),
]
"""The versions of MELFA-BASIC share one."""
FAULTS: Final = {
    "rapid": [
        (r"(?m)^ *ENDPROC *$", ""),
        (r"(?m)^ *PROC ", "PROK "),
        (r"ENDMODULE", ""),
        (r";", " "),
        (r"(?<=[a-z0-9]),(?=[a-z])", " "),
        (r":=", "="),
        (r"\]", ""),
        (r"\[", ""),
        (r"MODULE", "MODUL"),
        (r"\bCONST\b", "CONTS"),
    ],
    "melfa": [
        (r"(?m)^(\d+ +)?(Mov|Mvs|MOV|MVS)(?= )", r"\1Move"),
        (r"(?m)^(\d+ +)?(Spd|Ovrd|SPD|OVRD)(?= )", r"\1Speed"),
        (r"(?m)(?<=\d)\)$", ""),
        (r"(?<==)\(", ""),
        (r"(?m)=(?=\()", " "),
        (r"(?m)^(\d+ )?'", r"\1"),
        (r"(?<=\))\n(?=.)", " "),
    ],
}


@pytest.mark.parametrize("language", EACH_GRAMMAR)
def test_plain_lark_refuses_damaged_output(language: str) -> None:
    """Each fault, at each of its first places, in each emitted text."""
    faults = FAULTS["rapid" if language == "rapid" else "melfa"]
    refused = dict.fromkeys(faults, 0)
    for text in emitted(language)[:2]:
        for fault in faults:
            wrong, right = fault
            for found in list(re.finditer(wrong, text))[:2]:
                damaged = text[: found.start()] + found.expand(right) + text[found.end() :]
                known = sound(language, damaged)
                assert (parsed(language, damaged) is not None) == known, (fault, found)
                refused[fault] += not known
    assert all(refused.values()), refused


@pytest.mark.one_in(2)
@pytest.mark.parametrize("language", EACH_GRAMMAR)
def test_plain_lark_and_the_reader_refuse_the_same_when_characters_are_missing(
    language: str,
) -> None:
    text = emitted(language)[0]
    places = range(0, len(text), 67)
    refused = 0
    for at in places:
        damaged = text[:at] + text[at + 1 :]
        known = sound(language, damaged)
        assert (parsed(language, damaged) is not None) == known, damaged[max(at - 30, 0) : at + 30]
        refused += not known
    assert refused > len(places) // 20


# ---------------------------------------------------------------------------- odd texts


@every_row(
    ("language", "text", "accepted"),
    [
        ("rapid", "", False),
        ("rapid", "%%% VERSION:1 LANGUAGE:ENGLISH %%%\n", False),
        ("rapid", "! only a comment\n", True),
        ("rapid", "MODULE a\r\n! é\r\nENDMODULE\r\nMODULE b\r\nENDMODULE\r\n", True),
        ("melfa-basic-6", "", True),
        ("melfa-basic-6", "\n\n", True),
        ("melfa-basic-6", "10\n20 \n", True),
        ("melfa-basic-6", "' é\r\nMov P1 ' ü\r\n", True),
        ("melfa-basic-6", "Mov P1\r\n\x1a", True),
        ("melfa-basic-6", "10Mov P1\n", False),
        ("melfa-basic-6", "C1$=(\n)\n", False),
        ("melfa-basic-6", 'C1$="a\n"\n', False),
        ("melfa-basic-6", "M1 $=1\n", False),
        ("melfa-basic-6", "If M1=1 Thenx M1=2\n", False),
        ("melfa-basic-6", "Ovrd=5\n", False),
        ("melfa-basic-6", "Speed=5\n", True),
        ("melfa-basic-6", "If=5\n", False),
        ("melfa-basic-6", "End  If\nReset  Err\nElse  If M1=1 Then\n", True),
    ],
)
def test_odd_texts(language: str, text: str, accepted: bool) -> None:
    assert (parsed(language, text) is not None) == accepted
    if text and not text.startswith("%%%"):
        assert sound(language, text) == accepted


def test_the_words_in_the_grammar_are_those_of_the_tables() -> None:
    text = GRAMMAR.read_text("utf-8")
    assert current(text) == text, "python -m docs.grammars"
