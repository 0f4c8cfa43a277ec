"""Waits with a time limit, and waits of tasks for each other.

A wait with `MaxTime` that reports its end by a flag (`TimeFlag`) becomes a loop with a timer.
`WaitSyncTask` becomes a count that all programs share: each program adds one at a point, and goes
on once all have arrived. They arrive equally often, so that the count states how often all have met
and no program is ahead by a cycle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_statements import is_by_gateway
from assistant.languages.rapid.tables.constants import TASK_COUNT_SUFFIX
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called
from assistant.program.program import Program, Variable, walk
from assistant.program.rewriting import is_repeatable, records

WAIT_TIMER: Final = "wait_time"
"""The timer of all of them: no such wait begins in another one."""


def flagged_wait(
    call: Called[s.Expression], meaning: NameResolver, program: Program
) -> Iterator[p.Statement]:
    """One that tells by a flag whether its time was over."""
    options = dict(call.options)
    flag = options.pop("timeflag", None)
    wait = lift_call(Called(call.word, call.given, options), meaning) if flag is not None else None
    if flag is None or not isinstance(wait, p.WaitSignal | p.WaitUntil) or wait.timeout is None:
        return
    over = meaning.expression(flag)
    if isinstance(over, e.Name | e.Index) and _is_free_of_effects(wait_condition(wait), program):
        # The flag is assigned in the loop, so the condition must not ask for it.
        if over not in records(wait_condition(wait)):
            yield from wait_until_over(wait, over)


def _is_free_of_effects(asked: e.Expression, program: Program) -> bool:
    """True if a condition may be evaluated any number of times while the program waits for it.

    The controller decides how often it calls functions of the user; they may only assign variables,
    end the program, and ask a gateway for its number of bytes.
    """
    if is_repeatable(asked):
        return True
    known = {q.name.lower(): q for q in program.procedures}
    parts = [*records(asked)]
    pending = [x.function.lower() for x in parts if isinstance(x, e.Apply)]
    # Text of RAPID may do anything, and what takes data from a channel takes it once.
    if any(isinstance(x, e.Verbatim) for x in parts) or set(pending) & set(e.TAKING):
        return False
    seen = set[str]()
    while pending:
        key = pending.pop()
        if key in seen or key not in known:
            if key not in seen and key not in e.FUNCTIONS:
                return False
            continue
        seen.add(key)
        if not all(
            isinstance(node, _QUIET_STATEMENTS) or _ends_program(node) or is_by_gateway(node)
            for node in walk(known[key].body)
        ):
            return False
        pending += called(known[key])
    return True


_QUIET_STATEMENTS: Final = (p.Assign, p.Call, p.Comment, p.If, p.For, p.While, p.Switch, p.Return)
"""Statements that give values to variables alone, and lead to them."""


def _ends_program(node: p.Statement) -> bool:
    """True if it ends the program, which it does once."""
    return isinstance(node, p.Stop) and node.end


def wait_condition(wait: p.WaitSignal | p.WaitUntil) -> e.Expression:
    """Return the condition of a wait."""
    if isinstance(wait, p.WaitUntil):
        return wait.condition
    return e.Binary("=", e.Name(wait.signal), wait.value)


def wait_until_over(wait: p.WaitSignal | p.WaitUntil, over: e.Expression) -> Iterator[p.Statement]:
    """A wait with a longest time, behind which `over` tells whether that has passed.

    What holds already is asked for before the time is, so that it is found in any time, also in
    none.
    """
    assert wait.timeout is not None
    goes_on = e.Binary("and", over, e.Binary("<", e.Elapsed(WAIT_TIMER), wait.timeout))
    longest = e.plain_number(wait.timeout)
    if longest is not None and longest >= _LASTING:
        there = p.Branch(wait_condition(wait), (p.Assign(over, e.Truth(False)),))
        yield p.Assign(over, e.Truth(True))
        yield p.StartTimer(WAIT_TIMER)
        yield p.While(goes_on, (p.If((there,)),))
        return
    asked = p.Assign(over, e.Unary("not", wait_condition(wait)))
    yield asked
    yield p.StartTimer(WAIT_TIMER)
    yield p.While(goes_on, (asked,))


_LASTING: Final = 0.5
"""Seconds that have not passed between the start of a timer and the next statement, also where an
interrupt is answered there."""


_ONE: Final = e.Number(1)
_TASK_LIST_TYPE: Final = "tasks"
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
                type.lower() == _TASK_LIST_TYPE
            ):
                counts.setdefault(name.lower(), set()).add(sum(map(_names_task, rows)))
            case s.Data(name=name) if name.lower().endswith(TASK_COUNT_SUFFIX):
                stated[name.lower().removesuffix(TASK_COUNT_SUFFIX)] = e.Name(name)
            case s.Routine():
                for node in nodes(item):
                    match node:
                        case s.Assignment(s.NameRef(name), s.AggregateNode(rows)) if rows and all(
                            map(_is_task_row, rows)
                        ):
                            counts.setdefault(name.lower(), set()).add(sum(map(_names_task, rows)))
    # A list with different numbers of tasks has no fixed count.
    known = {name: e.Number(*found) for name, found in counts.items() if len(found) == 1}
    return {**{name: one for name, one in stated.items() if name not in counts}, **known}


def _is_task_row(row: s.Expression) -> bool:
    match row:
        case s.AggregateNode((s.StringLiteral(),)):
            return True
    return False


def _names_task(row: s.Expression) -> bool:
    """True if a row of a list names a task: unused rows are empty."""
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
    """Yield a wait for all tasks of a list; with `InPos` the arm stops there first."""
    match call.given:
        case (s.NameRef(point), s.NameRef(listed)) if listed.lower() in lists:
            if call.options.keys() - {"inpos"}:
                return
            here, due = e.Name(sync_counter(point)[0]), e.Name(SYNC_DUE)
            count = lists[listed.lower()]
            if call.options:
                text = "WaitRob\\InPos;"
                yield p.Opaque(
                    verbatim.LANGUAGE, text, effect=verbatim.effect_of_text(text, "statement")
                )
            # Computed before this program arrives: the next multiple of the count is the meeting at
            # hand.
            met = e.Apply("trunc", (e.Binary("/", here, count),))
            yield p.Assign(due, e.Binary("*", e.Binary("+", met, _ONE), count))
            yield p.Assign(here, e.Binary("+", here, _ONE))
            yield p.WaitUntil(e.Binary(">=", here, due))
