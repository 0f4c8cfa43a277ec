r"""Where `CRobT` reads the robot's position, as far as it does not say so itself.

Without `\Tool` it reads in the active tool, without `\WObj` in the active work object: those of
the move that the robot made last (RAPID reference manual, CRobT). Which move that is depends on
the way that leads to the place, also through calls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.lift.ways import steps
from assistant.languages.rapid.tables.functions import HERE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.ways import Ways
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import Body, map_bodies, map_head, records

DIFFERS: Final = e.Reason(
    "it reads in the tool and work object of the move before, which the program does not tell",
    r"write both, as `CRobT(\Tool:=tool0\WObj:=wobj0)`",
)


def with_places(program: Program, original: Callable[[str], str] = str) -> Program:
    """The program with the tool and frame of each `CRobT` that leaves them to the move before.

    One that differs with the way stays as its text. original: gives a shortened name back.
    """
    if not any(map(_reads, records(program.procedures))):
        return program
    flow = Ways(program, _reads, steps)
    made = tuple(_said(flow, q, q.body, original) for q in program.procedures)
    changed = (replace(q, body=b) for q, b in zip(program.procedures, made, strict=True))
    return replace(program, procedures=tuple(changed))


def _said(flow: Ways, owner: Procedure, body: Body, original: Callable[[str], str]) -> Body:
    made: list[p.Statement] = []
    for node in body:
        if id(node) in flow.before:
            tool, frame = flow.active(owner, node)

            def change(
                x: e.Expression, tool: str | None = tool, frame: str | None = frame
            ) -> e.Expression:
                if not (isinstance(x, e.Verbatim) and _reads(x)):
                    return x
                return _here(x, original, tool, frame) or replace(x, reason=DIFFERS)

            node = map_head(node, change)
        made.append(map_bodies(node, lambda inner: _said(flow, owner, inner, original)))
    return tuple(made)


def _here(
    x: e.Verbatim, original: Callable[[str], str], tool: str | None, frame: str | None
) -> e.Here | None:
    """What `CRobT` reads, None if that is not known. tool, frame: of the move before."""
    call = called(verbatim.expression(x.text))
    said = None if call is None else Expressions(original).reading.fields(HERE, call)
    if said is None:
        return None
    tool, frame = said.get("tool", tool), said.get("frame", frame)
    return None if tool is None or frame is None else e.Here(tool_name(tool), frame_name(frame))


def _reads(record: Any) -> bool:
    match record:
        case e.Verbatim(verbatim.LANGUAGE, text):
            return text.lower().startswith("crobt(")
    return False
