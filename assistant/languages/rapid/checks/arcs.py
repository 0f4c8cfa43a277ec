"""Rules of MoveC: where its three points may lie, for targets that are known before the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_target
from assistant.languages.rapid.tree.runs import CIRCULAR, MotionNames, MoveRun, TargetRun
from assistant.languages.rapid.tree.walk import lists
from assistant.languages.runs.columns import Entries
from assistant.languages.runs.names import Index, Names
from assistant.program.arrays import Floats, Rows
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]

LEAST_APART: Final = 0.1
"""mm between start, circle point and end (instruction manual, MoveC)."""
LEAST_ANGLE: Final = 1.0
"""degrees between circle point and end, seen from the start (instruction manual, MoveC)."""
LONGEST: Final = 240.0
"""degrees that an arc should go round at most."""
UNKNOWN: Final = (np.nan, np.nan, np.nan)
MOVES: Final = {"movej": 1, "movel": 1, "movec": 2}
"""Plain moves with the number of their targets."""


@dataclass(slots=True)
class _Here:
    """Where the robot stands: what the last move named, and in which frame and tool."""

    point: Floats
    of: tuple[str, str]


def arcs(look: Look) -> Found:
    runs = [n for n in look.all(s.MoveRunNode) if (n.run.kinds == CIRCULAR).any()]
    if not runs and not any(str(c.name).lower() == "movec" for c in look.all(s.ProcedureCall)):
        return
    known = _Positions(look)
    for routine in look.routines:
        for body in lists(routine):
            yield from _body(look, routine, known, body)


def _body(
    look: Look, routine: s.Routine, known: _Positions, body: Sequence[s.StatementNode]
) -> Found:
    """Follows the robot through a list of statements; after what is no move it is nowhere."""
    here = _nowhere()
    for node in body:
        if isinstance(node, s.MoveRunNode):
            own = {d.type.lower() for d in look.frame(routine).values()}
            if "robtarget" not in own:  # else a name may mean another target here
                yield from _run(look, known, node, here)
            last = node.run.motions[-1]
            here = _Here(known.last(node.run), _frame(last))
        elif isinstance(node, s.ProcedureCall):
            targets = _targets(node)
            if targets is None:
                here = _nowhere()
                continue
            points, of = targets
            row = [known.one(point, look, routine) for point in points]
            if len(points) == 2:
                start = here.point if here.of == of else np.array(UNKNOWN)
                yield from _found(look, node, np.stack([start, *row])[None], np.zeros(1, np.intp))
            here = _Here(row[-1], of)
        elif not isinstance(node, s.CommentLine | s.Assignment):
            here = _nowhere()


def _nowhere() -> _Here:
    return _Here(np.array(UNKNOWN), ("", ""))


def _frame(motion: MotionNames) -> tuple[str, str]:
    return motion.tool.lower(), (motion.frame or "wobj0").lower()


def _targets(call: s.ProcedureCall) -> tuple[list[s.Expression], tuple[str, str]] | None:
    """Targets of a plain move, with its tool and work object; None for anything else."""
    count = MOVES.get(str(call.name).lower())
    plain = [a.value for a in call.arguments if isinstance(a, s.Positional)]
    if count is None or len(plain) != count + 3:
        return None
    frames = [a for a in call.arguments if isinstance(a, s.Option) and a.name.lower() == "wobj"]
    frame = frames[0].value if frames else s.NameRef("wobj0")
    tool = plain[-1]
    if not isinstance(tool, s.NameRef) or not isinstance(frame, s.NameRef):
        return None
    return plain[:count], (tool.name.lower(), frame.name.lower())


def _run(look: Look, known: _Positions, node: s.MoveRunNode, here: _Here) -> Found:
    run = node.run
    rows = np.flatnonzero(run.kinds == CIRCULAR)
    if not len(rows):
        return
    ends, vias = known.of(run.names), known.of(run.vias.rows(rows))
    frames = Entries(tuple(map(_frame, run.motions.table)), run.motions.index)
    same = frames.rows(rows).equal(frames.rows(np.maximum(rows - 1, 0)))
    starts = np.where(same[:, None], ends[np.maximum(rows - 1, 0)], np.nan)
    if rows[0] == 0:
        starts[0] = here.point if here.of == frames[0] else UNKNOWN
    yield from _found(look, node, np.stack([starts, vias, ends[rows]], axis=1), rows)


def _found(look: Look, node: s.Node, points: Floats, rows: Rows) -> Found:
    """points: (n, 3, 3) start, circle point and end; NaN for a point that is not known."""
    start, via, end = (points[:, i] for i in range(3))
    to_via, to_end, rest = via - start, end - start, end - via
    lengths = np.linalg.norm(np.stack([to_via, rest, to_end], axis=1), axis=2)
    close = lengths < LEAST_APART  # NaN is no length, so it never is
    angle = _between(to_via, to_end)
    # the angle at the circle point stands on the part of the circle that is left out
    turn = 360.0 - 2.0 * _between(-to_via, rest)
    plain = ~close.any(axis=1) & ~np.isnan(lengths).any(axis=1)
    straight, long = angle < LEAST_ANGLE, turn > LONGEST
    for rule, what, bad in (
        (rules.ARC_CLOSE, "start and circle point", close[:, 0]),
        (rules.ARC_CLOSE, "circle point and end", close[:, 1]),
        (rules.ARC_CLOSE, "start and end", close[:, 2]),
        (rules.ARC_STRAIGHT, "", plain & straight),
        (rules.ARC_LONG, "", plain & ~straight & long),
    ):
        at = np.flatnonzero(bad)
        if len(at):
            more = f", as of {len(at) - 1} more" if len(at) > 1 else ""
            given = {"what": what, "angle": float(turn[at[0]]), "more": more}
            yield look.finding(rule, node, row=int(rows[at[0]]), **given)


def _between(a: Floats, b: Floats) -> Floats:
    """(n,) degrees between vectors."""
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angles: Floats = np.degrees(np.arctan2(sine, (a * b).sum(axis=1)))
    return angles


class _Positions:
    """Positions of the robtargets that a module can name and that nothing changes."""

    def __init__(self, look: Look) -> None:
        self._runs = [n.run for of, n in look.task.runs if of is look.module or n.scope != "LOCAL"]
        names, values = [], []
        for module in look.task.modules:
            for item in module.items:
                if isinstance(item, s.Data) and (module is look.module or item.scope != "LOCAL"):
                    numbers = literal_target(item.value) if item.storage == "CONST" else None
                    if numbers is not None and not item.dimensions and item.name.isascii():
                        names.append(item.name)
                        values.append(numbers)
        if names:
            self._runs.append(TargetRun(Names.of(names), np.array(values, dtype=np.float64)))
        self._indices = [Index(run.names) for run in self._runs]

    def one(self, value: s.Expression, look: Look, routine: s.Routine) -> Floats:
        """(3,) of an expression; NaN where it is not known."""
        if isinstance(value, s.NameRef):
            found = look.find(value.name, routine)
            if found is None or found.kind != "CONST":
                return np.array(UNKNOWN)
            if not isinstance(found.node, s.Data):
                return np.array(self.of(Names.of([value.name]))[0])
            if found.node.dimensions or found.node.value is None:
                return np.array(UNKNOWN)
            value = found.node.value
        numbers = literal_target(value)
        return np.array(UNKNOWN if numbers is None else numbers[:3])

    def last(self, run: MoveRun) -> Floats:
        """(3,) of where a run ends."""
        if run.values is not None:
            return np.array(run.values[-1, :3])
        return np.array(self.of(run.names.rows(slice(-1, None)))[0])

    def of(self, names: Names) -> Floats:
        """(n, 3) of names in columns; NaN where they are not known."""
        out = np.full((len(names), 3), np.nan)
        for run, index in zip(self._runs, self._indices, strict=True):
            rows = index.rows(names)
            out[rows >= 0] = run.values[rows[rows >= 0], :3]
        return out
