"""What a program takes as given, or leaves to its controller, and another one must be told."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tables.functions import BITS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.assignment import Assigning
from assistant.program.analysis.uses import unordered
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.geometry import BASE, FLANGE
from assistant.program.program import Program, walk
from assistant.program.rewriting import head, records
from assistant.program.wholes import Numbers

KEPT: Final = (("Tool", FLANGE, "P_NTool", "M_TOOL"), ("Base", BASE, "P_NBase", "M_BSNO"))
"""Settings that stay when the power is off: statement, what counts without it, that said in
words, and the status variable that sets it as well."""

FIRST: Final[Mapping[str, str]] = {"number": "0", "integer": "0", "text": "an empty text"}
"""What a variable of a type begins with in other languages."""


def assumed(program: Program, to: str) -> Iterator[Diagnostic]:
    """Findings on a lifted program, with its spans, that is written anew in the language `to`."""
    trees = () if program.origin is None else program.origin.trees
    commands = list(_commands(trees))
    for word, default, plain, status in KEPT:
        set_at = [span for span, node in commands if _sets(node, word, status)]
        span = _first_move(program, default, word)
        if span is not None and all(one is not None and one.start > span.start for one in set_at):
            yield rules.SETTING_KEPT(word=word, what=word.lower(), plain=plain, span=span)
    if to not in DIALECTS:
        yield from _loops(program)
        yield from _signed_bits(program)
        yield from _without_value(program)
        yield from unordered(program, rules.CANNOT_SAY)
        for span, node in commands:
            if isinstance(node, s.Command) and node.keyword == "Cnt" and _cuts_nothing(node):
                yield rules.NO_CORNER(span=span)
            if isinstance(node, s.Command) and node.keyword == "JOvrd":
                yield rules.JOINT_OVERRIDE(span=span)


def _commands(trees: tuple[Any, ...]) -> Iterator[tuple[Span | None, s.Statement]]:
    """Statements with their spans, which count on from one text to the next."""
    start = 0
    for tree in trees:
        for item in tree.items:
            if isinstance(item, s.Line) and item.statement is not None:
                span = None if item.span is None else item.span.moved(start)
                for node in nodes(item.statement):
                    if isinstance(node, s.Command | s.Assign):
                        yield span, node
        start += len(tree.source.text if tree.source else "") + 1


def _sets(node: s.Statement, word: str, status: str) -> bool:
    match node:
        case s.Command(keyword=keyword):
            return keyword == word
        case s.Assign(target=target):
            return target.key == status
    return False


def _first_move(program: Program, default: str, word: str) -> Span | None:
    """Where the program first moves with a tool, or in a base, that it did not set till then."""
    for statement in program.statements():
        match statement:
            case p.Follow(path=path):
                used = set(path.tools if word == "Tool" else path.frames)
            case (
                p.Move(motion=motion) | p.MoveCircular(motion=motion) | p.MoveJoints(motion=motion)
            ):
                used = {motion.tool if word == "Tool" else motion.frame}
            case _:
                continue
        if default in used:
            return statement.span
    return None


def _cuts_nothing(node: s.Command) -> bool:
    match node.arguments:
        case (s.Number(value=1), *distances):
            return any(isinstance(d, s.Number) and d.value == 0 for d in distances)
    return False


def _without_value(program: Program) -> Iterator[Diagnostic]:
    """Variables that other languages begin with a value. A position that has none is no place
    there either; of arrays it is not known which elements are read.
    """
    entry = program.procedure(program.entry) if program.entry else None
    read = Assigning(program).run(entry).read if entry is not None else set()
    for name, variable in program.variables.items():
        own = variable.storage == "variable" and variable.initial is None and not variable.size
        if not own or name.lower() not in read:
            continue
        met = next((x for x in program.statements() if _mentions(x, name)), None)
        span = met.span if met is not None else variable.span
        if variable.type == "joints":
            yield rules.JOINTS_UNTOLD(name=name, span=span)
        elif variable.type in FIRST:
            yield rules.BEGINS(name=name, value=FIRST[variable.type], span=span)


def _mentions(statement: p.Statement, name: str) -> bool:
    names = (r.name.lower() for r in records(head(statement)) if isinstance(r, e.Name))
    return name.lower() in names


# --------------------------------------------------------------------------------- bits


def _signed_bits(program: Program) -> Iterator[Diagnostic]:
    """Bits of numbers that may be below 0: MELFA-BASIC takes those of their complement."""
    numbers: Numbers | None = None
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            for part in records(head(statement)):
                if isinstance(part, e.Apply) and part.function in BITS:
                    numbers = numbers or Numbers(program)
                    if not all(numbers.of(x, procedure).positive for x in part.arguments):
                        yield rules.SIGNED_BITS(word=BITS[part.function], span=statement.span)


# -------------------------------------------------------------------------------- loops


def _loops(program: Program) -> Iterator[Diagnostic]:
    """Loops whose end or step changes inside: not every language works them out again."""
    written = {q.name.lower(): set(_written(q.body)) for q in program.procedures}
    called = {q.name.lower(): set(_called(q.body)) for q in program.procedures}
    for statement in program.statements():
        if not isinstance(statement, p.For):
            continue
        changed = set(_written(statement.body))
        for name in _reached(set(_called(statement.body)), called):
            changed |= written.get(name, set())
        limits = {
            r.name.lower()
            for r in records((statement.last, statement.step))
            if isinstance(r, e.Name)
        }
        found = sorted(limits & changed)
        if found and statement.variable.lower() not in changed:  # else it is no plain count
            names = ", ".join(f"`{name.upper()}`" for name in found)
            yield rules.LOOP_CHANGED(names=names, span=statement.span)


def _written(body: tuple[p.Statement, ...]) -> Iterator[str]:
    """Names in lower case of variables that statements write."""
    for statement in walk(body):
        if isinstance(statement, p.For):
            yield statement.variable.lower()
        if isinstance(statement, p.Assign):
            yield next(r.name.lower() for r in records(statement.target) if isinstance(r, e.Name))


def _called(body: tuple[p.Statement, ...]) -> Iterator[str]:
    for statement in walk(body):
        if isinstance(statement, p.Call):
            yield statement.procedure.lower()


def _reached(names: set[str], called: Mapping[str, set[str]]) -> set[str]:
    """Procedures that are called, with those that these call."""
    found: set[str] = set()
    while names - found:
        name = (names - found).pop()
        found.add(name)
        names = names | called.get(name, set())
    return found
