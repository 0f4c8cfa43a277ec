"""Rules of timing: what runs before the robot is there, and waits without an end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final, Literal

from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tables.words import ZONES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import blocks, nodes
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]
Going = Literal["on the fly", "aside", ""]
"""How the move before goes on: through its corner, beside the program, or it has ended."""

MOVES: Final = {
    **dict.fromkeys(("movej", "movel", "movec", "moveabsj", "triggj", "triggl", "triggc"), -2),
    **dict.fromkeys(("movejdo", "moveldo", "movecdo"), -4),
}
"""Instructions of motion, with where among their plain arguments the zone stands."""
SETS: Final = frozenset(("set", "reset", "setdo", "setgo", "setao", "pulsedo", "invertdo"))
HERE: Final = frozenset(("crobt", "cpos", "cjointt"))
"""Functions that tell where the robot is now; it should stand still for them."""
WAITS: Final = frozenset(
    ("waituntil", *(f"wait{kind}" for kind in ("di", "do", "gi", "go", "ai", "ao")))
)
KEEPS: Final = frozenset(
    (
        *("tpwrite", "tperase", "incr", "decr", "add", "clear", "clkstart", "clkreset", "clkstop"),
        *("triggio", "triggequip"),
    )
)
"""Instructions that take no time: a move goes on through them."""


def endless_waits(look: Look) -> Found:
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in WAITS:
            given = {a.name.lower() for a in call.arguments if not isinstance(a, s.Positional)}
            plain = [a.value for a in call.arguments if isinstance(a, s.Positional)]
            if "maxtime" not in given and plain != [s.BoolLiteral(True)]:
                yield look.finding(rules.ENDLESS_WAIT, call, word=call.name)


def on_the_fly(look: Look) -> Found:
    """Signals that are set, and positions that are read, before a move has ended."""
    for routine in look.routines:
        for body in (routine.body, *(h.body for h in routine.handlers)):
            yield from _followed(look, routine, body, "")


def _followed(
    look: Look, routine: s.Routine, body: Sequence[s.StatementNode], going: Going
) -> Found:
    for statement in body:
        if going and isinstance(statement, s.Assignment | s.ProcedureCall) and _reads(statement):
            yield look.finding(rules.READ_ON_THE_FLY, statement)
        match statement:
            case s.MoveRunNode(run):
                going = _through(look, run.motions[-1].zone, routine)
            case s.ProcedureCall(str(name)) if name.lower() in MOVES:
                going = _of_move(look, statement, name.lower(), routine)
            case s.ProcedureCall(str(name)) if name.lower() in SETS:
                if going:
                    yield look.finding(rules.ON_THE_FLY, statement, word=name)
            case s.ProcedureCall(str(name)) if name.lower() in KEEPS:
                pass
            case s.Assignment() | s.CommentLine() | s.Placeholder():
                pass
            case _:
                for block in blocks(statement):
                    yield from _followed(look, routine, block, going)
                going = ""


def _reads(statement: s.Assignment | s.ProcedureCall) -> bool:
    """Whether a statement asks where the robot is."""
    return any(
        isinstance(node, s.FunctionCall) and node.name.lower() in HERE for node in nodes(statement)
    )


def _of_move(look: Look, call: s.ProcedureCall, name: str, routine: s.Routine) -> Going:
    if any(isinstance(a, s.Option) and a.name.lower() == "conc" for a in call.arguments):
        return "aside"
    if any(isinstance(a, s.Option) and a.name.lower() in ("z", "inpos") for a in call.arguments):
        return ""
    plain = [a.value for a in call.arguments if isinstance(a, s.Positional)]
    zone = plain[MOVES[name]] if len(plain) >= -MOVES[name] else None
    return _through(look, zone.name, routine) if isinstance(zone, s.NameRef) else ""


def _through(look: Look, zone: str, routine: s.Routine) -> Going:
    """`on the fly` for a zone that surely has a size."""
    found = look.find(zone, routine)
    if found is None:
        return "on the fly" if zone.lower() in ZONES and zone.lower() != "fine" else ""
    value = found.node.value if isinstance(found.node, s.Data) else None
    rounded = isinstance(value, s.AggregateNode) and value.items[0] == s.BoolLiteral(False)
    return "on the fly" if rounded and found.kind == "CONST" else ""
