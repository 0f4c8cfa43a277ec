"""With which settings each procedure is called: one form of it for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MOV, MoveRows
from assistant.languages.melfa_basic.lift.flow import INHERITED, Flow, joined, resolved
from assistant.languages.melfa_basic.lift.settings import JOINT, TCP, UNKNOWN, Held, State
from assistant.languages.melfa_basic.lift.walk import nodes

MOST_FORMS: Final = 4
"""Forms of one procedure; called in more ways, its settings count as unknown."""

LOST: Final[State] = (Held(UNKNOWN),) * 5


@dataclass(slots=True)
class Form:
    """A procedure as it is called with one set of settings."""

    region: int
    number: int
    state: State
    called: dict[int, dict[int, Form]] = field(default_factory=dict)
    """Forms that a line calls, by line, then by procedure."""


class Contexts:
    """forms: by procedure, in the order in which calls are met from the first procedure on."""

    def __init__(self, flow: Flow, initial: State) -> None:
        self.flow = flow
        self.lines = [list(self._calls(number)) for number in range(len(flow.regions))]
        self.needs = self._needs()
        self.forms: list[dict[Any, Form]] = [{} for _ in flow.regions]
        pending = [self._form(0, initial)[0]] if flow.regions else []
        while pending:
            form = pending.pop(0)
            for at, callee in self.lines[form.region]:
                state = self.at(at, form)
                made, changed = self._form(callee, state)
                form.called.setdefault(at, {})[callee] = made
                if changed:
                    pending.append(made)
            if not pending:  # what nothing calls may be called from elsewhere
                left = next((k for k, found in enumerate(self.forms) if not found), None)
                if left is not None:
                    pending.append(self._form(left, LOST)[0])

    def at(self, at: int, form: Form) -> State:
        """What holds where a line begins."""
        return resolved(self.flow.before.get(at, LOST), form.state)

    def _form(self, region: int, state: State) -> tuple[Form, bool]:
        """The form of a procedure for what its caller has set; whether it is new or changed."""
        forms, needs = self.forms[region], self.needs[region]
        key = tuple(h.value if k in needs else None for k, h in enumerate(state))
        if key not in forms and len(forms) >= MOST_FORMS:
            key, state = (UNKNOWN,), tuple(Held(UNKNOWN, h.by) for h in state)
        known = forms.get(key)
        if known is None:
            forms[key] = Form(region, len(forms) + 1, state)
            return forms[key], True
        both = joined(known.state, state)
        changed = both != known.state
        known.state = both
        return known, changed

    def _calls(self, number: int) -> Iterator[tuple[int, int]]:
        """Lines of a procedure and the procedures that they call."""
        region = self.flow.regions[number]
        for at in region.places():
            item = self.flow.code[at]
            if isinstance(item, s.Line) and item.statement is not None:
                for called in dict.fromkeys(self.flow.all_calls(item.statement)):
                    if isinstance(called, int):
                        yield at, called

    def _needs(self) -> list[set[int]]:
        """By procedure, the settings that it takes from its caller."""
        flow = self.flow
        needs: list[set[int]] = [set() for _ in flow.regions]
        for number, region in enumerate(flow.regions):
            for at in region.places():
                if at in flow.before:
                    needs[number] |= _used(flow.code[at]) & _inherited(flow.before[at])
        while True:
            before = [set(n) for n in needs]
            for number, lines in enumerate(self.lines):
                for at, callee in lines:
                    if at in flow.before:
                        needs[number] |= needs[callee] & _inherited(flow.before[at])
            if needs == before:
                return needs


def _inherited(state: State) -> set[int]:
    return {k for k, h in enumerate(state) if h.value is INHERITED}


_READING: Final = frozenset(
    {
        *("P_CURR", "P_FBC", "P_TOOL", "P_BASE", "P_CURRR", "M_TOOL", "M_BSNO", "M_SPD"),
        *("M_RSPD", "M_JOVRD", "PTOJ", "JTOP"),
    }
)
"""Status variables and functions that tell what holds, or depend on it."""


_ALL: Final = frozenset(range(5))


def _used(item: s.Line | MoveRows) -> frozenset[int]:
    """Settings that a line depends on: a joint move on no speed of the tool, others on no other."""
    match item:
        case MoveRows(kinds=kinds):
            joint = kinds == MOV
            return _ALL - ({TCP} if joint.all() else {JOINT} if not joint.any() else set())
        case s.Line(statement=s.Motion(keyword="Mov", append=None)):
            return _ALL - {TCP}
        case s.Line(statement=s.Motion(append=None)):
            return _ALL - {JOINT}
        case s.Line(statement=statement) if statement is not None and depends(statement):
            return _ALL
    return frozenset()


def depends(statement: s.Statement) -> bool:
    """Whether what a statement does depends on the settings."""
    return any(
        isinstance(part, s.Motion)
        or (isinstance(part, s.Variable) and part.key in _READING)
        or (isinstance(part, s.Command) and part.keyword in ("Mxt", "EHMov", "JRC", "Fsc"))
        for part in nodes(statement)
    )
