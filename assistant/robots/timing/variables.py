"""Which variables a statement names."""

from __future__ import annotations

import re
from typing import Any, Final

from assistant.program.expressions import Expression, Index, Member, Name
from assistant.program.rewriting import records
from assistant.program.statements import Follow, Opaque, Statement

WORD: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def words(text: str) -> set[str]:
    """All that may be names in the text of a statement, in lower case."""
    return {word.lower() for word in WORD.findall(text)}


def root(target: Expression) -> str:
    """The variable, in lower case, that a target of an assignment is of."""
    while isinstance(target, Member | Index):
        target = target.value
    return target.name.lower() if isinstance(target, Name) else ""


def mentions(statement: Statement, name: str) -> bool:
    """Whether a statement may read a variable; name: in lower case."""
    if isinstance(statement, Opaque):
        return name in words(statement.text)
    parts: Any = records(statement)
    return not isinstance(statement, Follow) and any(
        isinstance(part, Name) and part.name.lower() == name for part in parts
    )
