"""Reads, changes and calls of procedures, and dependence on the order within a statement.

The pseudo-program evaluates from left to right. A call that is moved before its statement runs
before the reads to the left of it. Recursion is found by strongly connected components.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Rule
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Declaration, Procedure, Program, Variable
from assistant.program.rewriting import records
from assistant.program.statement_index import once_per_program, records_in_body
from assistant.program.vendor_statements import effect_of

POSITION: Final = "<position>"
"""Stands among names for where the robot is."""
TIME: Final = "<time>"
"""Stands among names for what timers count."""
_MOVING = p.Moving | p.Travel
_LASTING = _MOVING | p.Wait | p.WaitSignal | p.WaitUntil | p.Gripper | p.Stop | p.StartTimer
_CALLED: Final = {POSITION: "the position of the robot", TIME: "a timer"}


def called_by(name: str) -> str:
    """Return the name of an item of `read_before` for a finding."""
    return _CALLED.get(name, f"`{name}`")


def base_variable(place: Any) -> str:
    """The variable that a place belongs to, in lower case; empty for other expressions."""
    while isinstance(place, e.Index | e.Member):
        place = place.value
    return place.name.lower() if isinstance(place, e.Name) else ""


def altered(program: Program) -> dict[str, frozenset[str]]:
    """Variables and signals that each procedure, or one that it calls, changes by their names.

    All names in lower case, with POSITION and TIME for one that moves, or that takes its time.
    Inputs may change in that time. What a call lets a procedure change is not among them.
    """
    procedures = {q.name.lower(): q for q in program.procedures}
    own = _of_program(program, {key: _changed(q, procedures) for key, q in procedures.items()})
    inputs = frozenset(n.lower() for n, s in program.signals.items() if s.direction == "input")
    acts = {key: _acts(q, inputs) for key, q in procedures.items()}
    return along_calls(program, {key: names | acts[key] for key, names in own.items()})


def changed_by_others(program: Program) -> frozenset[str]:
    """Names in lower case of what changes without an assignment: inputs, data that tasks share.

    With interrupts every variable that a procedure does not have for itself.
    """
    interrupted = any(isinstance(node, p.Interrupt) for node in program.statements())
    shared = (
        name
        for name, variable in program.variables.items()
        if variable.storage != "constant"
        and (interrupted or (variable.storage == "persistent" and not variable.local))
    )
    return frozenset(name.lower() for name in (*program.signals, *shared))


@once_per_program
def changed_variables(program: Program) -> frozenset[str]:
    """Names in lower case of the program's variables that anything in it may change.

    A call of a routine that the program lacks may change every variable that it is given.
    """
    procedures = {q.name.lower(): q for q in program.procedures}
    own = {key: _may_change(q, procedures) for key, q in procedures.items()}
    found = frozenset().union(*_of_program(program, own).values())
    for declaration in program.declarations:
        found |= effect_of(declaration).writes
    return found


def changed_locals(program: Program, procedure: Procedure) -> frozenset[str]:
    """Names in lower case of a procedure's own variables that its body may change."""
    procedures = {q.name.lower(): q for q in program.procedures}
    return _may_change(procedure, procedures) & locals_of(procedure)


def names_in(node: Any) -> Iterator[str]:
    """Every name in an expression or statement; of text that is kept in lower case, once each."""
    for part in records(node):
        if isinstance(part, e.Name):
            yield part.name
        elif isinstance(part, e.Verbatim | p.Opaque):
            yield from sorted(effect_of(part).names)


def declared(program: Program) -> Iterator[str]:
    """Names of all that a program and its procedures declare, in lower case."""
    tables = (program.variables, program.targets, program.joint_targets, program.signals)
    for table in (*tables, program.tools, program.frames):
        yield from (name.lower() for name in table)
    for procedure in program.procedures:
        yield procedure.name.lower()
        yield from locals_of(procedure)


def texts_in(value: Any) -> set[str]:
    """Every name that statements refer to, in lower case, and every other text in them."""
    found: set[str] = set()
    for record in records(value):
        # Paths hold names in tables that `records` does not enter.
        if isinstance(record, p.Follow):
            found.update(n.lower() for n in (*record.path.tools, *record.path.frames))
        for part in type(record).__dataclass_fields__:
            if isinstance(text := getattr(record, part), str):
                found.add(text.lower())
    return found


def names_in_vendor_texts(program: Program) -> frozenset[str]:
    """Names in lower case in all that only a vendor's language says, declared or in statements."""
    found: set[str] = set()
    for part in (*program.declarations, *records(tuple(program.statements()))):
        if isinstance(part, Declaration | p.Opaque | e.Verbatim):
            found |= effect_of(part).names
    return frozenset(found)


def without_unused_equipment(program: Program) -> Program:
    """A program without the tools, frames and signals that its procedures do not name.

    A process file has those of a cell, and the heading of a program lists what it needs.
    """
    used = texts_in(program.procedures)
    tables: dict[str, Any] = {
        table: {name: one for name, one in getattr(program, table).items() if name.lower() in used}
        for table in ("tools", "frames", "signals")
    }
    return replace(program, **tables)


def shared_between_units(program: Program) -> Iterator[str]:
    """Variables of the program that units with procedures use, which are loaded when called."""
    texts = [texts_in(q.body) for q in program.procedures if q.unit is not None]
    yield from (n for n in program.variables if any(n.lower() in found for found in texts))


def mentioned_variables(program: Program) -> dict[str, frozenset[str]]:
    """Variables of the program that each procedure, or one that it calls, names: lower case."""
    own = {q.name.lower(): names_in_procedure(q) for q in program.procedures}
    return along_calls(program, _of_program(program, own))


def along_calls(program: Program, own: Mapping[str, frozenset[str]]) -> dict[str, frozenset[str]]:
    """Return the names of each procedure, by lower-case name, with those of its callees."""
    found = dict(own)
    calls = {q.name.lower(): found.keys() & set(called(q)) for q in program.procedures}
    callers: dict[str, list[str]] = {key: [] for key in found}
    for key, callees in calls.items():
        for callee in callees:
            callers[callee].append(key)
    # Callees first, so that most procedures are final at the first look; cycles come again.
    pending = dict.fromkeys(callees_first(calls))
    while pending:
        key = next(iter(pending))
        del pending[key]
        more = found[key].union(*(found[c] for c in calls[key]))
        if more != found[key]:
            found[key] = more
            pending.update(dict.fromkeys(callers[key]))
    return found


def callees_first(calls: Mapping[str, Iterable[str]]) -> list[str]:
    """Return the procedures in an order in which each follows its callees, except in cycles."""
    found: dict[str, None] = {}
    begun: set[str] = set()
    for root in calls:
        pending = [] if root in begun else [(root, iter(calls[root]))]
        begun.add(root)
        while pending:
            name, callees = pending[-1]
            inner = next((one for one in callees if one in calls and one not in begun), None)
            if inner is None:
                found[name] = None
                pending.pop()
            else:
                begun.add(inner)
                pending.append((inner, iter(calls[inner])))
    return list(found)


def _of_program(program: Program, names: Mapping[str, frozenset[str]]) -> dict[str, frozenset[str]]:
    shared = {name.lower() for name in program.variables}
    own = {q.name.lower(): locals_of(q) for q in program.procedures}
    return {key: (found - own[key]) & shared for key, found in names.items()}


def called(procedure: Procedure) -> Iterator[str]:
    """Procedures and functions that a body calls, in lower case."""
    for record in records_in_body(procedure, p.Call, e.Apply):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()


def locals_of(procedure: Procedure) -> frozenset[str]:
    """Parameters and variables of a procedure, in lower case."""
    names = (*procedure.variables, *(q.name for q in procedure.parameters))
    return frozenset(name.lower() for name in names)


def handed_over(procedure: Procedure, arguments: tuple[Any, ...]) -> Iterator[e.Expression]:
    """The places that a call lets a procedure change."""
    for parameter, value in zip(procedure.parameters, arguments, strict=False):
        if parameter.mode == "inout" and base_variable(value):
            yield value


def read_before(
    statement: Any, functions: Mapping[str, Procedure], alters: Mapping[str, frozenset[str]]
) -> Iterator[tuple[str, str]]:
    """Yield each name that a statement reads before a function changes it, with the function.

    The names are those of `altered`. statement: without the bodies that it holds, or expressions in
    the order of evaluation. functions: to be moved out of it, by lower-case name. alters: names
    that each changes outside of itself, as `altered` returns them.
    """
    pending: list[str] = []

    def walk(value: Any, read: bool = True) -> Iterator[tuple[str, str]]:
        match value:
            case e.Name(name):
                if read:
                    pending.append(name)
            case e.Here():
                pending.append(POSITION)
            case e.Elapsed():
                pending.append(TIME)
            case p.Call(name, arguments) if name.lower() in functions:
                yield from given(functions[name.lower()], arguments)
            case e.Apply(function, arguments) if function.lower() in functions:
                callee = functions[function.lower()]
                mark = len(pending)
                yield from given(callee, arguments)
                # Arguments move out with the call, and are read before it either way.
                del pending[mark:]
                names = alters[function.lower()] | set(
                    map(base_variable, handed_over(callee, arguments))
                )
                yield from ((x, function) for x in pending if x.lower() in names)
            case e.Index(inner, indices):
                # Indices are read before the element.
                yield from walk(indices)
                yield from walk(inner, read)
            case e.Member(inner):
                yield from walk(inner, read)
            case p.Assign(target, assigned):
                # The target is written, not read; its indices are read.
                yield from walk(target, read=False)
                yield from walk(assigned)
            case tuple():
                for item in value:
                    yield from walk(item)
            case _ if is_dataclass(value):
                for part in fields(value):
                    yield from walk(getattr(value, part.name))

    def given(callee: Procedure, arguments: tuple[Any, ...]) -> Iterator[tuple[str, str]]:
        places = {id(place) for place in handed_over(callee, arguments)}
        for value in arguments:
            yield from walk(value, read=id(value) not in places)

    yield from walk(statement)


def unordered(program: Program, cannot_say: Rule) -> Iterator[Diagnostic]:
    """An error at each assignment that depends on whether its indices or its value come first.

    The indices of a target come first; not every manual tells.
    """
    functions = {q.name.lower(): q for q in program.procedures if q.result is not None}
    if not functions:
        return
    alters, mentions = altered(program), mentioned_variables(program)

    def touched(side: Any) -> tuple[set[str], set[str]]:
        """Return the names that evaluation of one side reads, and those that it changes."""
        read: set[str] = set()
        changed: set[str] = set()
        for record in records(side):
            match record:
                case e.Name(name):
                    read.add(name.lower())
                case e.Here():
                    read.add(POSITION)
                case e.Elapsed():
                    read.add(TIME)
                case e.Apply(function, arguments) if function.lower() in functions:
                    key = function.lower()
                    read |= mentions[key]
                    changed |= alters[key] | set(
                        map(base_variable, handed_over(functions[key], arguments))
                    )
        return read, changed

    for node in program.statements():
        if not isinstance(node, p.Assign):
            continue
        (read, changed), (other, also) = touched(indices_of(node.target)), touched(node.value)
        # Either order gives the same result unless one side changes what the other uses.
        if (changed and also) or changed & other or also & read:
            yield cannot_say(
                what="whether the indices or the value of an assignment are worked out first",
                cure="call the functions in assignments of their own before it",
                span=node.span,
            )


def indices_of(place: e.Expression) -> tuple[e.Expression, ...]:
    """The indices of a place in a variable, the first ones first."""
    match place:
        case e.Member(value):
            return indices_of(value)
        case e.Index(value, indices):
            return (*indices_of(value), *indices)
    return ()


def _assigned(procedure: Procedure, procedures: Mapping[str, Procedure]) -> set[str]:
    """Names that a body assigns, counts with, or hands over to procedures that may change them."""
    names = set()
    for record in records_in_body(procedure, p.Assign, p.For, p.Call, e.Apply):
        match record:
            case p.Assign(target):
                names.add(base_variable(target))
            case p.For(variable):
                names.add(variable.lower())
            case p.Call(name, arguments) | e.Apply(name, arguments) if name.lower() in procedures:
                callee = procedures[name.lower()]
                names |= {base_variable(place) for place in handed_over(callee, arguments)}
    return names


def _changed(procedure: Procedure, procedures: Mapping[str, Procedure]) -> frozenset[str]:
    """Names that a body may change or that its vendor text has, locals included."""
    names = _assigned(procedure, procedures)
    for record in records_in_body(procedure, p.Opaque):
        names |= effect_of(record).names
    return frozenset(names)


def _may_change(procedure: Procedure, procedures: Mapping[str, Procedure]) -> frozenset[str]:
    """Names that a body, its vendor text, or a routine that the program lacks may change."""
    names = _assigned(procedure, procedures)
    for record in records_in_body(procedure, p.Call, e.Apply, p.Opaque, e.Verbatim):
        match record:
            case p.Call(name, arguments) if name.lower() not in procedures:
                names |= set(map(base_variable, arguments))
            case e.Apply(name, arguments) if name.lower() not in {*procedures, *e.FUNCTIONS}:
                names |= set(map(base_variable, arguments))
            case p.Opaque() | e.Verbatim():
                names |= effect_of(record).writes
    return frozenset(names)


def _acts(procedure: Procedure, inputs: frozenset[str]) -> frozenset[str]:
    """Signals that the statements of a procedure change, POSITION and TIME."""
    names: set[str] = set()
    for record in records(procedure.body):
        match record:
            case p.SetSignal(signal) | p.Trigger(signal):
                names.add(signal.lower())
            case p.Opaque():
                names |= {POSITION, TIME, *inputs, *effect_of(record).names}
        if isinstance(record, _MOVING):
            names.add(POSITION)
        if isinstance(record, _LASTING):
            names |= {TIME, *inputs}
    return frozenset(names)


def names_in_procedure(procedure: Procedure) -> frozenset[str]:
    """Return lower-case names that a procedure reads or changes, and all words of vendor text."""
    names: set[str] = set()
    for record in records_in_body(procedure, e.Name, p.For, p.Opaque, e.Verbatim):
        match record:
            case e.Name(name):
                names.add(name.lower())
            case p.For(variable):
                names.add(variable.lower())
            case p.Opaque() | e.Verbatim():
                names.update(effect_of(record).names)
    return frozenset(names)


def recursive_names(calls: Mapping[str, Collection[str]]) -> frozenset[str]:
    """Names that lead back to themselves, found in a time that grows with the calls alone.

    calls: what each name calls; what is no key calls nothing. By the strongly connected components
    of the graph (R. Tarjan: Depth-first search and linear graph algorithms, 1972).
    """
    found: set[str] = set()
    order: dict[str, int] = {}
    first: dict[str, int] = {}
    """By name the least place in `order` that it is known to lead back to."""
    open_names: dict[str, None] = {}
    for root in calls:
        pending: list[tuple[str, Iterator[str]]] = []
        new: str | None = None if root in order else root
        # A stack instead of recursion: programs may call deeply.
        while new is not None or pending:
            if new is not None:
                order[new] = first[new] = len(order)
                open_names[new] = None
                pending.append((new, iter(calls[new])))
            name, callees = pending[-1]
            new = None
            for callee in callees:
                if callee in calls and callee not in order:
                    new = callee
                    break
                if callee in open_names:
                    first[name] = min(first[name], order[callee])
            if new is not None:
                continue
            pending.pop()
            if pending:
                above = pending[-1][0]
                first[above] = min(first[above], first[name])
            # The component is complete: all names above this one on the stack belong to it.
            if first[name] == order[name]:
                whole = [open_names.popitem()[0]]
                while whole[-1] != name:
                    whole.append(open_names.popitem()[0])
                # A single name is recursive only if it calls itself.
                if len(whole) > 1 or name in calls[name]:
                    found.update(whole)
    return frozenset(found)


def constant_numbers(program: Program, procedure: Procedure) -> Mapping[str, e.Number]:
    """Numbers of the constants that a procedure sees, by lower-case name."""
    shared = _shared_constants(program)
    own = {parameter.name.lower() for parameter in procedure.parameters}
    own |= {name.lower() for name in procedure.variables}
    if not own:
        return shared
    found = {name: value for name, value in shared.items() if name not in own}
    hidden = {parameter.name.lower() for parameter in procedure.parameters}
    found |= {k: v for k, v in _constant_numbers(procedure.variables).items() if k not in hidden}
    return found


@once_per_program
def _shared_constants(program: Program) -> dict[str, e.Number]:
    return _constant_numbers(program.variables)


def _constant_numbers(variables: Mapping[str, Variable]) -> dict[str, e.Number]:
    """Return the constant numbers among some variables, by lower-case name."""
    return {
        name.lower(): one.initial
        for name, one in variables.items()
        if one.storage == "constant" and isinstance(one.initial, e.Number)
    }


def constant_value(value: e.Expression, numbers: Mapping[str, e.Number]) -> e.Expression:
    """Return the number of a constant, any other value as it is. numbers: of `constant_numbers`."""
    return numbers.get(value.name.lower(), value) if isinstance(value, e.Name) else value
