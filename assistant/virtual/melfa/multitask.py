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

RUN_MODES: Final[Mapping[int, Literal["REP", "CYC"]]] = {0: "REP", 1: "CYC"}
MOST_LINES: Final = 31


def _own_slot(m: Machine) -> Slot:
    if m.world.slot is None:
        raise Unknown("slots of a program that runs without a controller")
    return m.world.slot


def _slot_of(m: Machine, node: s.Expression) -> Slot:
    """The slot that a statement about another program names."""
    own = _own_slot(m)
    if own.condition == "ALWAYS" and not own.controller.always_may:
        raise Unknown("what a program that always runs does to others where ALWENA is not 7")
    return own.controller.slot(expressions.integer(m, node, "the slot"))


def _load_slot(m: Machine, slot: s.Expression, program: s.Expression) -> None:
    _slot_of(m, slot).load(text(expressions.value(m, program), "the name of a program"))


def _run_slot(
    m: Machine, node: s.Expression, program: s.Expression | None = None, *more: s.Expression | None
) -> None:
    slot = _slot_of(m, node)
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
        if mode not in RUN_MODES:
            raise out_of_range(f"the operation mode {mode}")
        slot.mode = RUN_MODES[mode]
    slot.run()


def _stop_slot(m: Machine, node: s.Expression) -> None:
    slot = _slot_of(m, node)
    if not slot.program:
        raise Failed(3330, f"slot {slot.number} has no program")
    slot.stop()


def _reset_slot(m: Machine, node: s.Expression) -> None:
    slot = _slot_of(m, node)
    if not slot.program:
        raise Failed(3340, f"slot {slot.number} has no program")
    slot.reset()


def _get_mechanism(m: Machine, node: s.Expression) -> None:
    slot = _own_slot(m)
    slot.controller.get(slot, expressions.integer(m, node, "the mechanism"))


def _release_mechanism(m: Machine) -> None:
    slot = _own_slot(m)
    if slot.condition == "ALWAYS" or not slot.controller.release(slot):
        raise Unknown("RelM without a mechanism")


def _set_priority(m: Machine, lines: s.Expression, *node: s.Expression) -> None:
    count = expressions.integer(m, lines, "the lines of a turn")
    if not 1 <= count <= MOST_LINES:
        raise out_of_range(f"a turn of {count} lines")
    slot = _own_slot(m)
    if node:
        slot = slot.controller.slot(expressions.integer(m, node[0], "the slot"))
        if not slot.program:
            raise Failed(None, f"slot {slot.number} has no program")
    slot.rank(count)


SLOT_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "XLOAD": _load_slot,
    "XRUN": _run_slot,
    "XSTP": _stop_slot,
    "XRST": _reset_slot,
    "XCLR": lambda m, node: _slot_of(m, node).clear(),
    "GETM": _get_mechanism,
    "RELM": _release_mechanism,
    "PRIORITY": _set_priority,
}
