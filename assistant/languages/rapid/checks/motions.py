"""Rules of motion: names of speeds and zones, arcs, timing of waits and outputs.

Arcs are checked where their three points are known before the run (instruction manual, MoveC:
points at least 0.1 mm and 1 degree apart). Timing: an output that is set, or a position that is
read, before the move in front of it has ended; waits without a time limit; triggdata that nothing
sets up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.moves import Follower, Moves, Point
from assistant.languages.checks.registry import Found, like_it
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.rule_context import RuleContext, Task
from assistant.languages.rapid.tables.constants import SPEEDS, ZONES
from assistant.languages.rapid.tables.signals import (
    LONGEST_TRIGGER_TIME,
    TRIGGER_SETUPS,
    TRIGGER_TYPE,
)
from assistant.languages.rapid.tables.signals import TRIGGER_MOVES as TRIGGERED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number, literal_target
from assistant.languages.rapid.tree.syntax import (
    CIRCULAR,
    LINEAR,
    PLAIN_MOVES,
    MotionNames,
    TargetRun,
)
from assistant.languages.rapid.tree.walk import (
    blocks,
    lists,
    name_of,
    nodes,
    option,
    positional,
    triggers_taken,
)
from assistant.languages.runs.columns import Entries, NameIndex, Names
from assistant.program.geometry import ArcMeasures

MOVE_WORDS: Final = frozenset(word.lower() for word in (*PLAIN_MOVES, "MoveAbsJ"))
"""The moves that the pseudo-program has words for, lower case."""
PREDEFINED_SETTINGS: Final[Mapping[str, tuple[Mapping[str, Any], Rule]]] = {
    "speeddata": (SPEEDS, rules.UNKNOWN_SPEED),
    "zonedata": (ZONES, rules.UNKNOWN_ZONE),
}
"""By type: the values that every controller knows, and the rule of names that look like them."""


def motion_names(look: RuleContext) -> Found:
    named = {d.name.lower() for d in look.all(s.Data)}
    named |= {p.name.lower() for p in look.all(s.ParameterNode)}
    for call in look.all(s.ProcedureCall):
        plain = positional(call)
        if str(call.name).lower() in MOVE_WORDS and len(plain) >= 4:
            wobj = option(call, "wobj")
            frame = name_of(wobj.value) if wobj else ""
            places = [(name_of(value), value) for value in plain[-3:]]
            yield from _names_of_move(look, named, [*places, (frame, call)])


def _names_of_move(
    look: RuleContext, named: set[str], given: Sequence[tuple[str, s.Node]]
) -> Found:
    """Check the names in a move. given: names of speed, zone, tool and frame, each with the node to
    report it at.
    """
    *values, tool, frame = given
    for (name, node), type in zip(values, PREDEFINED_SETTINGS, strict=True):
        if name and name.lower() not in named and not look.find(name):
            yield from unknown_setting(look, node, name, type)
    for (name, node), role, own in ((tool, "tool", "tool0"), (frame, "work object", "wobj0")):
        found = look.find(name) if name and name.lower() != own else None
        if found is not None and found.kind in ("VAR", "CONST"):
            yield look.finding(rules.NOT_PERSISTENT, node, name=name, role=role)


def unknown_setting(look: RuleContext, node: s.Node, name: str, type: str) -> Found:
    """Report an undeclared name that resembles a predefined speed or zone but is not one."""
    table, rule = PREDEFINED_SETTINGS[type]
    near = "" if name.lower() in table else nearest_predefined(name, table)
    if near:
        severity = Severity.ERROR if look.compiled else Severity.WARNING
        yield look.finding(rule, node, severity=severity, name=name, near=near)


def nearest_predefined(name: str, table: Mapping[str, Any]) -> str:
    """The predefined names around one that looks like them, empty for any other name."""
    letter = "v" if table is SPEEDS else "z"
    if name[:1].lower() != letter or not name[1:].isdigit():
        return ""
    value = int(name[1:])
    sizes = sorted(int(n[1:]) for n in table if n[1:].isdigit())
    below = [n for n in sizes if n < value][-1:]
    above = [n for n in sizes if n > value][:1]
    return " or ".join(f"{letter}{n}" for n in below + above)


_MoveProgress = Literal["on the fly", "aside", ""]
"""Progress of the previous move: rounding its corner, running in parallel with the program, or
ended.
"""

_ZONE_POSITIONS: Final = {
    **dict.fromkeys(("movej", "movel", "movec", "moveabsj", "triggj", "triggl", "triggc"), -2),
    **dict.fromkeys(("movejdo", "moveldo", "movecdo"), -4),
}
"""Instructions of motion, with where among their plain arguments the zone stands."""
_SETTING_INSTRUCTIONS: Final = frozenset(
    ("set", "reset", "setdo", "setgo", "setao", "pulsedo", "invertdo")
)
_POSITION_FUNCTIONS: Final = frozenset(("crobt", "cpos", "cjointt"))
"""Functions that tell where the robot is now; it should stand still for them."""
_WAIT_INSTRUCTIONS: Final = frozenset(
    ("waituntil", *(f"wait{kind}" for kind in ("di", "do", "gi", "go", "ai", "ao")))
)
_INSTANT_INSTRUCTIONS: Final = frozenset(
    (
        *("tpwrite", "tperase", "incr", "decr", "add", "clear", "clkstart", "clkreset", "clkstop"),
        *("triggio", "triggequip"),
    )
)
"""Instructions that take no time: a move goes on through them."""


def endless_waits(look: RuleContext) -> Found:
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in _WAIT_INSTRUCTIONS:
            given = {a.name.lower() for a in call.arguments if not isinstance(a, s.Positional)}
            # `WaitUntil TRUE` only waits for the arm, if at all.
            if "maxtime" not in given and positional(call) != [s.BoolLiteral(True)]:
                yield look.finding(rules.ENDLESS_WAIT, call, word=call.name)


def signals_on_the_fly(look: RuleContext) -> Found:
    """Signals that are set, and positions that are read, before a move has ended."""
    for routine in look.routines:
        for body in (routine.body, *(h.body for h in routine.handlers)):
            yield from _follow_moves(look, routine, body, "")


def _follow_moves(
    look: RuleContext, routine: s.Routine, body: Sequence[s.StatementNode], going: _MoveProgress
) -> Found:
    for statement in body:
        if (
            going
            and isinstance(statement, s.Assignment | s.ProcedureCall)
            and _reads_position(statement)
        ):
            yield look.finding(rules.READ_ON_THE_FLY, statement)
        match statement:
            case s.MoveRunNode(run):
                # Within a run each move follows a move; only the last one is before something else.
                going = _progress_of_zone(look, run.motions[-1].zone, routine)
            case s.ProcedureCall(str(name)) if name.lower() in _ZONE_POSITIONS:
                going = _progress_of_move(look, statement, name.lower(), routine)
            case s.ProcedureCall(str(name)) if name.lower() in _SETTING_INSTRUCTIONS:
                if going:
                    yield look.finding(rules.ON_THE_FLY, statement, word=name)
            case s.ProcedureCall(str(name)) if name.lower() in _INSTANT_INSTRUCTIONS:
                pass
            case s.Assignment() | s.CommentLine() | s.Placeholder():
                pass
            # Any other statement may take time or stop, so the arm may have arrived afterwards.
            case _:
                for block in blocks(statement):
                    yield from _follow_moves(look, routine, block, going)
                going = ""


def _reads_position(statement: s.Assignment | s.ProcedureCall) -> bool:
    """True if a statement reads the position of the robot."""
    return any(
        isinstance(node, s.FunctionCall) and node.name.lower() in _POSITION_FUNCTIONS
        for node in nodes(statement)
    )


def _progress_of_move(
    look: RuleContext, call: s.ProcedureCall, name: str, routine: s.Routine
) -> _MoveProgress:
    if option(call, "conc"):
        return "aside"
    # These options replace the zone, so that nothing is certain.
    if option(call, "z", "inpos"):
        return ""
    plain = positional(call)
    zone = name_of(plain[_ZONE_POSITIONS[name]]) if len(plain) >= -_ZONE_POSITIONS[name] else ""
    return _progress_of_zone(look, zone, routine) if zone else ""


def _progress_of_zone(look: RuleContext, zone: str, routine: s.Routine) -> _MoveProgress:
    """`on the fly` for a zone that surely has a size."""
    found = look.find(zone, routine)
    if found is None:
        return "on the fly" if zone.lower() in ZONES and zone.lower() != "fine" else ""
    value = found.node.value if isinstance(found.node, s.Data) else None
    # Only a constant with a size surely rounds the corner.
    rounded = isinstance(value, s.AggregateNode) and value.items[0] == s.BoolLiteral(False)
    return "on the fly" if rounded and found.kind == "CONST" else ""


# Outputs on the way


def unset_triggers(look: RuleContext) -> Found:
    """Data that moves are given though nothing sets them up."""
    if not any(str(call.name).lower() in TRIGGERED for call in look.all(s.ProcedureCall)):
        return
    elsewhere = look.task.once(_mentioned_elsewhere)
    for routine in look.routines:
        for node in nodes(routine):
            for one in triggers_taken(node):
                declared = look.find(one.name, routine)
                own = declared is not None and isinstance(declared.node, s.Data)
                # A parameter is set up by the caller.
                if declared is None or not own or declared.type.lower() != TRIGGER_TYPE:
                    continue
                if one.name.lower() not in elsewhere:
                    yield look.finding(rules.NEVER_SET_UP, one, name=one.name)


def _mentioned_elsewhere(task: Task) -> set[str]:
    """Lower-case names that are mentioned other than where a move takes them."""
    named: Counter[str] = Counter()
    for node in nodes(task.modules):
        if isinstance(node, s.NameRef):
            named[node.name.lower()] += 1
        elif isinstance(node, s.ProcedureCall):
            named.subtract(one.name.lower() for one in triggers_taken(node))
    # More mentions than moves take: something else may set the data up.
    return {name for name, count in named.items() if count > 0}


def long_trigger_times(look: RuleContext) -> Found:
    """Times before the end of a move that no controller looks ahead."""
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in TRIGGER_SETUPS and option(call, "time"):
            given = positional(call)
            seconds = literal_number(given[1]) if len(given) > 1 else None
            if seconds is not None and seconds > LONGEST_TRIGGER_TIME:
                yield look.finding(rules.LONG_TIME, given[1], most=LONGEST_TRIGGER_TIME)


_LEAST_APART: Final = 0.1
"""mm between start, circle point and end (instruction manual, MoveC)."""
_LEAST_ANGLE: Final = 1.0
"""degrees between circle point and end, seen from the start (instruction manual, MoveC)."""
_MOST_ARCS_REPORTED: Final = 100
"""Arcs of a list of statements with the same mistake that are reported one by one."""
_LONGEST_ARC: Final = 240.0
"""degrees that an arc should go round at most."""
_TARGET_COUNTS: Final = {"movej": 1, "movel": 1, "movec": 2}
"""Plain moves with the number of their targets."""

_ToolAndFrame = tuple[str, str]
"""The tool and the work object of a move, lower case."""


def arcs(look: RuleContext) -> Found:
    # Most modules have no arcs, and positions are costly to gather.
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
    here: _ToolAndFrame | None = None
    own = {d.type.lower() for d in look.frame(routine)}
    for node in body:
        if isinstance(node, s.MoveRunNode):
            run = node.run
            frames = Entries(tuple(map(_tool_and_frame, run.motions.table)), run.motions.index)
            ends = known.of(run.names) if run.values is None else run.values[:, :3]
            apart = np.zeros(len(run), bool)
            # Positions in different tools or frames have no distance.
            apart[1:] = ~frames.rows(slice(1, None)).equal(frames.rows(slice(-1)))
            # a name may mean another target here
            # A routine with targets of its own may hide names of the table; kind 0 leaves the row
            # out.
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


def _tool_and_frame(motion: MotionNames) -> _ToolAndFrame:
    return motion.tool.lower(), (motion.frame or "wobj0").lower()


def _targets_of_move(call: s.ProcedureCall) -> tuple[list[s.Expression], _ToolAndFrame] | None:
    """Targets of a plain move, with its tool and work object; None for anything else."""
    count = _TARGET_COUNTS.get(str(call.name).lower())
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
    close = measures.sides < _LEAST_APART  # NaN is no length, so it never is
    # Points that are too close have no angle, and have a finding already.
    plain = ~close.any(axis=1) & ~np.isnan(measures.sides).any(axis=1)
    straight = measures.apart < _LEAST_ANGLE
    for rule, what, bad in (
        (rules.ARC_CLOSE, "start and circle point", close[:, 0]),
        (rules.ARC_CLOSE, "circle point and end", close[:, 1]),
        (rules.ARC_CLOSE, "start and end", close[:, 2]),
        (rules.ARC_STRAIGHT, "", plain & straight),
        (rules.ARC_LONG, "", plain & ~straight & (measures.around > _LONGEST_ARC)),
    ):
        faults = np.flatnonzero(bad)
        for number, at in enumerate(faults[:_MOST_ARCS_REPORTED].tolist(), 1):
            row = rows[at]
            yield look.finding(
                rule,
                moves.items[moves.item[row]],
                row=int(moves.row[row]),
                what=what,
                angle=float(measures.around[at]),
                more=like_it(
                    len(faults) - _MOST_ARCS_REPORTED if number == _MOST_ARCS_REPORTED else 0
                ),
            )


class _KnownPositions:
    """Positions of the robtargets that a module can name and that nothing changes."""

    def __init__(self, look: RuleContext) -> None:
        own = [node.run for of, node in look.task.runs if of is look.module and _is_local(node)]
        local = _indexed_positions(own, [look.module], local=True)
        self._runs = [*look.task.once(_shared_positions), *local]

    def one(self, value: s.Expression, look: RuleContext, routine: s.Routine) -> Point:
        """Return the position of an expression, empty if it is unknown."""
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
                # Columns hold ASCII names only.
                if numbers is not None and not item.dimensions and item.name.isascii():
                    names.append(item.name)
                    values.append(numbers)
    known = [*runs]
    if names:
        known.append(TargetRun(Names.of(names), np.array(values, dtype=np.float64)))
    return [(run, NameIndex(run.names)) for run in known]
