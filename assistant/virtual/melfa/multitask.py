"""Statements about slots: XRun, XStp, XRst, XClr, XLoad, GetM, RelM, Priority.

Facts: COSIROP help on each of them; lists of errors for their numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final, Literal

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions
from assistant.virtual.melfa.slots import Slot
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import text

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine

MODES: Final[Mapping[int, Literal["REP", "CYC"]]] = {0: "REP", 1: "CYC"}
MOST_LINES: Final = 31


def _own(m: Machine) -> Slot:
    if m.world.slot is None:
        raise Unknown("slots of a program that runs without a controller")
    return m.world.slot


def _slot(m: Machine, node: s.Expression) -> Slot:
    """The slot that a statement about another program names."""
    own = _own(m)
    if own.condition == "ALWAYS" and not own.controller.always_may:
        raise Unknown("what a program that always runs does to others where ALWENA is not 7")
    return own.controller.slot(expressions.integer(m, node, "the slot"))


def _load(m: Machine, slot: s.Expression, program: s.Expression) -> None:
    _slot(m, slot).load(text(expressions.value(m, program), "the name of a program"))


def _run(
    m: Machine, node: s.Expression, program: s.Expression | None = None, *more: s.Expression | None
) -> None:
    slot = _slot(m, node)
    if slot.state == "runs":
        raise Failed(3310, f"slot {slot.number} runs")
    if program is not None:
        name = text(expressions.value(m, program), "the name of a program")
        if slot.state == "reset":
            slot.load(name)
        elif name.upper() != slot.program:
            raise Unknown("XRun of another program than the one that was stopped")
    if more and more[0] is not None:
        mode = expressions.integer(m, more[0], "the operation mode")
        if mode not in MODES:
            raise out_of_range(f"the operation mode {mode}")
        slot.mode = MODES[mode]
    slot.run()


def _stop(m: Machine, node: s.Expression) -> None:
    slot = _slot(m, node)
    if not slot.program:
        raise Failed(3330, f"slot {slot.number} has no program")
    slot.stop()


def _reset(m: Machine, node: s.Expression) -> None:
    slot = _slot(m, node)
    if not slot.program:
        raise Failed(3340, f"slot {slot.number} has no program")
    slot.reset()


def _get(m: Machine, node: s.Expression) -> None:
    slot = _own(m)
    slot.controller.get(slot, expressions.integer(m, node, "the mechanism"))


def _release(m: Machine) -> None:
    slot = _own(m)
    if slot.condition == "ALWAYS" or not slot.controller.release(slot):
        raise Unknown("RelM without a mechanism")


def _rank(m: Machine, lines: s.Expression, *node: s.Expression) -> None:
    count = expressions.integer(m, lines, "the lines of a turn")
    if not 1 <= count <= MOST_LINES:
        raise out_of_range(f"a turn of {count} lines")
    slot = _own(m)
    if node:
        slot = slot.controller.slot(expressions.integer(m, node[0], "the slot"))
        if not slot.program:
            raise Failed(None, f"slot {slot.number} has no program")
    slot.rank(count)


WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "XLOAD": _load,
    "XRUN": _run,
    "XSTP": _stop,
    "XRST": _reset,
    "XCLR": lambda m, node: _slot(m, node).clear(),
    "GETM": _get,
    "RELM": _release,
    "PRIORITY": _rank,
}
