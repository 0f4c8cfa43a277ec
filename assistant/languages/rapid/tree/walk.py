"""Walks over a tree: its nodes, its lists of statements, calls and their arguments, names.

`nodes` gives every node in the order of the text, `lists` every list of statements of a routine.
`called` gives a call as the rows of the tables have it. `trigger_set_up` and `triggers_taken` tell
which triggdata an instruction sets up or a move takes. `renamed` gives data of a module other
names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.languages.language_types import Part
from assistant.languages.nodes import Walk
from assistant.languages.patterns import Called
from assistant.languages.rapid.tables.signals import FURTHER_TRIGGERS, TRIGGER_MOVES, TRIGGER_SETUPS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.syntax import MotionNames
from assistant.languages.runs.columns import Names
from assistant.program.rewriting import rewrite

TASK_NAME: Final = "taskname"
"""The option that names the task whose arm a function reads of."""


def called(node: s.Node) -> Called[s.Expression] | None:
    """The call that a node is, without a word where that is worked out.

    None for another node, or with an argument that a routine hands on.
    """
    if not isinstance(node, s.FunctionCall | s.ProcedureCall):
        return None
    given: list[s.Expression] = []
    options: dict[str, s.Expression | None] = {}
    for argument in node.arguments:
        match argument:
            case s.Positional(value, None):
                given.append(value)
            case s.Option(name, value):
                # The first of two options with one name counts.
                options.setdefault(name.lower(), value)
            case _:
                return None
    word = node.name if isinstance(node.name, str) else ""
    return Called(word, given, options)


def positional(call: s.FunctionCall | s.ProcedureCall) -> list[s.Expression]:
    """The values that are given by their places."""
    return [one.value for one in call.arguments if isinstance(one, s.Positional)]


def option(call: s.FunctionCall | s.ProcedureCall, *names: str) -> s.Option | None:
    """The first option of one of some names, which are in lower case."""
    given = (one for one in call.arguments if isinstance(one, s.Option))
    return next((one for one in given if one.name.lower() in names), None)


def name_of(value: s.Expression | None) -> str:
    """The name that an expression is, empty for any other one."""
    return value.name if isinstance(value, s.NameRef) else ""


def function_call(call: Called[s.Expression]) -> s.FunctionCall:
    return s.FunctionCall(call.word, arguments(call))


def arguments(call: Called[s.Expression]) -> tuple[s.Argument, ...]:
    given = [s.Positional(node) for node in call.given if node is not None]
    options = [s.Option(name, node) for name, node in call.options.items()]
    parts: tuple[Sequence[s.Argument], ...] = (given, options)
    # Options that stand before the other arguments are printed there.
    first, second = reversed(parts) if call.leading else parts
    return (*first, *second)


def worked_out_task(call: s.FunctionCall) -> s.Expression | None:
    """The name of the task whose arm is read, None where it is written out or left out."""
    for argument in call.arguments:
        match argument:
            case s.Option(option, s.Node() as name) if option.lower() == TASK_NAME:
                return None if isinstance(name, s.StringLiteral) else name
    return None


def trigger_set_up(node: s.Node) -> str:
    """The lower-case name of the variable that an instruction sets up; empty for others."""
    match node:
        case s.ProcedureCall(str(word), (s.Positional(s.NameRef(name), None), *_)) if (
            word.lower() in TRIGGER_SETUPS
        ):
            return name.lower()
    return ""


def triggers_taken(node: s.Node) -> tuple[s.NameRef, ...]:
    """The plain variables that a move takes; none for what is no such move."""
    move = TRIGGER_MOVES.get(str(node.name).lower()) if isinstance(node, s.ProcedureCall) else None
    if move is None or not isinstance(node, s.ProcedureCall):
        return ()
    given = positional(node)
    more = [
        x.value
        for x in node.arguments
        if isinstance(x, s.Option) and x.name.lower() in FURTHER_TRIGGERS
    ]
    named = (*given[move.place : move.place + 1], *more)
    return tuple(one for one in named if isinstance(one, s.NameRef))


ERRNO: Final = "errno"
"""The variable in lower case that holds the number of the error."""

# Routines remember their nodes: most passes walk the same ones again.
_WALK: Final = Walk(lambda kind: issubclass(kind, s.Node), held=s.Routine)
nodes: Final = _WALK.nodes
inside: Final = _WALK.inside


def source_parts(file: s.File) -> Iterator[Part]:
    """The data of modules and routines that have a place in the text, and what sets some up."""
    for module in file.modules:
        for item in module.items:
            owner = item.name if isinstance(item, s.Routine) else ""
            for node in item.body if isinstance(item, s.Routine) else (item,):
                match node:
                    case s.Data(span=Span() as span):
                        yield Part(span, node.name, owner=owner)
                    case s.TargetRunNode(span=Span() as span):
                        yield Part(span, count=len(node.run), lines=node.lines)
            for body in lists(item) if isinstance(item, s.Routine) else ():
                # Setting up a trigger has no statement of its own in the pseudo-program.
                yield from (Part(x.span) for x in body if x.span is not None and trigger_set_up(x))
            if isinstance(item, s.Routine):
                for handler in item.handlers:
                    yield from _statement_parts(handler.body, handler.span)
                yield from _statement_parts(item.body, item.span)


def mentions(files: Iterable[s.File], words: Sequence[str]) -> bool:
    """True if the text of a file has one of some lower-case words, or a longer one that holds it.

    A regular expression that ignores case takes longer here than all the rest of a proof.
    """
    texts = (file.source.text.lower() for file in files if file.source is not None)
    return any(word in text for text in texts for word in words)


def _statement_parts(body: tuple[s.StatementNode, ...], within: Span | None) -> Iterator[Part]:
    """Those of a routine, which may be kept as one text, and of a handler, which is one there."""
    pending = [body]
    while pending:
        for node in pending.pop():
            pending.extend(blocks(node))
            if node.span is None or isinstance(node, s.CommentLine | s.LabelMark | s.Placeholder):
                continue
            if isinstance(node, s.MoveRunNode | s.TargetRunNode):
                yield Part(node.span, count=len(node.run), within=within, lines=node.lines)
            else:
                yield Part(node.span, within=within)


_ROUTINE_KINDS: Final = {"PROC": "procedure", "FUNC": "function", "TRAP": "trap routine"}


_MEETING_TYPE: Final = "syncident"
"""The type of what `WaitSyncTask` names."""


def shared_names(file: s.File) -> Iterator[tuple[str, str]]:
    """Yield the names that the modules of a file declare for their task, each with its kind.

    Data of a module that has only persistent data and task meeting points is shared data: every
    task may declare it.
    """
    for module in file.modules:
        kind = "shared data" if _is_shared(module) else "data"
        for item in module.items:
            match item:
                case s.Routine(kind=word, local=False, name=name):
                    yield name, _ROUTINE_KINDS[word]
                case s.Record(local=False, name=name) | s.Alias(local=False, name=name):
                    yield name, "type"
                case s.Data(scope=scope, name=name) if scope != "LOCAL":
                    yield name, kind
                case s.TargetRunNode(scope=scope, run=run) if scope != "LOCAL":
                    yield from ((run.names.name(row), "data") for row in range(len(run)))


def _is_shared(module: s.Module) -> bool:
    """True if a module has only data and types that all tasks of a controller share.

    That is persistent data, and what tasks meet at, which each of them declares.
    """
    data = [item for item in module.items if not isinstance(item, s.CommentLine)]
    return bool(data) and all(
        isinstance(item, s.Data)
        and not item.scope
        and (item.storage == "PERS" or item.type.lower() == _MEETING_TYPE)
        for item in data
    )


def own_names(file: s.File) -> Iterator[str]:
    """Names that the modules of a file and their routines declare, in lower case."""
    for module in file.modules:
        for item in module.items:
            match item:
                case s.Routine(name=name):
                    yield name.lower()
                    yield from (inner.lower() for inner in inner_names([item]))
                case s.Record(name=name) | s.Alias(name=name) | s.Data(name=name):
                    yield name.lower()
                case s.TargetRunNode(run=run):
                    yield from (run.names.name(row).lower() for row in range(len(run)))


def blocks(statement: Any) -> tuple[tuple[s.StatementNode, ...], ...]:
    """The lists of statements directly inside one."""
    match statement:
        case s.IfThen(branches, otherwise):
            return (*(b.body for b in branches), *(() if otherwise is None else (otherwise,)))
        case s.TestOf(_, cases, otherwise):
            return (*(c.body for c in cases), *(() if otherwise is None else (otherwise,)))
        case s.ForLoop(body=body) | s.WhileLoop(body=body):
            return (body,)
        case s.CompactIf(statement=inner):
            return ((inner,),)
    return ()


def map_lists(
    node: Any, change: Callable[[tuple[s.StatementNode, ...]], tuple[s.StatementNode, ...]]
) -> Any:
    """A routine or statement with each list of statements in it changed, inner ones first; itself
    if nothing changes.
    """

    def each(body: tuple[s.StatementNode, ...]) -> tuple[s.StatementNode, ...]:
        made = tuple(map_lists(one, change) for one in body)
        same = all(one is other for one, other in zip(made, body, strict=True))
        return change(body if same else made)

    def part(value: Any) -> Any:
        if isinstance(value, tuple) and value and isinstance(value[0], _HOLDERS):
            made = tuple(map_lists(one, change) for one in value)
            return value if all(a is b for a, b in zip(made, value, strict=True)) else made
        return each(value)

    names: tuple[str, ...] = _LISTS.get(type(node), ())
    changes = {}
    for name in names:
        value = getattr(node, name)
        made = value if value is None else part(value)
        if made is not value:
            changes[name] = made
    return replace(node, **changes) if changes else node


_LISTS: Final[dict[type, tuple[str, ...]]] = {
    s.Routine: ("body", "handlers"),
    **dict.fromkeys((s.Handler, s.IfBranch, s.TestCase, s.ForLoop, s.WhileLoop), ("body",)),
    s.IfThen: ("branches", "otherwise"),
    s.TestOf: ("cases", "otherwise"),
}
"""Fields that are lists of statements, or of what has such lists."""
_HOLDERS: Final = (s.Handler, s.IfBranch, s.TestCase)


def root(value: Any) -> s.NameRef | None:
    """The data that a variable is, or is a part of; None for any other expression."""
    while isinstance(value, s.Component | s.Element):
        value = value.value
    return value if isinstance(value, s.NameRef) else None


def inner_names(routines: Iterable[s.Routine]) -> Iterator[str]:
    """Names that routines declare or count with, so that they hide what modules declare."""
    for node in nodes(tuple(routines)):
        match node:
            case s.Data(name=str(name)) | s.ParameterNode(name=name):
                yield name
            case s.ForLoop(variable=str(name)):
                yield name


def lists(routine: s.Routine) -> Iterator[tuple[s.StatementNode, ...]]:
    """Every list of statements of a routine: its body, its handlers, and the blocks in them."""
    pending = [routine.body, *(h.body for h in routine.handlers)]
    while pending:
        body = pending.pop()
        yield body
        for statement in body:
            pending.extend(blocks(statement))


def routines_of_handlers(modules: Sequence[s.Module]) -> frozenset[str]:
    """Names in lower case of the routines that handlers call, and that these call."""
    routines = [one for module in modules for one in module.items if isinstance(one, s.Routine)]
    calls: dict[str, set[str]] = {}
    pending: list[str] = []
    for one in routines:
        calls.setdefault(one.name.lower(), set()).update(called_in(one.body))
        pending += called_in(one.handlers)
    found: set[str] = set()
    while pending:
        name = pending.pop()
        if name in calls and name not in found:
            found.add(name)
            pending += calls[name]
    return frozenset(found)


def called_in(value: Any) -> Iterator[str]:
    """Names in lower case of the routines that nodes call."""
    for node in nodes(value):
        if isinstance(node, s.FunctionCall | s.ProcedureCall) and isinstance(node.name, str):
            yield node.name.lower()


def renamed(item: s.Item, names: Mapping[str, str]) -> s.Item:
    """An item with other names, by lower-case name, but for what a routine declares itself."""
    inner = {
        node.name.lower()
        for node in (nodes(item) if isinstance(item, s.Routine) else ())
        if isinstance(node, s.Data | s.ParameterNode)
    }

    def of(name: str) -> str:
        return name if name.lower() in inner else names.get(name.lower(), name)

    def said(part: Any) -> Any:
        match part:
            case s.NameRef(name) | s.Data(name=name):
                return replace(part, name=of(name))
            case s.ForLoop(variable=str(name)):
                return replace(part, variable=of(name))
            case MotionNames(speed, zone, tool, frame):
                return MotionNames(of(speed), of(zone), of(tool), of(frame))
            case Names():
                return Names.of([of(part.name(row)) for row in range(len(part))])
        return part

    return rewrite(item, said, ())


def shell(file: s.File, *, data: bool) -> s.File:
    """Return a file whose procedures do nothing.

    data: with its other declarations and its text; without them it has comments and routines alone.
    """

    def items(module: s.Module) -> Iterator[s.Item]:
        for item in module.items:
            if isinstance(item, s.Routine) and item.kind == "PROC":
                yield replace(item, body=(), handlers=())
            elif data or isinstance(item, s.Routine | s.CommentLine):
                yield item

    parts = tuple(
        replace(part, items=tuple(items(part))) if isinstance(part, s.Module) else part
        for part in file.parts
    )
    source = file.source
    if source is None:
        return s.File(parts, file.header)
    # Without the text a shell takes no memory, so that there may be one for each of many units.
    return s.File(parts, file.header, s.Origin(source if data else replace(source, text=""), parts))
