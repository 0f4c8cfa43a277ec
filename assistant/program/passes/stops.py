"""Waits for the robot to stand still, as stops at the targets of the moves before them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.ways import (
    CORNER,
    STOP,
    UNKNOWN,
    MotionStates,
    MotionStep,
    StepsOfText,
    corner_of,
)
from assistant.program.motion import FINE
from assistant.program.program import Program, walk
from assistant.program.rewriting import Body, map_bodies


def with_stops(
    program: Program,
    kept: StepsOfText,
    left: Callable[[p.Opaque], Iterable[p.Statement]],
    in_corner: e.Reason,
    always: Callable[[p.MoveStatement], None],
    after: Callable[[p.Opaque], None],
) -> Program:
    """The program with stops for those of its kept texts that only wait for the robot to stand.

    kept: what kept texts do. left: what a wait does besides. in_corner: why one stays that may find
    the robot in a corner of which nobody knows. always: tells of a move that goes on without a stop
    on other ways, and stops on all of them. after: tells of a wait that may be for a kept move.
    """

    def waits(node: Any) -> bool:
        return isinstance(node, p.Opaque) and [*(kept(node.text) or ())] == [MotionStep.STOPS]

    def moves(node: Any) -> bool:
        """True if a kept text may move the arm: the program is incomplete by that, not by waits."""
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
    early = frozenset().union(*known).intersection(ways.cut) - {STOP}
    standing = {STOP, UNKNOWN} if any(map(moves, program.statements())) else {STOP}
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
