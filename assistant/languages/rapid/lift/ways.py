"""What kept texts of RAPID do to what holds along the ways through a program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program.analysis.motion_state import MotionStep

STANDSTILL_WAITS: Final = {
    ("waitrob", "inpos"), ("waitrob", "zerospeed"), ("waittime", "inpos"), ("waituntil", "inpos")
}  # fmt: skip
"""Instructions behind which the robot stands at its target, with their options (RAPID manual)."""


def vendor_steps(text: str) -> Sequence[MotionStep] | None:
    """None for what is no list of statements: an error handler, for one, which may move."""
    read = verbatim.understood(verbatim.statements, text)
    return None if read is None else [_vendor_step(node) for node in read]


def _vendor_step(node: s.StatementNode) -> MotionStep:
    """`ConfL` without an option watches configurations (RAPID reference manual)."""
    match node:
        case s.Data():
            return MotionStep.NOTHING
        case s.ProcedureCall(str(name), arguments):
            given = option_names(arguments)
            if name.lower() == "confl":
                return MotionStep.OPENS if "off" in given else MotionStep.WATCHES
            if any((name.lower(), one) in STANDSTILL_WAITS for one in given):
                return MotionStep.STOPS
            known = signature(name)
            if known is None:
                return MotionStep.CALLS
            slots = () if known.open else known.slots
            tools = any(q.type == "tooldata" for slot in slots for q in slot.alternatives)
            return MotionStep.MOVES if known.open or tools else MotionStep.NOTHING
    return MotionStep.CALLS


def option_names(arguments: Iterable[s.Argument]) -> list[str]:
    """Names of the options among arguments, in lower case."""
    return [one.name.lower() for one in arguments if isinstance(one, s.Option)]
