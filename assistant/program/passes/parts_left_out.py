"""Parts of records that a language has no words for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from assistant.program.diagnostics import Rule
from assistant.program.passes.legalising import Legalisation, Pass
from assistant.program.program import Program
from assistant.program.rewriting import rewrite

Change = Callable[[Any], Any]


def leaving_out(told: Rule, changes: Mapping[type, tuple[str, Change]]) -> Pass:
    """A pass that changes the records of some types.

    told: tells what is left out. changes: of a type what that is, empty where nothing is lost by
    it, and the record without it.
    """

    def with_parts_left_out(job: Legalisation) -> Program:
        def plain(part: Any) -> Any:
            what, change = changes.get(type(part), ("", lambda same: same))
            made = change(part)
            if what and made != part:
                job.findings.append(told(what=what))
            return made

        return rewrite(job.program, plain)

    return with_parts_left_out
