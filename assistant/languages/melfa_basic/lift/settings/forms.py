"""With which settings each procedure is called: one form of it for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from assistant.languages.melfa_basic.lift.settings.flow import (
    LOST,
    Flow,
    is_inherited,
    joined,
    resolved,
)
from assistant.languages.melfa_basic.lift.settings.held import (
    FRAME,
    JOINT,
    TCP,
    TOOL,
    UNKNOWN,
    Held,
    State,
)
from assistant.languages.melfa_basic.tables.vocabulary import commands
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows
from assistant.languages.melfa_basic.tree.walk import nodes

MOST_FORMS: Final = 8
"""Forms of one procedure; called in more ways, its settings count as unknown."""

MOST_LINES: Final = 4000
"""Lines of all the passes of one file; what would take more is read once."""


@dataclass(slots=True, eq=False)
class Form:
    """A procedure as it is called with one set of settings, from `low` on to `high`.

    One that is divided is read in several passes, each under the settings of its own way there;
    itself it is the first. number: among the forms of the procedure, or the passes from `low` on.
    key: tells it from the others. name: what the procedure is called in this form, once that is
    decided.
    """

    region: int
    number: int
    state: State
    low: int
    high: int
    key: Any
    called: dict[int, dict[int, Form]] = field(default_factory=dict)
    """Forms that a line calls, by line, then by procedure."""
    head: Form | None = None
    passes: dict[Any, Form] = field(default_factory=dict)
    goes: dict[int, dict[int, Form]] = field(default_factory=dict)
    """Passes that a line leads to, by line, then by place."""
    falls: Form | None = None
    """The pass that stands below this one."""
    name: str = ""


class CalledForms:
    """forms: by procedure, in the order in which calls are met from the first procedure on.

    lines: of all of them, as often as they are read.
    """

    def __init__(self, flow: Flow, initial: State) -> None:
        self.flow = flow
        self.parts = [flow.parts(number) for number in range(len(flow.regions))]
        self.lines = [list(self._calls(number)) for number in range(len(flow.regions))]
        self.needs = self._needs()
        self.forms: list[dict[Any, Form]] = [{} for _ in flow.regions]
        self.read = 0
        pending = [self._form(0, initial)[0]] if flow.regions else []
        while pending and not self.too_long:
            form = pending.pop(0)
            pending += self._follow(form)
            if not pending:  # what nothing calls may be called from elsewhere
                left = next((k for k, found in enumerate(self.forms) if not found), None)
                if left is not None:
                    pending.append(self._form(left, LOST)[0])

    @property
    def too_long(self) -> bool:
        return bool(self.flow.cuts) and self.read > max(MOST_LINES, 2 * len(self.flow.code))

    def at(self, at: int, form: Form) -> State:
        """What holds where a line begins."""
        return resolved(self.flow.before.get(at, LOST), form.state)

    @property
    def unread(self) -> frozenset[int]:
        """Divided procedures with a part that no way leads to, by their number."""
        return frozenset(
            number
            for number, forms in enumerate(self.forms)
            if self.flow.is_divided(number)
            for form in forms.values()
            if {one.low for one in form.passes.values()} != {low for low, _ in self.parts[number]}
        )

    def _follow(self, form: Form) -> list[Form]:
        """Notes what a form calls, and where it goes; gives what is new or changed by that."""
        more = []
        for at, callee in self.lines[form.region]:
            if (form.head is None and not form.passes) or form.low <= at < form.high:
                made, changed = self._form(callee, self.at(at, form))
                form.called.setdefault(at, {})[callee] = made
                if changed:
                    more.append(made)
        if not form.passes and form.head is None:
            return more
        below: State | None = None
        for at in range(form.low, form.high):
            for to, state in self.flow.edges.get(at, {}).items():
                given = resolved(state, form.state)
                made, changed = self._pass(form, to, given)
                form.goes.setdefault(at, {})[to] = made
                if to == form.high and self.flow.goes_below(at):
                    below = joined(below, given)
                if changed:
                    more.append(made)
        if below is not None:
            form.falls, changed = self._pass(form, form.high, below)
            if changed:
                more.append(form.falls)
        return more

    def _form(self, region: int, state: State) -> tuple[Form, bool]:
        """The form of a procedure for what its caller has set; whether it is new or changed."""
        made, changed = self._met(self.forms[region], region, *self.parts[region][0], state)
        if self.flow.is_divided(region) and not made.passes:
            made.passes[made.key] = made
        return made, changed

    def _pass(self, form: Form, low: int, state: State) -> tuple[Form, bool]:
        """The pass of a divided procedure that begins at a place in a state."""
        head = form.head or form
        high = next(high for start, high in self.parts[form.region] if start == low)
        made, changed = self._met(head.passes, form.region, low, high, state)
        if made is not head:
            made.head = head
        return made, changed

    def _met(
        self, known: dict[Any, Form], region: int, low: int, high: int, state: State
    ) -> tuple[Form, bool]:
        """The one that begins at a place in a state, among those that are known."""
        count = sum(1 for one in known.values() if one.low == low)
        needs = self.needs[region, low]
        key: Any = (low, *(h.value if k in needs else None for k, h in enumerate(state)))
        if key not in known and count >= MOST_FORMS:
            key = low, UNKNOWN  # the same for all if there are too many
            state = tuple(Held(UNKNOWN, h.by) for h in state)
        if key in known:
            return known[key], self._join(known[key], state)
        made = known[key] = Form(region, count + 1, state, low, high, key)
        self.read += high - low
        return made, True

    @staticmethod
    def _join(known: Form, state: State) -> bool:
        both = joined(known.state, state)
        changed = both != known.state
        known.state = both
        return changed

    def _calls(self, number: int) -> Iterator[tuple[int, int]]:
        """Lines of a procedure and the procedures that they call."""
        region = self.flow.regions[number]
        for at in region.places():
            item = self.flow.code[at]
            if isinstance(item, s.Line) and item.statement is not None:
                for called in dict.fromkeys(self.flow.all_calls(item.statement)):
                    if isinstance(called, int):
                        yield at, called

    def _needs(self) -> dict[tuple[int, int], set[int]]:
        """By procedure and where a part of it begins, the settings that it takes from before."""
        flow = self.flow
        needs: dict[tuple[int, int], set[int]] = {}
        passed: list[tuple[tuple[int, int], set[int], tuple[int, int]]] = []
        for number, region in enumerate(flow.regions):
            called: dict[int, list[int]] = {}
            for at, callee in self.lines[number]:
                called.setdefault(at, []).append(callee)
            for low, high in self.parts[number]:
                mine = needs[number, low] = set()
                whole = not flow.is_divided(number)
                for at in region.places() if whole else range(low, high):
                    if at not in flow.before:
                        continue
                    inherited = _inherited(flow.before[at])
                    mine |= _used(flow.code[at]) & inherited
                    for callee in called.get(at, ()):
                        passed += [((number, low), inherited, (callee, self.parts[callee][0][0]))]
                    for to, state in flow.edges.get(at, {}).items():
                        passed += [((number, low), _inherited(state), (number, to))]
        while True:
            before = sum(len(n) for n in needs.values())
            for source, inherited, target in passed:
                needs[source] |= needs[target] & inherited
            if sum(len(n) for n in needs.values()) == before:
                return needs


def _inherited(state: State) -> set[int]:
    return {k for k, h in enumerate(state) if is_inherited(h.value)}


_ALL: Final = frozenset(range(5))
_READING: Final = {
    **dict.fromkeys(("P_CURR", "P_FBC", "P_CURRR", "PTOJ", "JTOP"), frozenset({TOOL, FRAME})),
    **dict.fromkeys(("P_TOOL", "M_TOOL"), frozenset({TOOL})),
    **dict.fromkeys(("P_BASE", "M_BSNO"), frozenset({FRAME})),
    "M_SPD": frozenset({TCP}),
    "M_JOVRD": frozenset({JOINT}),
    "M_RSPD": _ALL,
}
"""Settings that status variables and functions tell, or depend on."""
_SPARED: Final[dict[str, frozenset[int]]] = {"Mov": frozenset({TCP}), "Mva": frozenset()}
"""Settings that a move does not depend on; others are at no percentage of joint speed."""


def _used(item: s.Entry) -> frozenset[int]:
    """Settings that a line depends on: a joint move on no speed of the tool, others on no other."""
    match item:
        case MoveRows(kinds=kinds):
            joint = kinds == MOV
            return _ALL - ({TCP} if joint.all() else {JOINT} if not joint.any() else set())
        case s.Line(statement=statement) if statement is not None:
            return depends(statement)
    return frozenset()


def depends(statement: s.Statement) -> frozenset[int]:
    """The settings that what a statement does depends on."""
    found: frozenset[int] = frozenset()
    for part in nodes(statement):
        match part:
            case s.Motion(keyword=keyword):
                found |= _ALL - _SPARED.get(keyword, frozenset({JOINT}))
            case s.Variable(key=key) if key in _READING:
                found |= _READING[key]
            case s.Command(keyword=keyword) if keyword in commands("needs"):
                found |= _ALL
    return found
