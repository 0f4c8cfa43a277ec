"""Tasks that wait for each other (`WaitSyncTask`), as a count that all programs share.

Each program adds one where it comes to a point, and goes on once all have come. They come to it as
often as each other, so that the count tells how often all have met: nobody is ahead by a turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.text import effects, verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Variable

_ONE: Final = e.Number(1)
TASKS: Final = "tasks"
"""The type of data of the lists."""


def task_lists(program: Program) -> Mapping[str, int]:
    """How many tasks each declared list has, by its lower-case name."""
    if program.origin is None or program.origin.language != verbatim.LANGUAGE:
        return {}
    items = (i for file in program.origin.trees for m in file.modules for i in m.items)
    return {
        item.name.lower(): sum(map(_names, item.value.items))
        for item in items
        if isinstance(item, s.Data)
        and isinstance(item.value, s.AggregateNode)
        and item.type.lower() == TASKS
    }


def _names(row: s.Expression) -> bool:
    """Whether a row of a list names a task: those that are not needed are empty."""
    match row:
        case s.AggregateNode((s.StringLiteral(name),)):
            return bool(name.strip())
    return True


def together(program: Program) -> frozenset[str]:
    """Lists of tasks in lower case whose arms are to move together anywhere."""
    calls = (
        node
        for one in program.statements()
        if isinstance(one, p.Opaque) and one.language == verbatim.LANGUAGE
        for node in verbatim.understood(verbatim.statements, one.text) or ()
    )
    return frozenset(
        listed.lower()
        for node in calls
        if isinstance(node, s.ProcedureCall) and str(node.name).lower() == "syncmoveon"
        for listed in (_listed(node),)
        if listed
    )


def _listed(call: s.ProcedureCall) -> str:
    match [one.value for one in call.arguments if isinstance(one, s.Positional)]:
        case [_, s.NameRef(name)]:
            return name
    return ""


def shared(point: str) -> tuple[str, Variable]:
    """The count of a point that all programs of a controller have: its name, and what it is."""
    return f"M_{point}", Variable("number", storage="persistent")


DUE: Final = "all_there"
"""The count at which a program goes on."""


def met(call: Called[s.Expression], lists: Mapping[str, int]) -> Iterator[p.Statement]:
    """A wait for all tasks of a list; the arm stands there where it says so."""
    match call.given:
        case (s.NameRef(point), s.NameRef(listed)) if listed.lower() in lists:
            if call.options.keys() - {"inpos"}:
                return
            here, due = e.Name(shared(point)[0]), e.Name(DUE)
            count = e.Number(lists[listed.lower()])
            if call.options:
                text = "WaitRob\\InPos;"
                yield p.Opaque(verbatim.LANGUAGE, text, effect=effects.of_text(text, "statement"))
            met = e.Apply("trunc", (e.Binary("/", here, count),))
            yield p.Assign(due, e.Binary("*", e.Binary("+", met, _ONE), count))
            yield p.Assign(here, e.Binary("+", here, _ONE))
            yield p.WaitUntil(e.Binary(">=", here, due))
