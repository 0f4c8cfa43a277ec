r"""Searches of RAPID, as moves that are broken off.

`SearchL \SStop,di,found,end,v50,tool;` moves until the signal comes, and tells where the tool was.
Elsewhere a move ends as soon as a condition holds, and what asks for the place reads it there. What
is wrong is told by error numbers: no signal on the whole way, or one before it.

Reference manual of instructions: SearchL, SearchC.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.instructions import NameResolver, lift_call
from assistant.languages.rapid.lift.told.calls import instruction_of
from assistant.languages.rapid.lift.told.handlers import exit_word
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, Signal
from assistant.program.rewriting import Body, map_bodies

SIGNAL_MISSED: Final = "err_whlsearch"
SIGNAL_EARLY: Final = "err_sigsupsearch"
SEARCH_MOVES: Final = {"searchl": "MoveL", "searchc": "MoveC"}
STOP_OPTIONS: Final = ("stop", "pstop", "sstop")
FLANK_OPTIONS: Final = ("flanks", "posflank", "negflank", "highlevel", "lowlevel")
PATH_INSTRUCTIONS: Final = frozenset(
    ("STOREPATH", "RESTOPATH", "CLEARPATH", "STOPMOVE", "STARTMOVE")
)
"""What handlers of these errors do about the way of the search, of which nothing is left here."""
POSITION_LOSS: Final = (
    "it is read where the arm has stopped, a little behind the place where the signal changed",
    "search so slowly that this does not matter",
)
PAUSE_LOSS: Final = (
    "where the signal has to change twice, the arm stops for a moment at the first change",
    "begin the search where the signal is as it is before the flank",
)
_FINE: Final = s.NameRef("fine")
_IS_FOUND: Final = e.Binary("=", e.Apply("broken_off"), e.Number(1))


def is_search(node: p.Statement) -> bool:
    """Whether a statement is the text of a search."""
    if not isinstance(node, p.Opaque) or node.text[:6].lower() != "search":
        return False
    call = instruction_of(node)
    return call is not None and str(call.name).lower() in SEARCH_MOVES


@dataclass(frozen=True, slots=True)
class Search:
    """move: to the end of the way. active: when what is looked for is there. flank: its switch in
    lower case, empty without one. place: takes the place where it is found.
    """

    move: p.Move | p.MoveCircular
    active: Callable[[bool], e.Expression]
    value: e.Expression
    flank: str
    place: e.Expression

    @property
    def errors(self) -> tuple[str, ...]:
        """What may go wrong."""
        return (SIGNAL_MISSED,) if self.flank else (SIGNAL_EARLY, SIGNAL_MISSED)

    @property
    def losses(self) -> Iterator[tuple[str, tuple[str, str]]]:
        """What is not said, with what that means and what to do."""
        yield "the very place of the search", POSITION_LOSS
        if self.flank in ("posflank", "negflank"):
            yield rf"\{self.flank} on the way", PAUSE_LOSS

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
                yield p.If((p.Branch(self.active(True), fails(SIGNAL_EARLY)),), act)
                return
            case "highlevel" | "lowlevel" as level:
                yield self.until(level == "highlevel")
            case "flanks":
                before = seen()
                yield p.Assign(before, self.value)
                yield replace(self.move, until=e.Binary("<>", self.value, before))
            case flank:
                yield self.until(flank == "negflank")
                yield p.If((p.Branch(_IS_FOUND, (self.until(flank == "posflank"),)),))
        yield missed

    def until(self, active: bool) -> p.Statement:
        return replace(self.move, until=self.active(active))


def without_path_recovery(body: Body) -> Body:
    """What a handler does about a search, without what it does about the rest of its way."""
    left = (node for node in body if exit_word(node) not in PATH_INSTRUCTIONS)
    return tuple(map_bodies(node, without_path_recovery) for node in left)


def search_of(node: p.Statement, program: Program, meaning: NameResolver) -> Search | None:
    """The search that a text says; None for one that does not stop where it finds, and others."""
    call = instruction_of(node) if isinstance(node, p.Opaque) else None
    found = None if call is None else called(call)
    given = [] if found is None else [one for one in found.given if one is not None]
    if found is None or found.word.lower() not in SEARCH_MOVES or len(given) < len(found.given):
        return None
    options = dict(found.options)
    stops = [options.pop(one, None) is None for one in STOP_OPTIONS if one in options]
    flanks = [one for one in FLANK_OPTIONS if one in options]
    for one in flanks:
        del options[one]
    match given:
        case (s.NameRef(name) as asked, place, *targets, speed, tool) if (
            len(stops) == 1 and len(flanks) <= 1 and targets
        ):
            ends: list[s.Expression] = [*targets, speed, _FINE, tool]
            way: Called[s.Expression] = Called(SEARCH_MOVES[found.word.lower()], ends, options)
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
    """What says that a signal or a persistent truth is active, or that it is not."""
    if any(name.lower() == one.lower() for one in program.variables):
        return lambda active: value if active else e.Unary("not", value)
    meaning.used.append((name, Signal("digital", "input")))
    return lambda active: e.Binary("=", value, e.Number(int(active)))
