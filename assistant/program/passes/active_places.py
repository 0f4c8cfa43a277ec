"""The tool and frame of the move before, kept in two variables where the ways to a place differ.

What reads the position reads it in the active tool and frame. Where these are known they are named;
where several moves may have been the last one, each of them notes its own behind it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.analysis.ways import FRAME, START, TOOL, UNKNOWN, MotionStates, StepsOfText
from assistant.program.contents import records_in_procedures
from assistant.program.diagnostics import Span
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, Tool
from assistant.program.passes.present_places import Said
from assistant.program.program import Procedure, Program, TakenNames, bodies, identifier
from assistant.program.rewriting import Body, map_bodies, map_head, records

_DEFAULTS: Final = {TOOL: FLANGE, FRAME: BASE}

Mounting = tuple[str, str]
"""Names of a tool and a frame."""


def with_active_places(
    program: Program, reads: Callable[[Any], bool], said: Said, kept: StepsOfText
) -> tuple[Program, list[Span | None]]:
    """The program in which the tool and frame of each such text are known, and the places of those
    that may come before the first move: it counts as made with the flange, in the base.

    reads, said, kept: as `with_present_places` takes them. What no way tells stays.
    """
    if not any(map(reads, records_in_procedures(program, p.Opaque, e.Verbatim))):
        return program, []
    return _Active(program, reads, said, kept).program()


class _Active:
    def __init__(
        self, program: Program, reads: Callable[[Any], bool], said: Said, kept: StepsOfText
    ) -> None:
        self.whole, self.reads, self.said = program, reads, said
        self.ways = MotionStates(program, reads, kept)
        self.own = {q.name.lower() for q in program.procedures}
        taken = TakenNames(declared(program))
        self.names = tuple(identifier(one, taken) for one in ("active_tool", "active_frame"))
        self.used: set[str] = set()
        self.early: list[Span | None] = []

    def program(self) -> tuple[Program, list[Span | None]]:
        whole = self.whole
        procedures = tuple(replace(q, body=self.named(q, q.body)) for q in whole.procedures)
        if self.used:
            procedures = tuple(replace(q, body=self.noting(q.body)) for q in procedures)
        tool, frame = self.names
        tools = {**whole.tools, tool: Tool()} if tool in self.used else whole.tools
        frames = {**whole.frames, frame: Frame()} if frame in self.used else whole.frames
        return replace(whole, procedures=procedures, tools=tools, frames=frames), self.early

    # ------------------------------------------------------------------------------- reading

    def named(self, owner: Procedure, body: Body) -> Body:
        return tuple(self.statement(owner, node) for node in body)

    def statement(self, owner: Procedure, node: Any) -> p.Statement:
        if id(node) in self.ways.before:
            state = self.ways.at(owner, node)
            tool, frame = (self.active(state[part], part) for part in (TOOL, FRAME))
            early = any(START in state[part] for part in (TOOL, FRAME))

            def change(x: Any) -> Any:
                made = self.said(x, tool, frame) if self.reads(x) else x
                if isinstance(made, e.Here) and made is not x:
                    own = {made.tool, made.frame}
                    self.used |= own & set(self.names)
                    if early and not own.isdisjoint((*self.names, FLANGE, BASE)):
                        self.early.append(node.span)
                return made

            node = map_head(node, change)
        inner: p.Statement = map_bodies(node, lambda held: self.named(owner, held))
        return inner

    def active(self, names: frozenset[str], part: int) -> str | None:
        """The name of what is active, of a variable where that differs; None if nobody knows."""
        if UNKNOWN in names or not names:
            return None
        if len(names) > 1:
            return self.names[part]
        (only,) = names
        return _DEFAULTS[part] if only == START else self.ways.spelled.get(only)

    # ------------------------------------------------------------------------------- noting

    def noting(self, body: Body) -> Body:
        """A body in which what is active is noted behind moves, where anybody may ask for it."""
        made: list[p.Statement] = []
        last: tuple[int, Mounting] | None = None
        known: Mounting | None = None
        for node in body:
            mounting = _mounting_after(node)
            if (
                last is not None
                and (mounting is None or self.asks(node))
                and not _is_idle(node, self.asks)
            ):
                known, last = self.note(made, last, known), None
            if mounting is not None:
                last = len(made), mounting
            elif bodies(node) or self.calls(node) or isinstance(node, p.Label):
                known = None
            made.append(map_bodies(node, self.noting))
        if last is not None:
            self.note(made, last, known)
        return tuple(made)

    def note(
        self, made: list[p.Statement], last: tuple[int, Mounting], known: Mounting | None
    ) -> Mounting:
        """Puts the assignments behind the last move, and gives what they note."""
        at, mounting = last
        if mounting != known:
            span = made[at].span
            made[at + 1 : at + 1] = [
                p.Assign(e.Name(name), value, span=span)
                for name, value in self.values(mounting)
                if name in self.used
            ]
        return mounting

    def values(self, mounting: Mounting) -> Iterator[tuple[str, e.Expression]]:
        for name, one, default in zip(self.names, mounting, (FLANGE, BASE), strict=True):
            standard = one.lower() == default
            yield name, e.PoseValue(IDENTITY) if standard else e.Name(one)

    def asks(self, node: p.Statement) -> bool:
        """Whether a statement reads what is active, or calls what may."""
        return self.calls(node) or any(
            isinstance(one, e.Here) and not {one.tool, one.frame}.isdisjoint(self.used)
            for one in records(node)
        )

    def calls(self, node: p.Statement) -> bool:
        return any(
            (isinstance(one, e.Apply) and one.function.lower() in self.own)
            or isinstance(one, p.Call | p.Opaque | e.Verbatim)
            for one in records(node)
        )


def _mounting_after(node: p.Statement) -> Mounting | None:
    """The tool and frame that are active behind a statement, if it is a move."""
    match node:
        case p.Move() | p.MoveCircular() | p.MoveJoints():
            return node.motion.tool, node.motion.frame
        case p.Follow(path) if len(path):
            return path.tools[path.tool[-1]], path.frames[path.frame[-1]]
    return None


def _is_idle(node: p.Statement, asks: Callable[[p.Statement], bool]) -> bool:
    """Whether a statement neither asks nor leads anywhere else."""
    leads = isinstance(node, p.Label | p.Goto | p.Return | p.Stop)
    return not (leads or bodies(node) or asks(node))
