"""What an arm carries while it runs a program, told to whoever wants to know of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

from assistant.program.statements import Follow, Gripper, Moving, SetSignal, Statement
from assistant.robots.timing.pieces import Segment
from assistant.robots.timing.state import JointValues, State

if TYPE_CHECKING:
    from assistant.robots.timing.values import Values


class Carried(Protocol):
    """What an arm carries, as far as is known; equal where it is alike."""

    def switched(self, name: str, value: float | None, joints: JointValues | None) -> Carried:
        """The same after an output, or `hand 1` (1 for closed), is set where the arm stands.

        value, joints: None for what is not known.
        """

    def met(self, other: Carried) -> Carried:
        """Where two ways of a program meet."""


def with_carried(
    statement: Statement, state: State, waiting: Sequence[Segment], values: Values
) -> State:
    """The state after a statement, with what the arm carries then.

    What a move sets on its way counts from its end on, a pulse as if it stayed.
    """
    carried = state.carried
    assert carried is not None
    joints: JointValues | None = None
    if waiting:
        joints = tuple(waiting[-1].moves.joints[-1].tolist())
    elif len(state.places) == 1:
        joints = state.places[0]
    for name, value in _switches(statement, values):
        carried = carried.switched(name, value, joints)
    return state if carried == state.carried else replace(state, carried=carried)


def _switches(statement: Statement, values: Values) -> Iterator[tuple[str, float | None]]:
    match statement:
        case SetSignal(signal=signal, value=value):
            settings = [(signal, value)]
        case Gripper(action=action, hand=hand):
            yield f"hand {hand}", float(action == "close")
            return
        case Follow():
            return
        case _ if isinstance(statement, Moving):
            settings = [(trigger.signal, trigger.value) for trigger in statement.triggers]
        case _:
            return
    for signal, value in settings:
        number = values.number(value)
        if number is None and (truth := values.truth(value)) is not None:
            number = float(truth)
        yield signal, number
