r"""SearchL and SearchC: motions that look for a signal or a persistent truth.

Reference manual of instructions, SearchL: without a switch the positive edge is looked for, and a
signal that is active before the search ends it with ERR_SIGSUPSEARCH; `\HighLevel` and `\LowLevel`
also find what is so at its start. Nothing found, or more than once with `\Sup`, is ERR_WHLSEARCH.
The arm stops where it is: how far it comes while it brakes is not simulated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.breaking import move_until, watched_move
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.ends import Fault
from assistant.virtual.rapid.expressions import signal
from assistant.virtual.rapid.functions.positions import present_target
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function
from assistant.virtual.rapid.poses import truth

STOP_SWITCHES: Final = ("stop", "pstop", "sstop")
EDGE_SWITCHES: Final = ("flanks", "posflank", "negflank", "highlevel", "lowlevel")
SEARCH_OPTIONS: Final = " ".join((*STOP_SWITCHES, "sup", *EDGE_SWITCHES, "wobj tload id v t"))
_FINE_ZONE: Final = s.NameRef("fine")


def _search(move: Callable[[Given], None]) -> Callable[[Given], None]:
    """A motion that looks; move: the same without."""

    def does(given: Given) -> None:
        node, _, *targets, speed, tool = given.required
        place = given.place(1)
        flank = next((one for one in EDGE_SWITCHES if given.has(one)), "")
        options = {name: x for name, x in given.options.items() if name in ("wobj", "v", "t")}
        plain = Given(given.machine, [*targets, speed, _FINE_ZONE, tool], options)
        asks = _SearchWatch(_search_condition(given, node), flank)
        if not flank and asks.last:
            raise Fault("a search whose signal is active at its start", "ERR_SIGSUPSEARCH")
        seen = {"tool": tool} | {x: node for x, node in options.items() if x == "wobj"}
        here = partial(present_target, Given(given.machine, [], seen))
        hits = 0
        if any(map(given.has, STOP_SWITCHES)):
            if move_until(given.machine.task, asks.hit, lambda: move(plain)):
                hits = 1
                _is_level(given)
                place.set(here())
        else:

            def look() -> None:
                nonlocal hits
                if asks.hit():
                    hits += 1
                    if hits == 1:
                        place.set(here())

            look()
            watched_move(given.machine.task, look, lambda: move(plain))
        if not hits or (hits > 1 and given.has("sup")):
            found = "nothing is found" if not hits else "more than one place is found"
            raise Fault(f"a search in which {found}", "ERR_WHLSEARCH")

    return does


def _search_condition(given: Given, node: s.Expression) -> Callable[[], bool]:
    """Whether what is looked for is active now: a signal, or a persistent truth."""
    machine = given.machine
    found = machine.meaning(node.name) if isinstance(node, s.NameRef) else None
    if found is not None and given.place(0).storage == "PERS":
        return lambda: truth(given.value(0))
    name = signal(machine, node)
    return lambda: machine.signals.read(name) != 0.0


class _SearchWatch:
    """last: what was seen last."""

    def __init__(self, active: Callable[[], bool], flank: str) -> None:
        self.active, self.flank, self.last = active, flank or "posflank", active()

    def hit(self) -> bool:
        now, before = self.active(), self.last
        self.last = now
        match self.flank:
            case "highlevel":
                return now
            case "lowlevel":
                return not now
            case "flanks":
                return now is not before
            case "negflank":
                return before and not now
        return now and not before


def _is_level(given: Given) -> None:
    """The arm is where it was stopped."""
    arm, standing = given.machine.arm, given.machine.task.kernel.motion.where()
    if standing is not None:
        arm.flange, arm.joints = standing[0], standing[1][:6]


SEARCH_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("SearchL", 5, _search(motion.move_linear), SEARCH_OPTIONS),
        table_row("SearchC", 6, _search(motion.move_circular), SEARCH_OPTIONS),
    )
)
