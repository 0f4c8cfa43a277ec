"""Motion state that statements leave implicit: tool and frame, stops, unwatched configurations.

A statement that reads the position reads it in the active tool and frame: those of the last move.
Which move is the last one depends on the control flow before the statement, including calls. The
pass names tool and frame if they are known; if several moves may be the last one, each of them
stores its tool and frame after it, in two variables.

Waits for the robot to stop become stops at the targets of the moves before them. A straight move or
an arc with an unwatched configuration continues in the configuration closest to that of its start,
even if its target states another one: its targets are left open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Span
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.motion_state import (
    CORNER,
    FRAME,
    LINES,
    OPEN,
    START,
    STOP,
    TOOL,
    UNKNOWN,
    MotionStates,
    MotionStep,
    StepsOfText,
    corner_of,
)
from assistant.program.analysis.uses import declared, names_in
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, Target, Tool
from assistant.program.motion import FINE, Kind, Path, configuration_row
from assistant.program.program import Procedure, Program, TakenNames, bodies, identifier, walk
from assistant.program.rewriting import Body, map_bodies, map_head, records, rewrite
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

Said = Callable[[e.Expression, str | None, str | None], e.Expression]
"""Translation of a text that reads the position, with the active tool and frame as far as known."""


def with_present_places(
    program: Program, reads: Callable[[Any], bool], said: Said, kept: StepsOfText
) -> Program:
    """Return the program with the texts that read the position replaced by `said`.

    reads: True for records that are such texts. kept: the steps of vendor texts.
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
        # Only if some text needs them do moves store their tool and frame.
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
        # Before the first move the flange and the base are active.
        return _DEFAULTS[part] if only == START else self.ways.spelled.get(only)

    # ------------------------------------------------------------------------------- noting

    def noting(self, body: Body) -> Body:
        """A body in which what is active is noted behind moves, where anybody may ask for it."""
        made: list[p.Statement] = []
        last: tuple[int, Mounting] | None = None
        known: Mounting | None = None
        for node in body:
            mounting = _mounting_after(node)
            # Stored as late as possible: several moves in a row store once.
            if (
                last is not None
                and (mounting is None or self.asks(node))
                and not _is_idle(node, self.asks)
            ):
                known, last = self.note(made, last, known), None
            if mounting is not None:
                last = len(made), mounting
            elif bodies(node) or self.calls(node) or isinstance(node, p.Label):
                # Other paths may lead here with another tool or frame.
                known = None
            made.append(map_bodies(node, self.noting))
        if last is not None:
            self.note(made, last, known)
        return tuple(made)

    def note(
        self, made: list[p.Statement], last: tuple[int, Mounting], known: Mounting | None
    ) -> Mounting:
        """Insert the assignments after the last move, and return the values that they store."""
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
        """True if a statement reads the active tool or frame, or calls a procedure that may."""
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
    """True if a statement neither reads the state nor changes the control flow."""
    leads = isinstance(node, p.Label | p.Goto | p.Return | p.Stop)
    return not (leads or bodies(node) or asks(node))


def with_stops(
    program: Program,
    kept: StepsOfText,
    left: Callable[[p.Opaque], Iterable[p.Statement]],
    in_corner: e.Reason,
    always: Callable[[p.MoveStatement], None],
    after: Callable[[p.Opaque], None],
) -> Program:
    """Return the program with stops in place of vendor statements that only wait for the robot to
    stop.

    kept: the steps of vendor texts. left: the other effects of a wait. in_corner: reason why a wait
    stays if the robot may be in an unknown corner. always: reports a move that continues without a
    stop on other control paths, and stops on all of them. after: reports a wait that may follow a
    vendor move.
    """

    def waits(node: Any) -> bool:
        return isinstance(node, p.Opaque) and [*(kept(node.text) or ())] == [MotionStep.STOPS]

    def moves(node: Any) -> bool:
        """True if a vendor text may move the arm: that makes the program incomplete, a wait does
        not.
        """
        if not isinstance(node, p.Opaque):
            return False
        steps = kept(node.text)
        return steps is None or MotionStep.MOVES in steps or MotionStep.CALLS in steps

    if not any(map(waits, program.statements())):
        return program
    ways = MotionStates(program, waits, kept)
    corners = {
        id(node): ways.at(procedure, node)[CORNER]
        for procedure in program.procedures
        for node in walk(procedure.body)
        if waits(node)
    }
    known = (one for one in corners.values() if UNKNOWN not in one)
    # Corners with a wait after them that other paths cut through: these stop on all paths.
    early = frozenset().union(*known).intersection(ways.cut) - {STOP}
    standing = {STOP, UNKNOWN} if any(map(moves, program.statements())) else {STOP}
    # The moves that become stops: those before waits alone, and the ones that other paths cut.
    stopping = frozenset().union(*corners.values()) - ways.cut - {UNKNOWN, STOP} | early

    def said(body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            if isinstance(node, p.MoveStatement) and corner_of(node) in stopping:
                if corner_of(node) in early:
                    always(node)
                made.append(stopped(node))
            elif isinstance(node, p.Opaque) and id(node) in corners:
                stands = corners[id(node)] <= {*standing, *stopping}
                if stands and UNKNOWN in corners[id(node)]:
                    after(node)
                made += left(node) if stands else [replace(node, reason=in_corner)]
            else:
                made.append(map_bodies(node, said))
        return tuple(made)

    procedures = tuple(replace(q, body=said(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures) if corners else program


def stopped(move: p.MoveStatement) -> p.MoveStatement:
    """A move that ends at its target."""
    return replace(move, motion=replace(move.motion, blend=FINE))


def with_open_lines(program: Program, kept: StepsOfText) -> Program:
    """Return the program with open configurations in targets that only such straight moves use, so
    that an arm chooses.

    kept: the steps of vendor texts.
    """
    ways = MotionStates(program, _is_straight, kept)
    free = {
        id(node)
        for procedure in program.procedures
        for node in walk(procedure.body)
        if _is_straight(node) and ways.at(procedure, node)[LINES] == {OPEN}
    }
    if not free:
        return program
    uses, open_uses = Counter[str](), Counter[str]()
    for part in (program.procedures, program.variables):
        uses.update(name.lower() for name in names_in(part))
    for declaration in program.declarations:
        uses.update(effect_of(declaration).names)
    for node in program.statements():
        if id(node) in free:
            open_uses.update(name.lower() for name in names_in(node))
    targets = {
        name: replace(target, configuration=None)
        # Only targets that no other statement uses may lose their configuration.
        if 0 < uses[name.lower()] == open_uses[name.lower()]
        else target
        for name, target in program.targets.items()
    }

    def opened(body: Body) -> Body:
        return tuple(
            rewrite(node, _opened, ()) if id(node) in free else map_bodies(node, opened)
            for node in body
        )

    procedures = tuple(replace(q, body=opened(q.body)) for q in program.procedures)
    return replace(program, targets=targets, procedures=procedures)


def _is_straight(record: Any) -> bool:
    match record:
        case p.Move(kind="linear") | p.MoveCircular():
            return True
        case p.Follow(path):
            return bool((path.kinds != Kind.JOINT).any())
    return False


def _opened(part: Any) -> Any:
    match part:
        case Target():
            return replace(part, configuration=None)
        case Path():
            rows = part.configurations.copy()
            rows[part.kinds != Kind.JOINT] = np.array(configuration_row(None), rows.dtype)
            return replace(part, configurations=rows)
    return part
