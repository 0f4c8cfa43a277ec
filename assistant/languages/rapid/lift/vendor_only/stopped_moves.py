"""Moves that a search breaks off, and moves that `StopMove` holds.

`SearchL` with a stop option moves until the signal comes, and gives the position of the tool then.
Other languages get a move that ends once a condition holds, and a read of the position. A fault is
an error number: no signal on the complete path, or one before it. Moves that are held and released
(`StopMove`, `StartMove`) with no motion between are left as they are, without both instructions.
Reference manual of instructions: SearchL, SearchC.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_only.error_handlers import exit_word
from assistant.languages.rapid.lift.vendor_only.omissions import OMITTED_INSTRUCTIONS
from assistant.languages.rapid.lift.vendor_statements import instruction_of, word_of
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Signal, walk
from assistant.program.rewriting import Body, map_bodies, map_head, records
from assistant.program.vendor_statements import effect_of

SIGNAL_MISSED: Final = "err_whlsearch"
SIGNAL_EARLY: Final = "err_sigsupsearch"
_SEARCH_MOVES: Final = {"searchl": "MoveL", "searchc": "MoveC"}
_STOP_OPTIONS: Final = ("stop", "pstop", "sstop")
_FLANK_OPTIONS: Final = ("flanks", "posflank", "negflank", "highlevel", "lowlevel")
_PATH_INSTRUCTIONS: Final = frozenset(
    ("STOREPATH", "RESTOPATH", "CLEARPATH", "STOPMOVE", "STARTMOVE")
)
"""Instructions in the handlers of these errors for the path of the search, which is not
translated.
"""
_POSITION_LOSS: Final = (
    "it is read where the arm has stopped, a little behind the place where the signal changed",
    "search so slowly that this does not matter",
)
_PAUSE_LOSS: Final = (
    "where the signal has to change twice, the arm stops for a moment at the first change",
    "begin the search where the signal is as it is before the flank",
)
_FINE: Final = s.NameRef("fine")
_IS_FOUND: Final = e.Binary("=", e.Apply("broken_off"), e.Number(1))


def is_search(node: p.Statement) -> bool:
    """True if a statement is a search in vendor text."""
    # Looking at the first letters spares the parse of most texts.
    if not isinstance(node, p.Opaque) or node.text[:6].lower() != "search":
        return False
    call = instruction_of(node)
    return call is not None and str(call.name).lower() in _SEARCH_MOVES


@dataclass(frozen=True, slots=True)
class Search:
    """A search move. move: to the end of the path. active: the condition that the searched signal
    is active. flank: its switch in lower case, empty without one. place: receives the position
    where the signal is found.
    """

    move: p.Move | p.MoveCircular
    active: Callable[[bool], e.Expression]
    value: e.Expression
    flank: str
    place: e.Expression

    @property
    def errors(self) -> tuple[str, ...]:
        """Names of the errors that the search may raise."""
        return (SIGNAL_MISSED,) if self.flank else (SIGNAL_EARLY, SIGNAL_MISSED)

    @property
    def losses(self) -> Iterator[tuple[str, tuple[str, str]]]:
        """Parts of a search that are not translated, each with its effect and cure."""
        yield "the very place of the search", _POSITION_LOSS
        if self.flank in ("posflank", "negflank"):
            yield rf"\{self.flank} on the way", _PAUSE_LOSS

    def said(
        self, fails: Callable[[str], Body], seen: Callable[[], e.Name]
    ) -> Iterator[p.Statement]:
        """fails: what is done about an error. seen: a variable for what was seen before."""
        motion = self.move.motion
        found: Body = (p.Assign(self.place, e.Here(motion.tool, motion.frame)),)
        missed = p.If((p.Branch(_IS_FOUND, found),), fails(SIGNAL_MISSED))
        match self.flank:
            case "":
                act: Body = (self.until(True), missed)
                # RAPID raises an error if the signal is active before the search begins.
                yield p.If((p.Branch(self.active(True), fails(SIGNAL_EARLY)),), act)
                return
            case "highlevel" | "lowlevel" as level:
                yield self.until(level == "highlevel")
            case "flanks":
                before = seen()
                yield p.Assign(before, self.value)
                yield replace(self.move, until=e.Binary("<>", self.value, before))
            case flank:
                # A flank needs the other level first; if that holds, the first move ends where it
                # begins.
                yield self.until(flank == "negflank")
                yield p.If((p.Branch(_IS_FOUND, (self.until(flank == "posflank"),)),))
        yield missed

    def until(self, active: bool) -> p.Statement:
        return replace(self.move, until=self.active(active))


def without_path_recovery(body: Body) -> Body:
    """Return the handler of a search without its statements about the remaining path."""
    left = (node for node in body if exit_word(node) not in _PATH_INSTRUCTIONS)
    return tuple(map_bodies(node, without_path_recovery) for node in left)


def search_of(node: p.Statement, program: Program, meaning: NameResolver) -> Search | None:
    """The search that a text says; None for one that does not stop where it finds, and others."""
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    found = None if call is None else called(call)
    given = [] if found is None else [one for one in found.given if one is not None]
    if found is None or found.word.lower() not in _SEARCH_MOVES or len(given) < len(found.given):
        return None
    options = dict(found.options)
    # A stop option is a mere switch.
    stops = [options.pop(one, None) is None for one in _STOP_OPTIONS if one in options]
    flanks = [one for one in _FLANK_OPTIONS if one in options]
    for one in flanks:
        del options[one]
    match given:
        case (s.NameRef(name) as asked, place, *targets, speed, tool) if (
            len(stops) == 1 and len(flanks) <= 1 and targets
        ):
            # The search stops at its end, and `_FINE` states that for the plain move.
            ends: list[s.Expression] = [*targets, speed, _FINE, tool]
            way: Called[s.Expression] = Called(_SEARCH_MOVES[found.word.lower()], ends, options)
            move, kept = lift_call(way, meaning), meaning.expression(place)
            if isinstance(move, p.Move | p.MoveCircular) and isinstance(
                kept, e.Name | e.Member | e.Index
            ):
                flank = flanks[0] if flanks else ""
                value = meaning.expression(asked)
                return Search(move, _activity_of(value, name, program, meaning), value, flank, kept)
    return None


def _activity_of(
    value: e.Expression, name: str, program: Program, meaning: NameResolver
) -> Callable[[bool], e.Expression]:
    """Return a function for the condition that a signal or persistent bool is active, or that it is
    not.
    """
    # A persistent bool; anything else is a signal of the configuration.
    if any(name.lower() == one.lower() for one in program.variables):
        return lambda active: value if active else e.Unary("not", value)
    meaning.used.append((name, Signal("digital", "input")))
    return lambda active: e.Binary("=", value, e.Number(int(active)))


_STOP_MOVE, _START_MOVE = "stopmove", "startmove"
_IS_STOPPED: Final = re.compile(r"IsStopMoveAct\b.*", re.IGNORECASE | re.DOTALL)


def with_held_moves(program: Program, findings: Findings) -> Program:
    """The program without holding moves that are let go before the arm is to move.

    Nor does it ask whether they are held, where nothing holds them any longer.
    """

    def body(statements: Body, after: Body = ()) -> Body:
        made: list[p.Statement] = []
        for place, node in enumerate(statements):
            behind = (*statements[place + 1 :], *after)
            if _instruction_word(node) == _STOP_MOVE and _is_released(behind):
                loss, cure = OMITTED_INSTRUCTIONS[_START_MOVE]
                with findings.at(node.span):
                    findings.append(rules.LEFT_OUT(what="StopMove", loss=loss, cure=cure))
            else:
                # The statements after a loop may not run next: the body may run again first.
                inside = () if isinstance(node, p.While | p.For) else behind
                made.append(map_bodies(node, partial(body, after=inside)))
        return tuple(made)

    if any(_instruction_word(node) == _STOP_MOVE for node in program.statements()):
        procedures = (replace(q, body=body(q.body)) for q in program.procedures)
        program = replace(program, procedures=tuple(procedures))
    return (
        program
        if any(map(_holds_moves, program.statements()))
        else _with_moves_never_held(program, findings)
    )


def _holds_moves(node: p.Statement) -> bool:
    """True if a statement may hold the moves after it, judged by its text."""
    return isinstance(node, p.Opaque) and _STOP_MOVE in node.text.lower()


def _with_moves_never_held(program: Program, findings: Findings) -> Program:
    """The program in which moves are never held."""

    def answered(part: Any) -> Any:
        if isinstance(part, e.Verbatim) and _IS_STOPPED.fullmatch(part.text):
            findings.append(
                rules.LEFT_OUT(what=part.text, loss=_NEVER_HELD[0], cure=_NEVER_HELD[1])
            )
            return e.Truth(False)
        return part

    def body(statements: Body) -> Body:
        made = []
        for node in statements:
            with findings.at(node.span):
                own = map_head(node, answered)
            made.append(map_bodies(own, body))
        return tuple(made)

    if not any(
        isinstance(r, e.Verbatim) and _IS_STOPPED.fullmatch(r.text) for r in records(program)
    ):
        return program
    procedures = (replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


_NEVER_HELD: Final = (
    "it is false, as nothing here holds the moves of the arm",
    "ask for a signal if anybody else may hold it",
)


def _instruction_word(node: p.Statement) -> str:
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    return "" if call is None else word_of(call)


def _is_released(behind: Body) -> bool:
    """True if moves are released before anything can move the arm or branch."""
    for node in behind:
        if _instruction_word(node) == _START_MOVE:
            return True
        if any(map(_continues_unmoved, walk((node,)))):
            # The arm would move, or control would leave these statements, while moves are held.
            return False
    return False


def _continues_unmoved(node: p.Statement) -> bool:
    match node:
        case p.Opaque():
            effect = effect_of(node)
            return effect.moves or effect.jumps or bool(effect.calls)
        case p.Follow() | p.Call() | p.Return() | p.Goto() | p.Label() | p.Stop():
            return True
    return isinstance(node, p.MoveStatement)
