"""Any program as a language says it, by passes and by what its tree can be built of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from assistant.base.diagnostics import Findings, Refused
from assistant.languages.answers import (
    Adapted,
    Tree,
)
from assistant.languages.language import Language
from assistant.program.passes.legalisation import Capabilities, Legalisation, Pass, legalise
from assistant.program.program import Program
from assistant.robots import Robot

T = TypeVar("T", bound=Tree)


def adapted(
    language: Language[T],
    program: Program,
    can: Capabilities,
    passes: Sequence[Pass],
    robot: Robot | None = None,
) -> Adapted:
    """The program after all passes; what its tree cannot be built of even then is an error.

    For a language whose programs are one unit.
    """
    findings = Findings()
    program = legalise(Legalisation(program, can, findings), passes)
    trees: dict[str | None, T] = {}
    try:
        trees[None] = language.build(program, robot)
    except Refused as refused:
        findings += refused.findings
    return Adapted(program, tuple(dict.fromkeys(findings)), trees)
