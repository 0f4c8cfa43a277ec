"""Parts of positions that are worked out, for a language that has parts of data alone.

`here(grip in base).x` becomes a variable that is given the position, and a part of it; so do the
positions whose distance is asked for.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import records_in_procedures
from assistant.program.passes.hoisting import Taken, hoisted
from assistant.program.passes.legalising import Legalisation
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import map_head

POSITION_STEM = "here"


def with_named_places(job: Legalisation) -> Program:
    """The program that gives a position to a variable where a part of it is asked for."""
    program = job.program
    if not any(map(_unnamed, records_in_procedures(program, e.Member, e.Apply))):
        return program
    taken = taken_names(program)
    made = tuple(with_named_positions(procedure, taken) for procedure in program.procedures)
    return replace(program, procedures=made)


def taken_names(program: Program) -> set[str]:
    """Names in lower case that no further variable of a procedure may have."""
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in (q.name, *q.variables)}
    return taken | {one.name.lower() for q in program.procedures for one in q.parameters}


def _unnamed(record: object) -> tuple[e.Expression, ...]:
    """The positions of an expression that have to be in variables."""
    match record:
        case e.Member(value=e.Here() as place):
            return (place,)
        case e.Apply("distance", given):
            return tuple(x for x in given if isinstance(x, e.Here | e.Apply | e.TargetValue))
    return ()


def with_named_positions(procedure: Procedure, taken: set[str]) -> Procedure:
    """A procedure with such positions in variables."""
    known: dict[int, e.Name] = {}

    def place(number: int) -> e.Name:
        """The same variables serve every statement."""
        if number not in known:
            names = (f"{POSITION_STEM}_{k}" for k in itertools.count(1))
            name = next(n for n in names if n not in taken)
            taken.add(name)
            known[number] = e.Name(name)
        return known[number]

    def take(node: p.Statement) -> Taken:
        made, places = Taken(node), dict[e.Expression, e.Name]()
        if isinstance(node, p.Interrupt):  # its condition is asked later, and elsewhere
            return made

        def part(value: e.Expression) -> e.Expression:
            for one in _unnamed(value):
                if one not in places:
                    places[one] = place(len(places))
                    made.before.append(p.Assign(places[one], one))
            match value:
                case e.Member(value=e.Here() as one):
                    return replace(value, value=places[one])
                case e.Apply("distance", given):
                    return replace(value, arguments=tuple(places.get(x, x) for x in given))
            return value

        made.statement = map_head(node, part)
        return made

    body = hoisted(procedure.body, take)
    new = {name.name: Variable("position") for name in known.values()}
    return replace(procedure, body=body, variables={**procedure.variables, **new})
