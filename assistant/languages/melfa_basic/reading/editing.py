"""Editor support for MELFA-BASIC, from its tables."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import Dialect
from assistant.languages.melfa_basic.tables.variables import RESERVED_WORDS
from assistant.languages.texts.words import abouts
from assistant.program.editor_support import (
    Declaration,
    DeclaredKind,
    Editable,
    KnownWord,
    LineFacts,
    Word,
    WordKind,
    names_among,
)

_WORD: Final = re.compile(
    r"""(?P<comment>'.*|\bREM\b.*)|(?P<string>"[^"]*"?)
    |(?P<number>&[HB][0-9A-F]+|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:E[+-]?[0-9]+)?[%&!#]?)
    |(?P<name>[A-Z][A-Z0-9_]*[$%&!#]?)|(?P<label>\*[A-Z][A-Z0-9_]*)
    |(?P<operator><>|<=|>=|=<|=>|<<|>>|\S)""",
    re.IGNORECASE | re.VERBOSE,
)
_STEP: Final = re.compile(r"[ \t]*[0-9]+(?=[ \t*']|$)")
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*[$%&!#]?")
_LABEL: Final = re.compile(r"\*?[A-Za-z][A-Za-z0-9_]*")
_JUMPS: Final = ("goto", "gosub")
_TYPES: Final[Mapping[str, str]] = {
    "M": "number",
    "C": "text",
    "P": "position",
    "J": "joints",
}
_OPENS: Final = {"for": 1, "next": -1, "while": 1, "wend": -1, "select": 1, "endif": -1}
_POSITION: Final = {
    **dict.fromkeys(("X", "Y", "Z"), "mm"),
    **dict.fromkeys(("A", "B", "C"), "degrees"),
    **dict.fromkeys(("L1", "L2"), "external axis"),
    **dict.fromkeys(("FL1", "FL2"), "configuration"),
}
_JOINTS: Final = {f"J{number}": "radian" for number in range(1, 9)}
_ROWS: Final = {
    "P": "{name}=(0.00,0.00,0.00,0.00,0.00,0.00)(7,0)",
    "J": "{name}=(0.00,0.00,0.00,0.00,0.00,0.00)",
}
"""Lines of a position list."""
_DECLARING: Final = ("pos", "jnt", "inte", "long", "float", "double", "char", "io")


class EditableMelfaBasic(Editable):
    mark = "'"
    declared_last = True
    blocks = (("if", "endif"), ("for", "next"), ("while", "wend"), ("select", "end select"))

    def __init__(self, dialect: Dialect) -> None:
        self._dialect = dialect

    def facts(self, line: str) -> LineFacts:
        said = tuple(_words(line))
        code = [word for word in said if word.kind != "comment"]
        step = code[0] if code and _STEP.match(line) and code[0].kind == "number" else None
        code = code[1:] if step else code
        keys = [word.text.lower() for word in code if word.kind == "keyword"]
        function = keys[:1] == ["function"]
        return LineFacts(
            said,
            names_among(said, str.lower),
            tuple(_declared(code, keys, numbered=step is not None)),
            begins=function,
            ends=keys[:1] == ["fend"],
            opens=_opened(code, keys),
        )

    def known(self) -> Mapping[str, KnownWord]:
        return _known(self._dialect.level)

    def no_name(self, name: str, instead_of: str) -> str:
        if instead_of.startswith("*"):
            if not _LABEL.fullmatch(name):
                return "is not of letters, digits and `_`, beginning with a letter"
        elif not _NAME.fullmatch(name):
            return "is not of letters, digits and `_`, beginning with a letter"
        elif name[0].upper() != instead_of[0].upper() and instead_of[0].upper() in _TYPES:
            return f"does not begin with `{instead_of[0].upper()}`, which says its type"
        elif (name[-1] in "$%&!#") != (instead_of[-1] in "$%&!#"):
            return "does not end as the other one does, which says its type"
        if len(name.lstrip("*")) > self._dialect.longest:
            return f"is longer than {self._dialect.longest} characters"
        plain = name.lstrip("*").rstrip("$%&!#").upper()
        if plain in RESERVED_WORDS:
            return "is a word of the language"
        known = vocabulary.status(plain) is not None
        return "is a variable of every controller" if known else ""

    def declarations(self, name: str) -> tuple[str, ...]:
        row = _ROWS.get(name[:1].upper())
        return () if row is None else (row.format(name=name),)

    def members(self, detail: str) -> Mapping[str, str]:
        if detail in ("Def Pos", "position", "position, array"):
            return _POSITION
        return _JOINTS if detail in ("Def Jnt", "joints", "joints, array") else {}

    def colours(self) -> Mapping[str, str]:
        return {
            "string.quoted.double": r'"[^"]*"',
            "comment.line": r"'.*$|(?i)\bREM\b.*$",
            "constant.numeric.line-number": r"^[ \t]*[0-9]+(?=[ \t*'])",
            "entity.name.label": r"\*[A-Za-z][A-Za-z0-9_]*",
            "constant.numeric": r"(?<![A-Za-z0-9_])(?:&[HBhb][0-9A-Fa-f]+"
            r"|(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)",
        }


def _words(line: str) -> Iterator[Word]:
    before, jumps, at = "", False, 0
    while found := _WORD.search(line, at):
        kind: WordKind = found.lastgroup  # type: ignore[assignment]
        text, start, at = found[0], *found.span()
        # A label begins a line or follows a jump; anywhere else `*` multiplies.
        if kind == "label" and not (before in ("", ":") or before in _BEFORE_LABELS or jumps):
            kind, text, at = "operator", "*", start + 1
        elif kind == "name":
            low = text.lower()
            if before == "." and start and line[start - 1] == ".":
                kind = "property"
            elif low.upper() in _keywords() and text[-1] not in "$%&!#":
                kind = "keyword"
                jumps = jumps or low in _JUMPS
        yield Word(kind, start, at, text)
        # A step number at the beginning is no word of the statement.
        if not (kind == "number" and not before):
            before = text.lower() if kind != "label" else "*"


_BEFORE_LABELS: Final = ("goto", "gosub", "then", "else", "restore")


@cache
def _keywords() -> frozenset[str]:
    """First and inner words of statements, in upper case."""
    parts = {part for word in vocabulary.statements() for part in word.split()}
    return frozenset(parts | {"AND", "OR", "XOR", "NOT", "MOD"})


def _opened(code: Sequence[Word], keys: Sequence[str]) -> int:
    """A block `If` has nothing behind its `Then`."""
    if keys[:2] == ["end", "select"]:
        return -1
    if keys[:2] == ["end", "if"]:
        return -1
    if keys[:1] == ["if"]:
        return int(bool(code) and code[-1].text.lower() == "then")
    return _OPENS.get(keys[0], 0) if keys else 0


def _declared(
    code: Sequence[Word], keys: Sequence[str], *, numbered: bool
) -> Iterator[Declaration]:
    if code and code[0].kind == "label":
        yield _declaration(code[0], "label", "")
        code = code[1:]
    names = [word for word in code if word.kind == "name"]
    match list(keys[:2]):
        case ["def", second] if second in _DECLARING:
            target = second == "pos" and any(word.text == "(" for word in code[2:4:1])
            for name in _listed(code):
                yield _declaration(
                    name, "target" if target else "variable", f"Def {second.title()}"
                )
        case ["def", "fn", *_] if names:
            yield _declaration(names[0], "function", "Def FN")
        case ["dim", *_]:
            for name in _listed(code):
                yield _declaration(name, "variable", f"{_type(name)}, array")
        case ["function", *_] if names:
            name = names[1] if len(names) > 1 and names[0].text.upper() in _TYPES else names[0]
            yield _declaration(name, "function", "")
        case ["for", *_] if names:
            yield _declaration(names[0], "variable", _type(names[0]), implied=True)
        case _ if code and code[0].kind == "name":
            yield from _assigned(code, numbered)


def _assigned(code: Sequence[Word], numbered: bool) -> Iterator[Declaration]:
    """A variable by its assignment: a position list line, or where it is used first."""
    name, marks = code[0], [word.text for word in code[1:]]
    if "=" not in marks or name.text.lower() in _status():
        return
    behind = marks[marks.index("=") + 1 :]
    listed = not numbered and behind[:1] == ["("] and name.text[0].upper() in "PJ"
    listed = listed and marks[0] == "="
    kind: DeclaredKind = "target" if listed else "variable"
    yield _declaration(name, kind, _type(name), implied=not listed)


@cache
def _status() -> frozenset[str]:
    return frozenset(name.lower() for name in vocabulary.variables())


def _type(name: Word) -> str:
    return _TYPES.get(name.text[0].upper(), "")


def _listed(code: Sequence[Word]) -> Iterator[Word]:
    """Names outside of brackets, up to an `=`."""
    depth = 0
    for word in code:
        if word.text == "=":
            return
        depth += (word.text == "(") - (word.text == ")")
        if word.kind == "name" and not depth:
            yield word


def _declaration(
    word: Word, kind: DeclaredKind, detail: str, *, implied: bool = False
) -> Declaration:
    return Declaration(word.text, kind, word.start, word.end, "file", detail, implied)


@cache
def _known(level: int) -> Mapping[str, KnownWord]:
    about = abouts("assistant.languages.melfa_basic.tables")
    found: dict[str, KnownWord] = {}
    for row in vocabulary.statements().values():
        sort = "keyword" if row.role == "part" else "instruction"
        low = row.word.lower()
        found[low] = KnownWord(row.word, sort, row.word, _told(about.get(low, ""), row, level))
    for called in vocabulary.functions().values():
        plain = called.name.lower().removesuffix("$")
        shown = ", ".join(
            f"[{_types(a.types)}]" if a.optional else _types(a.types) for a in called.arguments
        )
        detail = f"{called.name}({shown}) → {_types(called.result)}"
        known = KnownWord(
            called.name, "function", detail, _told(about.get(plain, ""), called, level)
        )
        found[called.name.lower()] = known
    for name, status in vocabulary.variables().items():
        index = f"({', '.join(status.index)})" if status.index else ""
        access = "" if status.writable else ", read only"
        detail = f"{status.name}{index}: {_types(status.type)}{access}"
        low = name.lower()
        known = KnownWord(status.name, "variable", detail, _told(about.get(low, ""), status, level))
        found.setdefault(low, known)
    return found


def _types(types: str) -> str:
    return " or ".join(_TYPES.get(one, one) for one in types)


def _told(about: str, row: vocabulary.Row, level: int) -> str:
    if level in row.dialects:
        return about
    instead = f" Instead: {row.instead}." if row.instead else ""
    return f"{about} This version of the language does not have it.{instead}".strip()
