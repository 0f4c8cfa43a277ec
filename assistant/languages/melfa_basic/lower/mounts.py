"""`Tool`, `Base` and speeds written once, where a procedure and all that it calls have the same.

The writer sets them before the first move of each procedure, and again after each statement that
may change them (`mount_keeper`). Here they go to the begin of the procedures from which no other
value is reached; what these call keeps them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import accumulate
from typing import Final, TypeGuard

from assistant.languages.melfa_basic.tables.equivalents import ARM_FUNCTIONS
from assistant.languages.melfa_basic.text.printer import line as line_text
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.analysis.uses import along_calls, base_variable, called
from assistant.program.program import Procedure, Program, walk
from assistant.program.rewriting import head, records
from assistant.program.undeclared_names import interrupts

MOUNT_WORDS: Final = ("Base", "Tool")
_ONCE_WORDS: Final = ("Spd", "JOvrd", *MOUNT_WORDS)
"""The last one is written above the others."""


RESTING: Final = (
    p.Wait, p.WaitSignal, p.WaitUntil, p.StartTimer, p.SetSignal, p.Gripper, p.Assign,
    p.If, p.While, p.For, p.Switch, p.Comment, p.Message,
)  # fmt: skip
"""Statements that neither move the arm nor set a tool or base, but perhaps in what they hold or
call."""


def mount_keeper(program: Program) -> Callable[[p.Statement], bool]:
    """Return a test of statements: True if `Tool` and `Base` surely are the same after one.

    Not after a stop, where somebody may set another tool, nor where labels let control in. Never in
    a program with vendor text or interrupts that may set them, nor in one of several units.
    """
    several = any(one.unit is not None for one in program.procedures)
    if several or any(isinstance(one, p.Opaque) for one in program.statements()):
        return lambda _: False
    mounts = _mount_names(program)
    changing = _changing_procedures(program, mounts)
    if not _interrupts_keep(program, changing):
        return lambda _: False

    def keeps(statement: p.Statement) -> bool:
        for one in walk_without_ends((statement,)):
            if not _keeps(one, mounts):
                return False
            for part in records(head(one)):
                match part:
                    case p.Call(name) if changing.get(name.lower(), one):
                        return False
                    case e.Apply(name) if changing.get(name.lower()):
                        return False
        return True

    return keeps


def are_unchanged_by_interrupts(program: Program) -> bool:
    """True if no interrupt of a program sets or reads a tool or base, or leads elsewhere."""
    return _interrupts_keep(program, _changing_procedures(program, _mount_names(program)))


def _interrupts_keep(program: Program, changing: Mapping[str, Set[str]]) -> bool:
    """changing: see `_changing_procedures`."""
    return all(
        one.ends is None
        # A procedure that the program lacks may do anything.
        and not changing.get(one.call.procedure.lower(), {one.call.procedure})
        and not any(map(_reads_mounts, records(one.condition)))
        for one in interrupts(program)
    )


def _mount_names(program: Program) -> frozenset[str]:
    return frozenset(name.lower() for name in (*program.tools, *program.frames))


def _changing_procedures(program: Program, mounts: Set[str]) -> Mapping[str, Set[str]]:
    """Names of the procedures among each one and its callees that may set a tool or base."""
    own = {
        one.name.lower(): frozenset(
            ()
            if all(_keeps(x, mounts) for x in walk_without_ends(one.body))
            else {one.name.lower()}
        )
        for one in program.procedures
    }
    return along_calls(program, own)


def walk_without_ends(body: tuple[p.Statement, ...]) -> Iterator[p.Statement]:
    """Yield statements and those inside them, but for the stops of loops that only stop.

    Settings at such a stop do not matter: only a start at the first line follows.
    """
    ends: set[int] = set()
    for one in walk(body):
        match one:
            case p.While(e.Number(value=value), inner) if value and _only_stops(inner):
                ends.update(map(id, inner))
        if id(one) not in ends:
            yield one


def _only_stops(body: tuple[p.Statement, ...]) -> bool:
    return bool(body) and all(isinstance(one, p.Stop) for one in body)


def _reads_mounts(part: object) -> bool:
    """True for a part of an expression that is read with the active tool and base."""
    match part:
        case e.Here() | e.Verbatim():
            return True
        case e.Apply(function):
            return function.lower() in ARM_FUNCTIONS
    return False


def _keeps(statement: p.Statement, mounts: Set[str]) -> bool:
    """True if a statement itself sets no tool or base. mounts: names of tools and frames."""
    if not isinstance(statement, (*RESTING, p.Call, p.Return)):
        return False
    for part in records(head(statement)):
        # Each is read with the tool and base that it names.
        if _reads_mounts(part):
            return False
        if isinstance(part, p.Assign) and base_variable(part.target) in mounts:
            return False
    return True


def mounted_once(
    program: Program,
    items: Sequence[s.Item],
    parts: Sequence[tuple[Procedure, int]],
    settings: set[int],
) -> list[s.Item]:
    """Return the lines of a program's procedures with fewer of these settings.

    parts: the procedures with the index of their first line, the entry first. settings: the
    settings among the lines, by identity; what is written anew is added. No other line of the
    program may set a tool, base or speed, or depend on it.
    """
    found = list(items)
    begins = [begin for _, begin in parts]
    for word in _ONCE_WORDS:
        if not all(_is_fixed(one) for one in found if _is_setting(one, settings, word)):
            continue
        pieces = [found[a:b] for a, b in zip(begins, [*begins[1:], len(found)], strict=True)]
        shorter = _without_repeats(program, [q for q, _ in parts], pieces, settings, word)
        if sum(map(len, shorter)) < sum(map(len, pieces)):
            found = [*found[: begins[0]], *(item for piece in shorter for item in piece)]
            begins = [*accumulate(map(len, shorter[:-1]), initial=begins[0])]
    return found


def _without_repeats(
    program: Program,
    procedures: Sequence[Procedure],
    pieces: Sequence[list[s.Item]],
    settings: set[int],
    word: str,
) -> list[list[s.Item]]:
    """Return the lines of each procedure with this setting at the begin of some of them."""
    keys = [procedure.name.lower() for procedure in procedures]
    written = [
        {line_text(one): one for one in piece if _is_setting(one, settings, word)}
        for piece in pieces
    ]
    lines = {text: one for found in written for text, one in found.items()}
    own = {key: frozenset(found) for key, found in zip(keys, written, strict=True)}
    calls = {one.name.lower(): own.keys() & set(called(one)) for one in procedures}
    # What procedures that never run leave set is known to no reader.
    reached = reachable(keys[:1], calls.__getitem__)
    used = along_calls(program, own)
    only = {key: next(iter(used[key])) for key in reached if len(used[key]) == 1}
    callers: dict[str, set[str]] = {key: set() for key in keys}
    for key, callees in calls.items():
        for callee in callees:
            callers[callee].add(key)
    found = []
    for key, piece in zip(keys, pieces, strict=True):
        if key not in only:
            found.append(piece)
            continue
        kept = [item for item in piece if not _is_setting(item, settings, word)]
        if key == keys[0] or not _is_set_by(callers[key], only, only[key]):
            made = replace(lines[only[key]])
            settings.add(id(made))
            kept.insert(_first_statement(kept), made)
        found.append(kept)
    return found


def _is_set_by(callers: set[str], only: Mapping[str, str], value: str) -> bool:
    """True if all callers of a procedure run, and have a value all the time."""
    return all(only.get(caller) == value for caller in callers)


def _is_fixed(line: s.Line) -> bool:
    """True if what a setting sets is the same whenever the line is reached."""
    match line.statement:
        case s.Command(keyword="Spd" | "JOvrd", arguments=arguments):
            return all(isinstance(one, s.Number) for one in arguments)
    return True


def _is_setting(item: s.Item, settings: set[int], word: str) -> TypeGuard[s.Line]:
    match item:
        case s.Line(statement=s.Command(keyword=keyword), label=None, comment=None):
            return keyword == word and id(item) in settings
    return False


def _first_statement(items: Sequence[s.Item]) -> int:
    """Return the index of the first line that is no comment."""
    for index, item in enumerate(items):
        if not isinstance(item, s.Line) or item.statement is not None or item.label is not None:
            return index
    return len(items)
