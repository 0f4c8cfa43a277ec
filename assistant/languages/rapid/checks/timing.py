"""Rules of timing: what runs before the robot is there, waits, outputs on the way of a move."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Final, Literal

from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.tables.triggers import (
    LONGEST_TRIGGER_TIME,
    TRIGGER_SETUPS,
    TRIGGER_TYPE,
)
from assistant.languages.rapid.tables.triggers import TRIGGER_MOVES as TRIGGERED
from assistant.languages.rapid.tables.words import ZONES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import name_of, option, positional
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.triggers import triggers_taken
from assistant.languages.rapid.tree.walk import blocks, nodes

MoveProgress = Literal["on the fly", "aside", ""]
"""How the move before goes on: through its corner, beside the program, or it has ended."""

ZONE_POSITIONS: Final = {
    **dict.fromkeys(("movej", "movel", "movec", "moveabsj", "triggj", "triggl", "triggc"), -2),
    **dict.fromkeys(("movejdo", "moveldo", "movecdo"), -4),
}
"""Instructions of motion, with where among their plain arguments the zone stands."""
SETTING_INSTRUCTIONS: Final = frozenset(
    ("set", "reset", "setdo", "setgo", "setao", "pulsedo", "invertdo")
)
POSITION_FUNCTIONS: Final = frozenset(("crobt", "cpos", "cjointt"))
"""Functions that tell where the robot is now; it should stand still for them."""
WAIT_INSTRUCTIONS: Final = frozenset(
    ("waituntil", *(f"wait{kind}" for kind in ("di", "do", "gi", "go", "ai", "ao")))
)
INSTANT_INSTRUCTIONS: Final = frozenset(
    (
        *("tpwrite", "tperase", "incr", "decr", "add", "clear", "clkstart", "clkreset", "clkstop"),
        *("triggio", "triggequip"),
    )
)
"""Instructions that take no time: a move goes on through them."""


def endless_waits(look: RuleContext) -> Found:
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in WAIT_INSTRUCTIONS:
            given = {a.name.lower() for a in call.arguments if not isinstance(a, s.Positional)}
            if "maxtime" not in given and positional(call) != [s.BoolLiteral(True)]:
                yield look.finding(rules.ENDLESS_WAIT, call, word=call.name)


def signals_on_the_fly(look: RuleContext) -> Found:
    """Signals that are set, and positions that are read, before a move has ended."""
    for routine in look.routines:
        for body in (routine.body, *(h.body for h in routine.handlers)):
            yield from _follow_moves(look, routine, body, "")


def _follow_moves(
    look: RuleContext, routine: s.Routine, body: Sequence[s.StatementNode], going: MoveProgress
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
                going = _progress_of_zone(look, run.motions[-1].zone, routine)
            case s.ProcedureCall(str(name)) if name.lower() in ZONE_POSITIONS:
                going = _progress_of_move(look, statement, name.lower(), routine)
            case s.ProcedureCall(str(name)) if name.lower() in SETTING_INSTRUCTIONS:
                if going:
                    yield look.finding(rules.ON_THE_FLY, statement, word=name)
            case s.ProcedureCall(str(name)) if name.lower() in INSTANT_INSTRUCTIONS:
                pass
            case s.Assignment() | s.CommentLine() | s.Placeholder():
                pass
            case _:
                for block in blocks(statement):
                    yield from _follow_moves(look, routine, block, going)
                going = ""


def _reads_position(statement: s.Assignment | s.ProcedureCall) -> bool:
    """Whether a statement asks where the robot is."""
    return any(
        isinstance(node, s.FunctionCall) and node.name.lower() in POSITION_FUNCTIONS
        for node in nodes(statement)
    )


def _progress_of_move(
    look: RuleContext, call: s.ProcedureCall, name: str, routine: s.Routine
) -> MoveProgress:
    if option(call, "conc"):
        return "aside"
    if option(call, "z", "inpos"):
        return ""
    plain = positional(call)
    zone = name_of(plain[ZONE_POSITIONS[name]]) if len(plain) >= -ZONE_POSITIONS[name] else ""
    return _progress_of_zone(look, zone, routine) if zone else ""


def _progress_of_zone(look: RuleContext, zone: str, routine: s.Routine) -> MoveProgress:
    """`on the fly` for a zone that surely has a size."""
    found = look.find(zone, routine)
    if found is None:
        return "on the fly" if zone.lower() in ZONES and zone.lower() != "fine" else ""
    value = found.node.value if isinstance(found.node, s.Data) else None
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
    return {name for name, count in named.items() if count > 0}


def long_trigger_times(look: RuleContext) -> Found:
    """Times before the end of a move that no controller looks ahead."""
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in TRIGGER_SETUPS and option(call, "time"):
            given = positional(call)
            seconds = literal_number(given[1]) if len(given) > 1 else None
            if seconds is not None and seconds > LONGEST_TRIGGER_TIME:
                yield look.finding(rules.LONG_TIME, given[1], most=LONGEST_TRIGGER_TIME)
