"""Where the present position is read, as far as the text that reads it does not say so itself.

It is read in the active tool and frame: those of the move that the robot made last. Which move that
is depends on the way that leads to the place, also through calls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.ways import MotionStates, StepsOfText
from assistant.program.contents import records_in_procedures
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import Body, map_bodies, map_head

Said = Callable[[e.Expression, str | None, str | None], e.Expression]
"""What a text says that reads the position, with the active tool and frame as far as known."""


def with_present_places(
    program: Program, reads: Callable[[Any], bool], said: Said, kept: StepsOfText
) -> Program:
    """The program with `said` made of the texts that read the position.

    reads: which records are such texts. kept: what kept texts do.
    """
    if not any(map(reads, records_in_procedures(program, p.Opaque, e.Verbatim))):
        return program
    ways = MotionStates(program, reads, kept)

    def body(owner: Procedure, statements: Body) -> Body:
        return tuple(statement(owner, node) for node in statements)

    def statement(owner: Procedure, node: Any) -> p.Statement:
        if id(node) in ways.before:
            tool, frame = ways.active(owner, node)
            node = map_head(node, lambda x: said(x, tool, frame) if reads(x) else x)
        inner: p.Statement = map_bodies(node, lambda held: body(owner, held))
        return inner

    made = (replace(q, body=body(q, q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(made))
