r"""Where `CRobT` reads the robot's position, as far as it does not say so itself.

Without `\Tool` it reads in the active tool, without `\WObj` in the active work object: those of
the move that the robot made last (RAPID reference manual, CRobT). Which move that is depends on
the way that leads to the place, also through calls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Span
from assistant.languages.rapid.lift.expressions import Expressions, frame_name, tool_name
from assistant.languages.rapid.lift.ways import vendor_steps
from assistant.languages.rapid.tables.functions import HERE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program.passes.implicit_motion_state import (
    Said,
    with_active_places,
    with_present_places,
)
from assistant.program.program import Program

DEPENDS_ON_PATH: Final = e.Reason(
    "it reads in the tool and work object of the move before, which the program does not tell",
    r"write both, as `CRobT(\Tool:=tool0\WObj:=wobj0)`",
)


def with_places(program: Program, original: Callable[[str], str] = str) -> Program:
    """The program with the tool and frame of each `CRobT` that leaves them to the move before.

    One that differs with the way stays as its text. original: gives a shortened name back.
    """
    return with_present_places(
        program, _reads_position, _with_explicit_frames(original), vendor_steps
    )


def with_active_tool_frame(program: Program) -> tuple[Program, list[Span | None]]:
    """The same for another language, which is told in variables what differs with the way.

    And the places of what may read before the first move, in the flange and the base then.
    """
    return with_active_places(program, _reads_position, _with_explicit_frames(str), vendor_steps)


def _with_explicit_frames(original: Callable[[str], str]) -> Said:
    expressions = Expressions(original)

    def said(x: e.Expression, tool: str | None, frame: str | None) -> e.Expression:
        assert isinstance(x, e.Verbatim)
        call = called(verbatim.expression(x.text))
        found = None if call is None else expressions.reading.fields(HERE, call)
        where = {"tool": tool, "frame": frame, **(found or {})}
        if found is None or None in where.values():
            return replace(x, reason=DEPENDS_ON_PATH)
        return e.Here(tool_name(where["tool"]), frame_name(where["frame"]))

    return said


def _reads_position(record: Any) -> bool:
    match record:
        case e.Verbatim(verbatim.LANGUAGE, text):
            return text.lower().startswith("crobt(")
    return False
