"""Answers for editors about the text form of the pseudo-program."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import pairwise
from typing import Final

from assistant.program.editor_support import (
    Declaration,
    DeclaredKind,
    Editable,
    KnownWord,
    LineFacts,
    Scope,
    Word,
    WordKind,
    names_among,
)
from assistant.program.program import IDENTIFIER
from assistant.program.pseudo.words import BLOCK_WORDS, FIRST_WORDS, KEYWORDS

_WORD: Final = re.compile(
    r"""(?P<comment>\#.*)|(?P<string>"(?:[^"\\]|\\.)*+"?)|(?P<quoted>`(?:[^`\\]|\\.)*+`)
    |(?P<number>[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<operator><>|<=|>=|\S)""",
    re.VERBOSE,
)
_KINDS: Final[Mapping[str, DeclaredKind]] = {
    "program": "program", "procedure": "procedure", "target": "target", "joints": "target",
    "tool": "constant", "frame": "constant", "speed": "constant", "blend": "constant",
    "signal": "variable", "constant": "constant", "variable": "variable", "persistent": "variable",
    "label": "label",
}  # fmt: skip
_SPOKEN: Final = frozenset(
    """
    absolute at before case centre circular computed deceleration details digital analog elbow end
    entry external fine for from full group hand in input joint kg linear mass maximum maximal mm ms
    object output pulse rotation rows s start step tilt timer tip to tool towards until user via
    without number boolean text position pose ahead ends where interrupt interrupts calls off on
    """.split()  # noqa: SIM905
)


_DECLARATIONS: Final = (
    "target {name} [0, 0, 0] [1, 0, 0, 0]",
    "tool {name} tip [0, 0, 0]",
    "frame {name} object [0, 0, 0]",
    "speed {name} 100 mm/s",
    "blend {name} 1 mm",
    "signal {name} digital output",
    "signal {name} digital input",
    "variable {name} number = 0",
    "procedure {name}\nend",
)
"""One declaration for each kind of a name."""


class EditablePseudo(Editable):
    mark = "#"
    folds = False
    blocks = tuple((word, "end") for word in ("procedure", *BLOCK_WORDS))

    def facts(self, line: str) -> LineFacts:
        bare = line.lstrip()
        if bare.startswith("|"):
            start = len(line) - len(bare)
            return LineFacts((Word("string", start, len(line), bare),))
        said = tuple(_words(line))
        code = [word for word in said if word.kind != "comment"]
        first = code[0].text if code else ""
        assigns = len(code) > 1 and code[1].text in ("=", ".", "[")
        head = "" if assigns else first
        begins, block = head == "procedure", _opens_block(head, code)
        return LineFacts(
            said,
            names_among(said, self.folded),
            tuple(_declared(head, code)),
            begins=begins,
            ends=head == "end",
            opens=1 if block else -1 if head == "end" else 0,
            stays=head == "program",
        )

    def known(self) -> Mapping[str, KnownWord]:
        return _known()

    def folded(self, name: str) -> str:
        return name.strip("`")

    def declarations(self, name: str) -> tuple[str, ...]:
        return tuple(row.format(name=name) for row in _DECLARATIONS)

    def no_name(self, name: str, instead_of: str) -> str:  # noqa: ARG002
        if not IDENTIFIER.fullmatch(name):
            return "is not of letters, digits and `_`, beginning with a letter"
        return "is a word of the language" if name in KEYWORDS else ""

    def colours(self) -> Mapping[str, str]:
        return {
            "string.quoted.double": r'"(?:[^"\\]|\\.)*"',
            "string.unquoted": r"^\s*\|.*$",
            "comment.line": r"#.*$",
            "variable.other": r"`(?:[^`\\]|\\.)*`",
            "constant.numeric": r"(?<![A-Za-z0-9_])[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?",
        }


def _opens_block(head: str, code: Sequence[Word]) -> bool:
    if head == "follow":
        return not any(word.text == "from" for word in code)
    if head == "opaque":
        return not any(word.kind == "string" or word.text == "|" for word in code[1:])
    return head in BLOCK_WORDS


def _words(line: str) -> Iterator[Word]:
    first = True
    for found in _WORD.finditer(line):
        group, text = found.lastgroup or "", found[0]
        kind: WordKind = "name" if group == "quoted" else group  # type: ignore[assignment]
        if group == "name" and (text in KEYWORDS or (first and _is_first(text)) or text in _SPOKEN):
            kind = "keyword"
        elif group == "name" and found.start() and line[found.start() - 1] == ".":
            kind = "property"
        yield Word(kind, found.start(), found.end(), text)
        first = False


def _is_first(word: str) -> bool:
    return word in FIRST_WORDS["declaration"] or word in FIRST_WORDS["statement"]


def _declared(head: str, code: Sequence[Word]) -> Iterator[Declaration]:
    rest = code[1:]
    if head == "local":
        head, rest = (code[1].text if len(code) > 1 else ""), code[2:]
    if head == "for" and rest:
        yield Declaration(rest[0].text, "variable", rest[0].start, rest[0].end, "routine", "for")
    if head not in _KINDS or not rest or rest[0].kind not in ("name", "keyword"):
        return
    name = rest[0]
    scope: Scope = "routine" if head == "label" else "file"
    detail = " ".join(word.text for word in rest[1:3]) if head in _STORED else head
    if head == "procedure":
        detail = "".join(_spaced(rest[1:]))
    yield Declaration(name.text, _KINDS[head], name.start, name.end, scope, detail)
    if head == "procedure":
        for before, word in pairwise(rest[1:]):
            if before.text in ("(", ","):
                yield Declaration(word.text, "parameter", word.start, word.end, "routine")


_STORED: Final = ("constant", "variable", "persistent")


def _spaced(words: Sequence[Word]) -> Iterator[str]:
    for word in words:
        yield word.text if word.kind == "operator" and word.text != "," else word.text + " "


@cache
def _known() -> Mapping[str, KnownWord]:
    words = {*KEYWORDS, *_SPOKEN, *FIRST_WORDS["declaration"], *FIRST_WORDS["statement"]}
    plain = {word: KnownWord(word, "keyword") for word in sorted(words)}
    text = files("assistant.program.pseudo").joinpath("abouts.txt").read_text("utf-8")
    rows = (line.split(" ; ") for line in text.splitlines() if " ; " in line and line[0] != "#")
    told = {row[0]: KnownWord(row[0], "instruction", row[1], row[2]) for row in rows}
    return plain | told
