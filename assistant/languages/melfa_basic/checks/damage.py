"""Damaged lines: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import function, statements, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Diagnostic, Severity
from assistant.program.text import SourceText

_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]*")
_CODE: Final = re.compile(r"[ \t]*([0-9]{0,9})[ \t]*(.*)", re.DOTALL)
_PLAIN: Final = re.compile(r"[A-Z][A-Z0-9_]*[$%&!#]?(?:\(.*\))?(?:\.[A-Z0-9]+)?[ \t]*=")
"""Begin of an assignment."""
WORDS: Final = frozenset(part.upper() for word in statements() for part in word.split())
LEADING: Final = frozenset(
    """
    ACCEL CMP COLCHK DLY ERROR FINE HCLOSE HOPEN HLT JOVRD LOADSET MOV MVA MVC MVR MVR2 MVR3 MVS
    OADL OVRD PRINT PREC SERVO SPD TORQ WAIT
    """.split()  # noqa: SIM905
)
"""Words of statements that run on to the next line and that no other line depends on."""
STEERING: Final = frozenset(
    """
    ACT BASE BREAK CALL CALLP CASE CLOSE CNT DEF DEFAULT ELSE ELSEIF END ENDIF EXIT FEND FOR
    FUNCTION GETM GOSUB GOTO IF INCLUDE NEXT ON OPEN RELM RETURN SELECT SKIP STEP THEN TO TOOL
    WEND WHILE XRUN
    """.split()  # noqa: SIM905
)
"""Words that others are paired with, that lead elsewhere, or that hold from there on."""


_BROKEN_NAME: Final = re.compile(
    r"(?![A-Z*])|\*[ \t]*(?![A-Z])|\*[ \t]*\w+[ \t]+\w|[A-Z]\w*[ \t]+\w+[ \t]*[(=]"
)
"""Begin of a line whose label or variable is left out, or parted by a blank."""
DECLARING: Final = frozenset("CONST DEF DIM FPRM FUNCTION INPUT STATIC".split())  # noqa: SIM905


@dataclass(frozen=True, slots=True)
class Damage:
    """What cannot be read in the files of a program.

    lines: with their files. names: what stands on them and is no word of the language, in upper
    case. plain: none of them can be a jump, a label, part of a block or a setting. named: none of
    them can define what it does not name. steps: their numbers.
    """

    lines: frozenset[tuple[str | None, int]]
    names: frozenset[str]
    plain: bool
    named: bool
    steps: frozenset[int]

    def explains(self, finding: Diagnostic, source: SourceText | None) -> bool:
        """Whether a finding in a file may follow from the damage."""
        if finding.line is None or source is None:
            return False
        for line in range(finding.line, (finding.end_line or finding.line) + 1):
            if (finding.path, line) in self.lines:
                return True
            if not self.names.isdisjoint(names_in(source.line_text(line))):
                return True
        return False


def damage_of(trees: Sequence[s.File]) -> Damage | None:
    """What is damaged in the files of a program, None for nothing."""
    found = {(f.path, line): source.line_text(line) for source, f, line in _damaged(trees)}
    if not found:
        return None
    parts = [part for text in found.values() if (part := _CODE.match(text.upper()))]
    code = [part[2] for part in parts]
    plain = all(map(_is_plain, code))
    named = not any("#" in line or _is_broken(line) for line in code)
    return Damage(
        frozenset(found),
        frozenset(name for line in code for name in names_in(line)),
        plain,
        named and (plain or not any(map(_has_functions, trees))),
        frozenset(int(part[1]) for part in parts if part[1]),
    )


def names_in(text: str) -> Iterator[str]:
    """Names in a text that are no words of the language, in upper case."""
    for word in _NAME.findall(text.upper()):
        if word not in WORDS and status(word) is None and function(word) is None:
            yield word


def _damaged(trees: Sequence[s.File]) -> Iterator[tuple[SourceText, Diagnostic, int]]:
    """Each line with a syntax error: the text that it stands in, the finding, and its number."""
    for tree in trees:
        for finding in tree.findings:
            if finding.severity is Severity.ERROR and finding.line and tree.source is not None:
                for line in range(finding.line, (finding.end_line or finding.line) + 1):
                    yield tree.source, finding, line


def _is_broken(code: str) -> bool:
    """Whether a damaged line may define something whose name is damaged as well."""
    first = _NAME.match(code)
    if first is not None and first[0] in WORDS:
        return first[0] in DECLARING
    return _BROKEN_NAME.match(code) is not None


def _is_plain(code: str) -> bool:
    """Whether a damaged line, in upper case and without its step number, runs on to the next."""
    words = _NAME.findall(code)
    leads = _PLAIN.match(code) is not None or (bool(words) and words[0] in LEADING)
    return leads and "*" not in code and STEERING.isdisjoint(words)


def _has_functions(tree: s.File) -> bool:
    return any(
        isinstance(item, s.Line)
        and (isinstance(item.statement, s.Function) or item.statement == s.Command("FEnd"))
        for item in tree.items
    )
