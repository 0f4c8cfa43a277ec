"""Damaged lines: what is found elsewhere must not follow from what cannot be read there."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

from assistant.languages.checks import registry
from assistant.languages.checks.registry import Damage, Needs
from assistant.languages.melfa_basic.tables.vocabulary import function, statements, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import block_word, statement_of

_NAME: Final = re.compile(r"[A-Z][A-Z0-9_]*")
_CODE: Final = re.compile(r"[ \t]*([0-9]{0,9})[ \t]*(.*)", re.DOTALL)
_PLAIN: Final = re.compile(r"[A-Z][A-Z0-9_]*[$%&!#]?(?:\(.*\))?(?:\.[A-Z0-9]+)?[ \t]*=")
"""Begin of an assignment."""
LANGUAGE_WORDS: Final = frozenset(part.upper() for word in statements() for part in word.split())
RUN_ON_WORDS: Final = frozenset(
    """
    ACCEL CMP COLCHK DLY ERROR FINE HCLOSE HOPEN HLT JOVRD LOADSET MOV MVA MVC MVR MVR2 MVR3 MVS
    OADL OVRD PRINT PREC SERVO SPD TORQ WAIT
    """.split()  # noqa: SIM905
)
"""Words of statements that run on to the next line and that no other line depends on."""
STEERING_WORDS: Final = frozenset(
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
DECLARING_WORDS: Final = frozenset("CONST DEF DIM FPRM FUNCTION INPUT STATIC".split())  # noqa: SIM905


def damage_of(trees: Sequence[s.File]) -> Damage | None:
    """What is damaged in the files of a program, None for nothing."""
    return registry.damage_of(trees, names_in)


def spoiled(trees: Sequence[s.File], damage: Damage | None) -> Needs:
    """What the files lack: `ORDER` if a damaged line can be a jump, a label, part of a block or a
    setting; `NAMES` if one can define what it does not name.
    """
    if damage is None:
        return Needs.NOTHING
    code = [part[2] for part in _damaged_parts(damage)]
    spoils = Needs.WHOLE
    if not all(map(_runs_on, code)):
        spoils |= Needs.ORDER
    hidden = Needs.ORDER in spoils and any(map(_has_functions, trees))
    if hidden or any("#" in line or _is_broken(line) for line in code):
        spoils |= Needs.NAMES
    return spoils


def steps_of(damage: Damage | None) -> set[int]:
    """The step numbers of the damaged lines."""
    return set() if damage is None else {int(part[1]) for part in _damaged_parts(damage) if part[1]}


def _damaged_parts(damage: Damage) -> list[re.Match[str]]:
    return [part for text in damage.texts if (part := _CODE.match(text.upper()))]


def names_in(text: str) -> Iterator[str]:
    """Names in a text that are no words of the language, in upper case."""
    for word in _NAME.findall(text.upper()):
        if word not in LANGUAGE_WORDS and status(word) is None and function(word) is None:
            yield word


def _is_broken(code: str) -> bool:
    """Whether a damaged line may define something whose name is damaged as well."""
    first = _NAME.match(code)
    if first is not None and first[0] in LANGUAGE_WORDS:
        return first[0] in DECLARING_WORDS
    return _BROKEN_NAME.match(code) is not None


def _runs_on(code: str) -> bool:
    """Whether a damaged line, in upper case and without its step number, runs on to the next."""
    words = _NAME.findall(code)
    leads = _PLAIN.match(code) is not None or (bool(words) and words[0] in RUN_ON_WORDS)
    return leads and "*" not in code and STEERING_WORDS.isdisjoint(words)


def _has_functions(tree: s.File) -> bool:
    return any(block_word(statement_of(item)).bounds for item in tree.items)
