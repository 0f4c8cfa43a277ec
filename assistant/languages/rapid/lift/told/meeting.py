"""Tasks that wait for each other (`WaitSyncTask`), as a count that all programs share.

Each program adds one where it comes to a point, and goes on once all have come. They come to it as
often as each other, so that the count tells how often all have met: nobody is ahead by a turn.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.tables.states import COUNT
from assistant.languages.rapid.text import effects, verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Variable

_ONE: Final = e.Number(1)
TASK_LIST_TYPE: Final = "tasks"
"""The type of data of the lists."""


def task_lists(program: Program) -> Mapping[str, e.Expression]:
    """Number of tasks of each list, by its lower-case name.

    For a list without values in the program, the cell's; for one that is given another
    number of tasks as the program runs nothing.
    """
    if program.origin is None or program.origin.language != verbatim.LANGUAGE:
        return {}
    items = [i for file in program.origin.trees for m in file.modules for i in m.items]
    counts: dict[str, set[int]] = {}
    stated: dict[str, e.Expression] = {}
    for item in items:
        match item:
            case s.Data(type=type, name=name, value=s.AggregateNode(rows)) if (
                type.lower() == TASK_LIST_TYPE
            ):
                counts.setdefault(name.lower(), set()).add(sum(map(_names_task, rows)))
            case s.Data(name=name) if name.lower().endswith(COUNT):
                stated[name.lower().removesuffix(COUNT)] = e.Name(name)
            case s.Routine():
                for node in nodes(item):
                    match node:
                        case s.Assignment(s.NameRef(name), s.AggregateNode(rows)) if rows and all(
                            map(_is_task_row, rows)
                        ):
                            counts.setdefault(name.lower(), set()).add(sum(map(_names_task, rows)))
    known = {name: e.Number(*found) for name, found in counts.items() if len(found) == 1}
    return {**{name: one for name, one in stated.items() if name not in counts}, **known}


def _is_task_row(row: s.Expression) -> bool:
    match row:
        case s.AggregateNode((s.StringLiteral(),)):
            return True
    return False


def _names_task(row: s.Expression) -> bool:
    """Whether a row of a list names a task: those that are not needed are empty."""
    match row:
        case s.AggregateNode((s.StringLiteral(name),)):
            return bool(name.strip())
    return True


def synchronised_lists(program: Program) -> frozenset[str]:
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
        for listed in (_list_name(node),)
        if listed
    )


def _list_name(call: s.ProcedureCall) -> str:
    match [one.value for one in call.arguments if isinstance(one, s.Positional)]:
        case [_, s.NameRef(name)]:
            return name
    return ""


def sync_counter(point: str) -> tuple[str, Variable]:
    """The count of a point that all programs of a controller have: its name, and what it is."""
    return f"M_{point}", Variable("number", storage="persistent")


SYNC_DUE: Final = "all_there"
"""The count at which a program goes on."""


def task_sync(
    call: Called[s.Expression], lists: Mapping[str, e.Expression]
) -> Iterator[p.Statement]:
    """A wait for all tasks of a list; the arm stands there where it says so."""
    match call.given:
        case (s.NameRef(point), s.NameRef(listed)) if listed.lower() in lists:
            if call.options.keys() - {"inpos"}:
                return
            here, due = e.Name(sync_counter(point)[0]), e.Name(SYNC_DUE)
            count = lists[listed.lower()]
            if call.options:
                text = "WaitRob\\InPos;"
                yield p.Opaque(verbatim.LANGUAGE, text, effect=effects.of_text(text, "statement"))
            met = e.Apply("trunc", (e.Binary("/", here, count),))
            yield p.Assign(due, e.Binary("*", e.Binary("+", met, _ONE), count))
            yield p.Assign(here, e.Binary("+", here, _ONE))
            yield p.WaitUntil(e.Binary(">=", here, due))
