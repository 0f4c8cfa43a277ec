"""Outputs that moves set on their way: TriggL and its kin with the data that TriggIO sets up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.instructions import NameResolver, lift_call
from assistant.languages.rapid.tables.triggers import (
    MEASURES,
    MORE,
    MOVES,
    OUTPUTS,
    SETUPS,
    TYPE,
    Move,
    Setup,
)
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.triggers import set_up, taken
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.trigger_data import (
    Reasons,
    Told,
    TriggerData,
    TriggeredMove,
    TriggerSetUp,
)
from assistant.program.program import Declaration, Signal
from assistant.program.vendor_statements import VendorText

TRIGGER_REASONS: Final = Reasons(
    special=e.Reason(
        "what happens on the way of the move is not only that one output is given a number there",
        r"set an output by TriggIO or TriggEquip with \DOp, \GOp or \AOp and no more options",
    ),
    uncertain=e.Reason(
        "which output the move sets where depends on how the program came here",
        "set the triggdata up with plain numbers, in the statements before the move",
    ),
    move=e.Reason(
        "the move states more than its speed, zone, tool and work object",
        "leave out its other options",
    ),
)


class TriggerReader:
    """Understands kept texts. own: whether a lower-case name is that of a routine of the user's."""

    def __init__(self, meaning: NameResolver, own: Callable[[str], bool]) -> None:
        self.meaning, self.own = meaning, own

    def told(self, kept: VendorText) -> Told | None:
        """What a text is to outputs on the way of moves."""
        match _trigger_node(kept):
            case s.Data(storage=storage, type=type, name=name) as node if type.lower() == TYPE:
                plain = storage == "VAR" and node.scope != "TASK" and not node.dimensions
                inside = not isinstance(kept, Declaration)
                return TriggerData(name.lower(), plain, own=inside or node.scope == "LOCAL")
            case s.ProcedureCall(str(word)) as node if word.lower() in MOVES:
                return self._taking(MOVES[word.lower()], node)
            case s.ProcedureCall(str(word)) as node if name := set_up(node):
                return self._set_up(SETUPS[word.lower()], name, node)
        return None

    def _taking(self, known: Move, node: s.ProcedureCall) -> TriggeredMove:
        """It can be said where plain variables alone are taken."""
        call, names = called(node), tuple(one.name.lower() for one in taken(node))
        if call is None:
            return TriggeredMove(names, None)
        given = [*call.given[: known.place], *call.given[known.place + 1 :]]
        options = {name: x for name, x in call.options.items() if name not in MORE}
        plain = len(names) == 1 + len(call.options) - len(options)
        move = lift_call(Called(known.plain, given, options), self.meaning) if plain else None
        return TriggeredMove(names, move if isinstance(move, p.MoveStatement) else None)

    def _set_up(self, known: Setup, name: str, node: s.ProcedureCall) -> TriggerSetUp:
        """It can be said of one output, without more options or functions of the user's.

        Those are to be called once, and there.
        """
        call, calls = called(node), (x for x in nodes(node) if isinstance(x, s.FunctionCall))
        if call is None or any(self.own(x.name.lower()) for x in calls):
            return TriggerSetUp(name)
        kinds = [kind for option, kind in OUTPUTS.items() if option in call.options]
        signals = [x for option, x in call.options.items() if option in OUTPUTS]
        measures = [option for option in call.options if option in known.measures]
        alone = len(call.options) == len(signals) + len(measures) and len(measures) <= 1
        given = [one for one in call.given if one is not None]
        match signals:
            case [s.NameRef(signal)] if alone and len(given) == known.count:
                _, amount, *delay, value = map(self.meaning.expression, given)
                measure = MEASURES["".join(measures)]
                values = (value, amount, *delay)
                trigger = p.Trigger(
                    self.meaning.original(signal), value, amount, measure, None, *delay
                )
                fixed = all(isinstance(self.meaning.known(x), e.Number) for x in values)
                return TriggerSetUp(name, trigger, Signal(kinds[0], "output"), fixed)
        return TriggerSetUp(name)


def _trigger_node(kept: VendorText) -> Any:
    """The one declaration or statement that a text is, if it has to do with triggers."""
    if kept.language != verbatim.LANGUAGE or "trigg" not in kept.text.lower():
        return None
    read: Callable[[str], tuple[s.Node, ...]] = (
        verbatim.items if isinstance(kept, Declaration) else verbatim.statements
    )
    match verbatim.understood(read, kept.text):
        case (node,):
            return node
    return None
