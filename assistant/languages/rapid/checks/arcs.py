"""Rules of MoveC: where its three points may lie, for targets that are known before the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.languages.checks.moves import Follower, Moves, Point
from assistant.languages.checks.registry import Found, like_it
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import name_of, option, positional
from assistant.languages.rapid.tree.gather import literal_target
from assistant.languages.rapid.tree.runs import CIRCULAR, LINEAR, MotionNames, TargetRun
from assistant.languages.rapid.tree.walk import lists
from assistant.languages.runs.columns import Entries, NameIndex, Names
from assistant.program.geometry import ArcMeasures

LEAST_APART: Final = 0.1
"""mm between start, circle point and end (instruction manual, MoveC)."""
LEAST_ANGLE: Final = 1.0
"""degrees between circle point and end, seen from the start (instruction manual, MoveC)."""
MOST_ARCS_REPORTED: Final = 100
"""Arcs of a list of statements with the same mistake that are reported one by one."""
LONGEST_ARC: Final = 240.0
"""degrees that an arc should go round at most."""
TARGET_COUNTS: Final = {"movej": 1, "movel": 1, "movec": 2}
"""Plain moves with the number of their targets."""

ToolAndFrame = tuple[str, str]
"""The tool and the work object of a move, lower case."""


def arcs(look: RuleContext) -> Found:
    runs = [n for n in look.all(s.MoveRunNode) if (n.run.kinds == CIRCULAR).any()]
    if not runs and not any(str(c.name).lower() == "movec" for c in look.all(s.ProcedureCall)):
        return
    known = _KnownPositions(look)
    for routine in look.routines:
        for body in lists(routine):
            moves = _moves_of_list(look, routine, known, body)
            if moves is not None:
                yield from _arc_findings(look, moves)


def _moves_of_list(
    look: RuleContext, routine: s.Routine, known: _KnownPositions, body: Sequence[s.StatementNode]
) -> Moves[s.Node] | None:
    """Follows the robot through a list of statements; after what is no move it is nowhere."""
    found: Follower[s.Node] = Follower()
    here: ToolAndFrame | None = None
    own = {d.type.lower() for d in look.frame(routine)}
    for node in body:
        if isinstance(node, s.MoveRunNode):
            run = node.run
            frames = Entries(tuple(map(_tool_and_frame, run.motions.table)), run.motions.index)
            ends = known.of(run.names) if run.values is None else run.values[:, :3]
            apart = np.zeros(len(run), bool)
            apart[1:] = ~frames.rows(slice(1, None)).equal(frames.rows(slice(-1)))
            # a name may mean another target here
            kinds = run.kinds.astype(np.int64) * ("robtarget" not in own)
            vias, follows = known.of(run.vias), here == frames[0]
            found.table(node, kinds, ends, vias=vias, follows=follows, apart=apart)
            here = frames[-1]
        elif isinstance(node, s.ProcedureCall):
            targets = _targets_of_move(node)
            if targets is None:
                here = None
                continue
            points, frame = targets
            at = [known.one(point, look, routine) for point in points]
            kind = CIRCULAR if len(points) > 1 else LINEAR
            found.line(node, kind, end=at[-1], via=at[0], follows=here == frame)
            here = frame
        elif not isinstance(node, s.CommentLine | s.Assignment):
            here = None
    return found.moves()


def _tool_and_frame(motion: MotionNames) -> ToolAndFrame:
    return motion.tool.lower(), (motion.frame or "wobj0").lower()


def _targets_of_move(call: s.ProcedureCall) -> tuple[list[s.Expression], ToolAndFrame] | None:
    """Targets of a plain move, with its tool and work object; None for anything else."""
    count = TARGET_COUNTS.get(str(call.name).lower())
    plain = positional(call)
    if count is None or len(plain) != count + 3:
        return None
    given = option(call, "wobj")
    tool, frame = name_of(plain[-1]), "wobj0" if given is None else name_of(given.value)
    return (plain[:count], (tool.lower(), frame.lower())) if tool and frame else None


def _arc_findings(look: RuleContext, moves: Moves[s.Node]) -> Found:
    rows = np.flatnonzero(moves.kinds == CIRCULAR)
    measures = ArcMeasures.through(
        np.stack([moves.before[rows], moves.vias[rows], moves.ends[rows]], axis=1)
    )
    close = measures.sides < LEAST_APART  # NaN is no length, so it never is
    plain = ~close.any(axis=1) & ~np.isnan(measures.sides).any(axis=1)
    straight = measures.apart < LEAST_ANGLE
    for rule, what, bad in (
        (rules.ARC_CLOSE, "start and circle point", close[:, 0]),
        (rules.ARC_CLOSE, "circle point and end", close[:, 1]),
        (rules.ARC_CLOSE, "start and end", close[:, 2]),
        (rules.ARC_STRAIGHT, "", plain & straight),
        (rules.ARC_LONG, "", plain & ~straight & (measures.around > LONGEST_ARC)),
    ):
        faults = np.flatnonzero(bad)
        for number, at in enumerate(faults[:MOST_ARCS_REPORTED].tolist(), 1):
            row = rows[at]
            yield look.finding(
                rule,
                moves.items[moves.item[row]],
                row=int(moves.row[row]),
                what=what,
                angle=float(measures.around[at]),
                more=like_it(
                    len(faults) - MOST_ARCS_REPORTED if number == MOST_ARCS_REPORTED else 0
                ),
            )


class _KnownPositions:
    """Positions of the robtargets that a module can name and that nothing changes."""

    def __init__(self, look: RuleContext) -> None:
        own = [node.run for of, node in look.task.runs if of is look.module and _is_local(node)]
        local = _indexed_positions(own, [look.module], local=True)
        self._runs = [*look.task.once(_shared_positions), *local]

    def one(self, value: s.Expression, look: RuleContext, routine: s.Routine) -> Point:
        """Of an expression."""
        if isinstance(value, s.NameRef):
            found = look.find(value.name, routine)
            if found is None or found.kind != "CONST":
                return ()
            if not isinstance(found.node, s.Data):
                return tuple(self.of(Names.of([value.name]))[0].tolist())
            if found.node.dimensions or found.node.value is None:
                return ()
            value = found.node.value
        return tuple(literal_target(value) or ())

    def of(self, names: Names) -> Floats:
        """(n, 3) of names in columns; NaN where they are not known."""
        out = np.full((len(names), 3), np.nan)
        for run, index in self._runs:
            rows = index.rows(names)
            out[rows >= 0] = run.values[rows[rows >= 0], :3]
        return out


def _is_local(node: s.TargetRunNode | s.Data) -> bool:
    return node.scope == "LOCAL"


def _shared_positions(task: Task) -> list[tuple[TargetRun, NameIndex]]:
    """Positions that all modules of a task can name."""
    runs = [node.run for _, node in task.runs if not _is_local(node)]
    return _indexed_positions(runs, task.modules, local=False)


def _indexed_positions(
    runs: Sequence[TargetRun], modules: Sequence[s.Module], *, local: bool
) -> list[tuple[TargetRun, NameIndex]]:
    """Runs and single declarations of modules, LOCAL or not, each with an index of its names."""
    names, values = [], []
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Data) and _is_local(item) == local:
                numbers = literal_target(item.value) if item.storage == "CONST" else None
                if numbers is not None and not item.dimensions and item.name.isascii():
                    names.append(item.name)
                    values.append(numbers)
    known = [*runs]
    if names:
        known.append(TargetRun(Names.of(names), np.array(values, dtype=np.float64)))
    return [(run, NameIndex(run.names)) for run in known]
