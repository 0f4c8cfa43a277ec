"""Rules of where declarations and handlers may stand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import plain_rules
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s

RANKS: Final[tuple[tuple[Any, int, str], ...]] = (
    (s.Record | s.Alias, 0, "a record"),
    (s.Data | s.TargetRunNode, 1, "data"),
    (s.Routine, 2, "a routine"),
)
AFTER: Final = {1: "data", 2: "a routine"}
KINDS: Final = ("BACKWARD", "ERROR", "UNDO")


def declarations(look: Look) -> Found:
    """Records, data, routines in a module; declarations, then statements in a routine."""
    seen = 0
    for item in look.module.items:
        rank, what = next(((r, w) for kind, r, w in RANKS if isinstance(item, kind)), (seen, ""))
        if rank < seen:
            yield look.finding(rules.OUT_OF_ORDER, item, what=what, after=AFTER[seen])
        seen = max(seen, rank)
    for routine in look.routines:
        yield from _declarations_first(look, routine.body)


def _declarations_first(look: Look, body: Sequence[s.StatementNode]) -> Found:
    stated = False
    for node in body:
        if isinstance(node, s.Data | s.TargetRunNode):
            if stated:
                yield look.finding(
                    rules.OUT_OF_ORDER, node, what="a declaration", after="a statement"
                )
        elif not isinstance(node, s.CommentLine | s.Placeholder):
            stated = True


def handlers(look: Look) -> Found:
    """At most one of each kind, in one order; BACKWARD of procedures only."""
    for routine in look.routines:
        yield from _handlers(look, routine)


def _handlers(look: Look, routine: s.Routine) -> Found:
    before = -1
    for handler in routine.handlers:
        at = KINDS.index(handler.kind)
        if at <= before:
            what = "a second time" if at == before else f"behind {KINDS[before]}"
            yield look.finding(plain_rules.HANDLER_PLACE, handler, kind=handler.kind, what=what)
        elif handler.kind == "BACKWARD" and routine.kind != "PROC":
            what = f"in a {routine.kind}"
            yield look.finding(plain_rules.HANDLER_PLACE, handler, kind=handler.kind, what=what)
        before = max(before, at)
