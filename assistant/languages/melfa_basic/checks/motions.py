"""Rules and findings on moves, and on interrupts, communication lines and slots.

The rules find positions that were never taught, changes of the structure flag on a linear move,
arcs whose points define no arc, corners that remain rounded at a stop, programs without a tool, and
more pulses at a time than a controller runs. Distances are in mm.
"""

from __future__ import annotations

from typing import Any, Final, Literal

import numpy as np

from assistant.base.arrays import Floats, Ints, Truths
from assistant.base.diagnostics import Rule, Span, error, info, warning
from assistant.languages.checks.moves import Follower, Moves
from assistant.languages.checks.registry import Found, like_it
from assistant.languages.melfa_basic.checks import values
from assistant.languages.melfa_basic.checks.file_view import Look, known_variables
from assistant.languages.melfa_basic.tables.variables import MOST_PULSES
from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MOV, MVR, MoveRows
from assistant.languages.melfa_basic.tree.control_flow import is_block_word
from assistant.languages.melfa_basic.tree.line_tables import NO_FLAGS, Positions
from assistant.languages.melfa_basic.tree.walk import lines_with, literal
from assistant.program.geometry import ArcMeasures

_NEVER_TAUGHT: Final = warning(
    "MB701",
    "the robot is moved to `{name}`, which was never taught: {what}{more}",
    "teach it, or assign it before the move",
)
_FLAGS: Final = error(
    "MB702",
    "`{word}` leads from the flag {before} to {after} of `{name}`{more} (controller error 2810)",
    "use `Mov`, teach both with one posture, or write `Type 0,1` behind the move",
)
_ARC_STRAIGHT: Final = warning(
    "MB703",
    "{what}: the controller moves straight to the end{more}",
    "use `Mvs`, or put the second point beside the line",
)
_ARC_START: Final = info(
    "MB704",
    "the arc starts at `{name}`, {distance:.1f} mm from where the move before ends{more}",
    "let the arc start where the robot is; it moves straight to the start first",
)
_FULL_CIRCLE: Final = warning(
    "MB705",
    "`Mvc` drives a full circle back to `{start}`, but the next move starts at `{name}`",
    "write `Mvr` for an arc that ends at its third point",
)
_CNT_LEFT: Final = info(
    "MB706",
    "`Cnt 1` is on, so `{word}` may run before the move in front of it has ended",
    "write `Cnt 0` in front of that move",
)
NO_GETM: Final = error(
    "MB707",
    "`{name}` runs in slot {slot} and moves the robot without `GetM` (controller error 3280)",
    "write `RelM` in the program of slot 1, and `GetM 1` in front of the first move of `{name}`",
)
NO_ACT: Final = warning(
    "MB708",
    "the interrupt {number} is switched, but no `Def Act {number}` defines it",
    "define it first, or correct its number",
)
ACT_OFF: Final = warning(
    "MB709", "the interrupt {number} is defined, but never switched on", "write `Act {number}=1`"
)
_NO_TOOL: Final = info(
    "MB710",
    "the program moves with the tool that was set last: nothing here sets one",
    "write `Tool` with a position, or `Tool P_NTool`, in front of the first move",
)
NOT_OPENED: Final = warning(
    "MB711",
    "`{word} #{number}` uses a file that nothing here opens",
    "write `Open … As #{number}` in front",
)
NOT_CLOSED: Final = info(
    "MB712",
    "the file {number} is opened, but never closed",
    "write `Close #{number}`; only `End` of the main program closes it otherwise",
)
OPENED_TWICE: Final = warning(
    "MB713",
    "the file {number} is opened again while it is open (controller error 3130)",
    "close it first, or use another number",
)


_SAME_POINT: Final = 0.05
"""mm: points that are nearer to each other are the same one."""
_STRAIGHT_ARC: Final = 0.01
"""mm: how far the second point of an arc must at least be beside the line of the others."""


def _moves_of_file(look: Look) -> Moves[s.Entry] | None:
    """Worked out once for a file."""
    positions = look.once(_known_positions)
    changed = _changed_positions(look)
    found: Follower[s.Entry] = Follower()
    follows = False
    for item in look.code:
        if isinstance(item, MoveRows):
            _follow_table(found, item, positions, changed, follows=follows)
            follows = True
            continue
        # The line may be reached from elsewhere, so where the robot is before it is not known.
        if item.label is not None:
            follows = False
        if isinstance(item.statement, s.Motion):
            _follow_line(found, item, item.statement, positions, changed, follows=follows)
            # An appended `Skip` may end the move anywhere.
            follows = item.statement.append is None
        elif not _is_harmless(item.statement):
            follows = False
    return found.moves()


def _known_positions(look: Look) -> Positions:
    return Positions(look.tree)


def _changed_positions(look: Look) -> set[str]:
    """Positions that the program gives a value while it runs."""
    return {use.variable.key for _, use in look.uses if use.role in ("written", "either")}


_HARMLESS_STATEMENTS: Final = (
    s.Print,
    s.Open,
    s.Close,
    s.DefNames,
    s.Dim,
    s.DefOther,
    s.DefIo,
    s.Const,
)
"""Statements after which the robot is where it was, beside commands that say so."""


def _is_harmless(statement: s.Statement | None) -> bool:
    match statement:
        case None:
            return True
        case s.Command(keyword=keyword):
            return keyword in commands("stays")
        case s.Assign():
            return True
    return isinstance(statement, _HARMLESS_STATEMENTS)


def _follow_table(
    found: Follower[s.Entry],
    rows: MoveRows,
    positions: Positions,
    changed: set[str],
    *,
    follows: bool,
) -> None:
    stem = rows.stem.upper()
    # Positions that the program changes have no known value, whatever the file lists.
    digits = (name.removeprefix(stem) for name in changed if name.startswith(stem))
    moved = [int(number) for number in digits if number.isdigit()]

    def known(numbers: Ints) -> tuple[Floats, Ints]:
        values, flags, there = positions.find(stem, numbers)
        there = there & ~np.isin(numbers, moved) if moved else there
        points = np.where(there[:, None], values[:, :3], np.nan)
        return points, np.where(there, flags[:, 0], NO_FLAGS)

    (ends, flags), (vias, _), (starts, _) = map(known, (rows.end, rows.via, rows.start))
    found.table(rows, rows.kinds, ends, vias=vias, starts=starts, postures=flags, follows=follows)


def _follow_line(
    found: Follower[s.Entry],
    line: s.Line,
    motion: s.Motion,
    positions: Positions,
    changed: set[str],
    *,
    follows: bool,
) -> None:
    kind = KEYWORDS.index(motion.keyword) if motion.keyword in KEYWORDS else -1
    start = via = end = None
    if kind == MVR and len(motion.arguments) >= _ARC_POINTS:
        start, via, end = motion.arguments[:_ARC_POINTS]
    elif kind >= 0 and len(motion.arguments) == 1:
        (end,) = motion.arguments
    at = [_taught_constant(one, positions, changed) for one in (end, via, start)]
    ends, vias, starts = (one.values if one is not None else () for one in at)
    flags = at[0].flags if at[0] is not None else None
    second = literal(motion.type[1]) if motion.type else None
    found.line(
        line,
        kind,
        follows=follows,
        end=ends,
        via=vias,
        start=starts,
        posture=NO_FLAGS if flags is None or flags[0] is None else flags[0],
        turning=second in (1, 2),
    )


_ARC_POINTS: Final = 3


def _taught_constant(
    expression: s.Expression | None, positions: Positions, changed: set[str]
) -> s.Constant | None:
    if isinstance(expression, s.Constant):
        return expression
    if isinstance(expression, s.Variable) and expression.arguments is None:
        plain = not expression.component and expression.key[0] == "P"
        if plain and expression.key not in changed:
            return positions.constant(expression.key)
    return None


# --------------------------------------------------------------------------------------- rules


def never_taught(look: Look) -> Found:
    """Moves to positions that are all zeros, or that were left without a value."""
    names = look.once(known_variables)
    zeros: dict[str, str] = {}
    for item in look.data:
        if isinstance(item, s.Data) and isinstance(item.value, s.Constant):
            values = [v for v in item.value.values if v is not None]
            key = item.variable.key
            if key in names.given and not _is_given_elsewhere(look, key) and values:
                if not any(values) and key[0] == "P":
                    zeros[key] = "all its values are 0"
    seen: set[str] = set()
    for line, motion in look.all(s.Motion):
        for argument in motion.arguments:
            if isinstance(argument, s.Variable) and argument.key in zeros:
                key = argument.key
                if key not in seen and argument.arguments is None and not argument.component:
                    seen.add(key)
                    name = argument.name
                    yield look.at(_NEVER_TAUGHT, line, name, name=name, what=zeros[key], more="")


def _is_given_elsewhere(look: Look, key: str) -> bool:
    return key in look.once(_changed_positions)


def flags(look: Look) -> Found:
    """Linear moves and arcs between positions of different structure flags."""
    run = look.once(_moves_of_file)
    if run is None:
        return
    # Nothing is known before the first move.
    before = np.concatenate([[NO_FLAGS], run.postures[:-1]])
    # Joint moves may change the flag, and so may moves with `Type …,1` or `Type …,2`.
    straight = (run.kinds > MOV) & run.follows & ~run.turning
    known = (before != NO_FLAGS) & (run.postures != NO_FLAGS)
    hits = straight & known & (before != run.postures)
    words = np.array(KEYWORDS)[run.kinds]
    yield from _first_hit(
        look,
        _FLAGS,
        run,
        hits,
        most=_MOST_LISTED,
        word=words,
        before=before,
        after=run.postures,
    )


_MOST_LISTED: Final = 5
"""Number of moves with one kind of mistake that are listed one by one."""


def _first_hit(
    look: Look,
    rule: Rule,
    run: Moves[s.Entry],
    hits: Truths,
    point: Literal["start", "end"] = "end",
    most: int = 1,
    **words: Any,
) -> Found:
    """The rule's finding at the first of some moves (n,). words: a column (n,), or one for all."""
    rows = np.flatnonzero(hits).tolist()
    for count, at in enumerate(rows[:most], 1):
        name, where = _named_position(look, run.items[run.item[at]], int(run.row[at]), point)
        said = {key: v[at] if isinstance(v, np.ndarray) else v for key, v in words.items()}
        more = like_it(len(rows) - most if count == most else 0)
        yield look.finding(rule, where, name=name, more=more, **said)


def _named_position(
    look: Look, item: s.Entry, row: int, point: Literal["start", "end"]
) -> tuple[str, s.Item | Span | None]:
    """The name of a position that a move starts or ends at, and where it stands."""
    if isinstance(item, MoveRows):
        name = f"{item.stem}{int(getattr(item, point)[row])}"
        return name, look.row(item, row, name, last=point == "end")
    motion = item.statement
    arguments = motion.arguments if isinstance(motion, s.Motion) else (None,)
    variable = arguments[-1 if point == "end" else 0]
    if isinstance(variable, s.Variable):
        return variable.name, look.place(item, variable) or item
    return f"the {point}", item


def arcs(look: Look) -> Found:
    """Report arcs whose points define no arc, and arcs that start away from the robot's
    position.
    """
    run = look.once(_moves_of_file)
    if run is None or not (run.kinds == MVR).any():
        return
    arc = run.kinds == MVR
    measures = ArcMeasures.through(np.stack([run.starts, run.vias, run.ends], axis=1))
    near = (measures.sides < _SAME_POINT).any(axis=1)
    # The height of the second point above the line; the minimum avoids a division by zero.
    beside = measures.area / np.maximum(measures.sides[:, 2], _SAME_POINT)
    for hits, what in (
        (arc & near, "two points of the arc are the same"),
        (arc & ~near & (beside < _STRAIGHT_ARC), "the points of the arc lie in a line"),
    ):
        yield from _first_hit(look, _ARC_STRAIGHT, run, hits, what=what)
    gap = np.linalg.norm(run.starts - run.before, axis=1)
    yield from _first_hit(look, _ARC_START, run, arc & (gap > _SAME_POINT), "start", distance=gap)


def circles(look: Look) -> Found:
    """Mvc where an arc is meant: the next move starts at its third point."""
    last: tuple[s.Line, s.Motion] | None = None
    for line, motion in lines_with(look.code, s.Motion):
        if last is not None and len(motion.arguments) >= _ARC_POINTS:
            start, third = last[1].arguments[0], last[1].arguments[-1]
            follows = motion.arguments[0] == third and third != start
            if follows and isinstance(third, s.Variable) and isinstance(start, s.Variable):
                yield look.at(_FULL_CIRCLE, last[0], "Mvc", start=start.name, name=third.name)
        full = motion.keyword == "Mvc" and len(motion.arguments) >= _ARC_POINTS
        last = (line, motion) if full else None


_STOPPING_COMMANDS: Final = frozenset({"Hlt", "End", "Dly", "HOpen", "HClose"})
_WAITING_COMMANDS: Final = frozenset({"Wait"})


def corners_at_stops(look: Look) -> Found:
    """Corners that are left on where the program stops or waits behind a move."""
    rounded: bool | None = False
    moved = False
    for item in look.code:
        if isinstance(item, MoveRows):
            moved = True
            continue
        statement = item.statement
        # The line may be reached with another `Cnt`.
        if item.label is not None or is_block_word(statement):
            rounded, moved = None, False
        match statement:
            case s.Motion():
                moved = statement.append is None
            case s.Command("Cnt", arguments):
                value = literal(arguments[0]) if arguments else None
                rounded = None if value is None else value != 0
                moved = False
            case s.Command(keyword=word) if word in _STOPPING_COMMANDS or word in _WAITING_COMMANDS:
                if rounded and moved:
                    yield look.at(_CNT_LEFT, item, word, word=word)
                moved = False
                # `End` switches corners off.
                if word == "End":
                    rounded = False
            case s.Jump() | s.CallP() | s.Call() | s.OnJump():
                rounded, moved = None, False


def missing_tool(look: Look) -> Found:
    """Programs that move and set no tool."""
    if look.compiled or look.once(_sets_tool):
        return
    for item in look.code:
        if isinstance(item, MoveRows):
            word = KEYWORDS[int(item.kinds[0])]
            yield look.finding(_NO_TOOL, look.row(item, 0, word))
            return
        if isinstance(item.statement, s.Motion):
            yield look.at(_NO_TOOL, item, item.statement.keyword)
            return


def _sets_tool(look: Look) -> bool:
    return any(
        command.keyword == "Tool"
        for tree in look.calls.trees
        for _, command in lines_with(tree.items, s.Command)
    ) or any(use.variable.key == "M_TOOL" and use.role == "written" for _, use in look.uses)


def pulses_at_a_time(look: Look) -> Found:
    """More pulses in a row than run beside each other, with nothing between that takes time."""
    count = 0
    for item in look.code:
        statement = item.statement
        other = statement is not None and not isinstance(statement, s.Assign)
        if other or isinstance(item, MoveRows) or item.label is not None:
            count = 0
        if isinstance(statement, s.Assign) and statement.delay is not None:
            count += 1
            if count == MOST_PULSES + 1:
                yield look.finding(values.MANY_PULSES, item, most=MOST_PULSES)
