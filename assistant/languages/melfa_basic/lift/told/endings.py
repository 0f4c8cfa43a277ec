"""`End` inside a subroutine, which ends the cycle or the called program, as flags and returns.

Each call of a subroutine that may come to such an `End` is followed by a question: where the flag
is set, the caller goes back as well, up to the first procedure of the program.
"""

from __future__ import annotations

from dataclasses import replace

from assistant.languages.melfa_basic.lift.values.symbols import VENDOR_ONLY_END
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier, walk
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of


def with_endings(program: Program) -> Program:
    """The program with flags for each `End` in a subroutine."""
    ending = {q.name for q in program.procedures if any(map(_is_end, walk(q.body)))}
    if not ending:
        return program
    firsts = _first_procedures(program)
    unit_of = {q.name: q.unit for q in program.procedures}
    callers: dict[str, set[str]] = {}
    for procedure in program.procedures:
        for node in walk(procedure.body):
            if isinstance(node, p.Call):
                callers.setdefault(node.procedure, set()).add(procedure.name)
    loose = _called_otherwise(program)
    reached, pending = set[str](), sorted(ending)
    while pending:
        name = pending.pop()
        if name in reached or name in firsts:
            continue
        reached.add(name)
        pending += [c for c in callers.get(name, ()) if unit_of[c] == unit_of[name]]
    units = {unit_of[name] for name in reached}
    bad = {unit_of[q.name] for q in program.procedures if q.name in reached and q.result}
    bad |= {unit_of[name] for name in reached if name.lower() in loose}
    taken = TakenNames(declared(program))
    flags: dict[str | None, str] = {}
    for unit in sorted(units - bad, key=str):
        flags[unit] = identifier("cycle_ended" if unit is None else f"{unit}_ended", taken)
        taken.add(flags[unit])
    made = [
        _with_end_flag(q, flags[q.unit], reached, q.name in firsts) if q.unit in flags else q
        for q in program.procedures
    ]
    variables = {name: Variable("truth", e.Truth(False)) for name in flags.values()}
    return replace(program, procedures=tuple(made), variables={**program.variables, **variables})


def _first_procedures(program: Program) -> set[str]:
    """The procedures that programs of the controller begin with."""
    called = (x for q in program.procedures for x in walk(q.body) if isinstance(x, p.Call))
    found = {x.procedure for x in called if x.unit is not None}
    begun: set[str | None] = set()
    for procedure in program.procedures:
        if procedure.unit not in begun:
            begun.add(procedure.unit)
            found.add(procedure.name)
    return found


def _is_end(node: p.Statement) -> bool:
    return isinstance(node, p.Opaque) and any(
        isinstance(one, p.Call) and one.procedure == VENDOR_ONLY_END for one in node.told
    )


def _called_otherwise(program: Program) -> set[str]:
    """Names of procedures, in lower case, that more than plain calls name."""
    found: set[str] = set()
    for record in records(program.procedures):
        match record:
            case e.Apply(name):
                found.add(name.lower())
            case p.Interrupt():
                found |= {x.procedure.lower() for x in records(record) if isinstance(x, p.Call)}
    for text in records_in_procedures(program, p.Opaque):
        if not _is_end(text):
            found |= {name.lower() for name in effect_of(text).names}
    return found


def _with_end_flag(procedure: Procedure, flag: str, reached: set[str], first: bool) -> Procedure:
    """A procedure of a program that has the flag. first: the program begins with it."""
    asked = e.Name(flag)

    def body(statements: Body) -> Body:
        return tuple(made for one in statements for made in told(map_bodies(one, body)))

    def told(node: p.Statement) -> Body:
        if _is_end(node):
            ended = p.Assign(asked, e.Truth(True), span=node.span)
            return ended, p.Return(span=node.span)
        if isinstance(node, p.Call) and node.procedure in reached:
            back = p.If((p.Branch(asked, (p.Return(),)),), span=node.span)
            return node, back
        return (node,)

    made = body(procedure.body)
    begun: Body = (p.Assign(asked, e.Truth(False)),) if first else ()
    return replace(procedure, body=(*begun, *made))
