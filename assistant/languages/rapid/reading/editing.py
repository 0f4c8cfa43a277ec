"""Answer editor requests about RAPID with its scanner and tables."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Final

from assistant.languages.rapid.reading.scanner import words
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.constants import LONGEST_NAME, RESERVED
from assistant.languages.texts.words import abouts
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

_KINDS: Final[Mapping[str, WordKind]] = {
    "word": "name", "key": "keyword", "number": "number", "string": "string", "hole": "operator",
    "mark": "operator", "comment": "comment", "header": "comment",
}  # fmt: skip
_ROUTINES: Final[Mapping[str, DeclaredKind]] = {
    "proc": "procedure",
    "func": "function",
    "trap": "interrupt",
}
# ELSEIF closes a branch, and its THEN opens the next one.
_OPENS: Final = {"then": 1, "do": 1, "test": 1, "elseif": -1, "record": 1}
_CLOSES: Final = ("endif", "endfor", "endwhile", "endtest", "endrecord")
_STAYS: Final = ("module", "endmodule", "error", "undo", "backward")
_ENDS: Final = ("endproc", "endfunc", "endtrap")
_COMPLETE: Final = frozenset(
    ("then", "do", "else", "endif", "endfor", "endwhile", "endtest", "endrecord", "default")
)
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


class EditableRapid(Editable):
    mark = "!"
    brackets = (("(", ")"), ("[", "]"), ("{", "}"))
    blocks = tuple(
        (word, "end" + word)
        for word in ("if", "for", "while", "test", "proc", "func", "trap", "record", "module")
    )

    def facts(self, line: str) -> LineFacts:
        said = tuple(_words(line))
        code = [word for word in said if word.kind != "comment"]
        keys = [word.text.lower() for word in code if word.kind == "keyword"]
        first = code[0].text.lower() if code else ""
        head = first if first not in ("local", "task") else (keys[1:2] or [""])[0]
        last = code[-1].text.lower() if code else ";"
        opens = sum(_OPENS.get(key, 0) for key in keys) - sum(key in _CLOSES for key in keys)
        begins = head in _ROUTINES
        return LineFacts(
            said,
            names_among(said, str.lower),
            tuple(_declared(head, code, local=first == "local")),
            begins=begins,
            ends=any(key in _ENDS for key in keys),
            opens=opens,
            stays=first in _STAYS or first.startswith("%%%"),
            complete=last in (";", ":", ")") or last in _COMPLETE or (begins and head == "trap"),
        )

    def known(self) -> Mapping[str, KnownWord]:
        return _known()

    def no_name(self, name: str, instead_of: str) -> str:  # noqa: ARG002
        low = name.lower()
        if not _NAME.fullmatch(name):
            return "is not of letters, digits and `_`, beginning with a letter"
        if len(name) > LONGEST_NAME:
            return f"is longer than {LONGEST_NAME} characters"
        if low in RESERVED:
            return "is a word of the language"
        return "is known to every controller" if low in predefined.taken_names() else ""

    def members(self, detail: str) -> Mapping[str, str]:
        type = predefined.types().get(detail.rpartition(" ")[2].lower())
        return {} if type is None else (type.components or {})

    def options(self, name: str) -> Mapping[str, str]:
        called = predefined.signature(name)
        slots = () if called is None else called.slots
        return {one.name: one.type for slot in slots if slot.optional for one in slot.alternatives}

    def colours(self) -> Mapping[str, str]:
        return {
            "string.quoted.double": r'"(?:[^"]|"")*"',
            "comment.line": r"!.*$",
            "constant.numeric": r"(?<![A-Za-z0-9_])(?:0[xX][0-9A-Fa-f]+|0[bB][01]+"
            r"|[0-9]+\.?[0-9]*(?:[eE][-+]?[0-9]+)?)",
            "variable.parameter": r"\\[A-Za-z][A-Za-z0-9_]*",
            "entity.name.function": r"(?i)(?<=\b(?:PROC|TRAP)\s)[A-Za-z][A-Za-z0-9_]*",
        }


def _words(line: str) -> Iterator[Word]:
    before = ""
    for word in words(line):
        kind = _KINDS.get(word.kind)
        if kind is None:
            continue
        if kind == "name" and before in (".", "\\"):
            kind = "property"
        if word.kind == "comment" and not word.text.startswith("!"):
            kind = "operator"
        yield Word(kind, word.start, word.end, word.text)
        before = word.text


def _declared(head: str, code: Sequence[Word], *, local: bool) -> Iterator[Declaration]:
    scope: Scope = "file" if local else "task"
    names = [word for word in code if word.kind == "name"]
    if head in _ROUTINES and names:
        # The type of a function stands before its name.
        place = 1 if head == "func" and len(names) > 1 else 0
        name = names[place]
        rest = [word for word in code if word.start > name.start]
        detail = _shown(rest)
        result = f" → {names[0].text}" if place else ""
        yield _declaration(name, _ROUTINES[head], scope, detail + result)
        yield from _parameters(rest)
    elif head in ("const", "var", "pers") and len(names) > 1:
        kind: DeclaredKind = "constant" if head == "const" else "variable"
        kind = "target" if names[0].text.lower() in ("robtarget", "jointtarget") else kind
        detail = f"{head.upper()} {names[0].text}"
        yield replace(_declaration(names[1], kind, scope, detail), fixed=head == "const")
    elif head == "record" and names:
        yield _declaration(names[0], "record", scope, "")
    elif head == "alias" and len(names) > 1:
        yield _declaration(names[1], "type", scope, f"ALIAS {names[0].text}")
    elif head == "module" and names:
        yield _declaration(names[0], "module", "task", "")
    elif head == "for" and names:
        yield _declaration(names[0], "variable", "routine", "FOR")
    elif len(code) > 1 and code[0].kind == "name" and code[1].text == ":":
        yield _declaration(code[0], "label", "routine", "")


def _declaration(name: Word, kind: DeclaredKind, scope: Scope, detail: str) -> Declaration:
    return Declaration(name.text, kind, name.start, name.end, scope, detail)


def _parameters(rest: Sequence[Word]) -> Iterator[Declaration]:
    """Type and name of each, the modes before them left aside; of a line as far as it goes."""
    part: list[Word] = []
    for word in rest:
        if word.kind in ("name", "property"):
            part.append(word)
        elif word.text in (",", ")", "|"):
            if len(part) > 1:
                yield _declaration(part[1], "parameter", "routine", part[0].text)
            part = []


def _shown(code: Sequence[Word]) -> str:
    text = ""
    for word in code:
        blank = text and text[-1].isalnum() and word.text[0].isalnum()
        text += (" " if blank or text.endswith(",") else "") + word.text
    return text


@cache
def _known() -> Mapping[str, KnownWord]:
    found = {word: KnownWord(word.upper(), "keyword") for word in sorted(RESERVED)}
    for low, type in predefined.types().items():
        parts = ", ".join(f"{of} {name}" for name, of in (type.components or {}).items())
        found[low] = KnownWord(type.name, "type", f"RECORD: {parts}" if parts else "")
    for low, datum in predefined.data().items():
        found[low] = KnownWord(datum.name, "variable", f"{datum.storage} {datum.type}")
    about = abouts("assistant.languages.rapid.tables")
    for low, (line, option) in predefined.rows().items():
        sort = "function" if line.startswith("FUNC") else "instruction"
        head, _, tail = line.partition("(")
        name = head.rpartition(" ")[2]
        shown = f"{head.partition(' ')[2]}({tail}" if sort == "function" else f"{name} {tail[:-1]}"
        with_option = f"Comes with the option {option}." if option else ""
        told = " ".join(part for part in (about.get(low, ""), with_option) if part)
        found[low] = KnownWord(name, sort, shown.strip(), told)
    return found
