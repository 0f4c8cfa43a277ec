"""Which variables a statement names."""

from __future__ import annotations

from typing import Any

from assistant.program.expressions import Expression, Index, Member, Name
from assistant.program.rewriting import records
from assistant.program.statements import Follow, Opaque, Statement
from assistant.program.vendor_statements import effect_of


def root_variable(target: Expression) -> str:
    """The variable, in lower case, that a target of an assignment is of."""
    while isinstance(target, Member | Index):
        target = target.value
    return target.name.lower() if isinstance(target, Name) else ""


def may_read(statement: Statement, name: str) -> bool:
    """Whether a statement may read a variable; name: in lower case."""
    if isinstance(statement, Opaque):
        return name in effect_of(statement).names
    parts: Any = records(statement)
    return not isinstance(statement, Follow) and any(
        isinstance(part, Name) and part.name.lower() == name for part in parts
    )
