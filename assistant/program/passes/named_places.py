"""Parts of the present position, for a language that has parts of data alone.

`here(grip in base).x` becomes a variable that is given the position, and a part of it.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import everywhere
from assistant.program.passes.hoisting import Taken, hoisted
from assistant.program.passes.legalising import Legalising
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import map_head

STEM = "here"


def with_named_places(job: Legalising) -> Program:
    """The program that gives the present position to a variable where a part of it is asked for."""
    program = job.program
    if not any(map(_is_part, everywhere(program, e.Member))):
        return program
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in (q.name, *q.variables)}
    taken |= {one.name.lower() for q in program.procedures for one in q.parameters}
    made = tuple(_named(procedure, taken) for procedure in program.procedures)
    return replace(program, procedures=made)


def _is_part(record: object) -> bool:
    return isinstance(record, e.Member) and isinstance(record.value, e.Here)


def _named(procedure: Procedure, taken: set[str]) -> Procedure:
    known: dict[int, e.Name] = {}

    def place(number: int) -> e.Name:
        """The same variables serve every statement."""
        if number not in known:
            names = (f"{STEM}_{k}" for k in itertools.count(1))
            name = next(n for n in names if n not in taken)
            taken.add(name)
            known[number] = e.Name(name)
        return known[number]

    def take(node: p.Statement) -> Taken:
        made, places = Taken(node), dict[e.Expression, e.Name]()

        def part(value: e.Expression) -> e.Expression:
            if not (isinstance(value, e.Member) and isinstance(value.value, e.Here)):
                return value
            if value.value not in places:
                places[value.value] = place(len(places))
                made.before.append(p.Assign(places[value.value], value.value))
            return replace(value, value=places[value.value])

        made.statement = map_head(node, part)
        return made

    body = hoisted(procedure.body, take)
    new = {name.name: Variable("position") for name in known.values()}
    return replace(procedure, body=body, variables={**procedure.variables, **new})
