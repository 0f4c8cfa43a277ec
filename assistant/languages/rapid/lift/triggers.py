r"""Outputs that moves set on their way: TriggL and its kin with the data that TriggIO sets up.

Where it is certain which instruction set up the data that a move takes, and nothing else reads
them, the move says itself what it sets where; the variables and what sets them up are left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

from assistant.languages.rapid.lift.instructions import Meaning, instruction
from assistant.languages.rapid.tables.standard import FUNCTIONS, INSTRUCTIONS
from assistant.languages.rapid.tables.triggers import MEASURES, MORE, MOVES, OUTPUTS, SETUPS, TYPE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.triggers import set_up, taken
from assistant.languages.rapid.tree.walk import blocks, nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import reachable
from assistant.program.program import Signal

SPECIAL: Final = e.Reason(
    "what happens on the way of the move is not only that one output is given a number there",
    r"set an output by TriggIO or TriggEquip with \DOp, \GOp or \AOp and no more options",
)
_STANDARD: Final = INSTRUCTIONS | FUNCTIONS
UNCERTAIN: Final = e.Reason(
    "which output the move sets where depends on how the program came here",
    "set the triggdata up with plain numbers, in the statements before the move",
)
MOVE: Final = e.Reason(
    "the move states more than its speed, zone, tool and work object",
    "leave out its other options",
)


@dataclass(frozen=True, slots=True)
class Setting:
    """What an instruction sets a variable to. kind: of the signal."""

    trigger: p.Trigger
    kind: Any


State = Mapping[str, Setting | None]
"""By lower-case name of a variable, what it is set to on every way to here; None for what the
pseudo-program cannot say."""


@dataclass(slots=True)
class Triggers:
    """What calls of instructions become, by identity of their nodes.

    said: moves, None for what is left out. reasons: why others stay. names: lower-case names of
    the variables that are left out.
    """

    said: dict[int, p.Statement | None] = field(default_factory=dict)
    reasons: dict[int, e.Reason] = field(default_factory=dict)
    names: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class _Taking:
    """A move, the names of the variables that it takes, and what they are set to there."""

    node: s.ProcedureCall
    names: tuple[str, ...]
    settings: tuple[Setting | None, ...]

    def said(self, single: Mapping[str, Setting], meaning: Meaning) -> p.Statement | e.Reason:
        """single: what variables are set to that only one instruction of all sets up."""
        pairs = zip(self.names, self.settings, strict=True)
        found = [single.get(name) if one is None else one for name, one in pairs]
        plain = _plain(self.node)
        move = None if plain is None else instruction(plain, meaning)
        if not isinstance(move, p.MoveStatement):
            return MOVE
        triggers = tuple(one.trigger for one in found if one is not None)
        if len(triggers) < len(found) or not found:
            return UNCERTAIN
        return replace(move, triggers=triggers)


def triggers(
    items: Sequence[s.Item],
    routines: Sequence[s.Routine],
    meaning: Meaning,
    own: Callable[[str], bool],
) -> Triggers:
    """items: of all modules. routines: those that are lifted. own: whether a lower-case name is
    that of a routine of the user's.
    """
    data = [(node, inside) for node, inside in _data(items) if node.type.lower() == TYPE]
    if not data:
        return Triggers()
    setting_up = _setting_up(items, own)
    hidden = any(map(own, (*SETUPS, *MOVES))) or _is_set_up_aside(items, setting_up)
    declared = frozenset() if hidden else _declared(data, _is_whole(items, own))
    reading = _Reading(meaning, own, setting_up)
    for routine in routines:
        reading.body(routine.body, {})
    return reading.settled(items, declared)


class _Reading:
    """The bodies of routines.

    own, setting_up: whether a lower-case name is that of a routine of the user's, and of one that
    may set triggdata up. set: what instructions set each variable to. meant: mentions of each that
    are understood.
    """

    def __init__(
        self, meaning: Meaning, own: Callable[[str], bool], setting_up: frozenset[str]
    ) -> None:
        self.meaning, self.own, self.setting_up = meaning, own, setting_up
        self.set: dict[str, list[tuple[s.ProcedureCall, Setting | None]]] = {}
        self.taking: list[_Taking] = []
        self.meant: Counter[str] = Counter()

    # --------------------------------------------------------------------------- statements

    def body(self, body: Sequence[s.StatementNode], state: State) -> State:
        for node in body:
            state = self.statement(node, state)
        return state

    def statement(self, node: s.StatementNode, state: State) -> State:
        if isinstance(node, s.CommentLine):
            return state
        if any(map(self.leads_astray, nodes((node,)))):
            state = {}
        match node:
            case s.ProcedureCall(str(name)) if name.lower() in SETUPS:
                return self.setup(node, state)
            case s.ProcedureCall(str(name)) if name.lower() in MOVES:
                names = tuple(one.name.lower() for one in taken(node))
                self.meant.update(names)
                settings = tuple(state.get(one) for one in names)
                self.taking.append(_Taking(node, names, settings))
        inner = blocks(node)
        changed = {set_up(one) for one in nodes(inner)}
        state = {n: x for n, x in state.items() if self.is_fixed(x) and n not in changed}
        if not _stays(node):
            for body in inner:
                self.body(body, state)
        return state

    def setup(self, node: s.ProcedureCall, state: State) -> State:
        name = set_up(node)
        if not name:
            return state
        made = setting(node, self.meaning)
        if any(isinstance(x, s.FunctionCall) and self.own(x.name.lower()) for x in nodes((node,))):
            made = None  # it is to be called once, and here
        self.meant[name] += 1
        self.set.setdefault(name, []).append((node, made))
        return {**state, name: made}

    def leads_astray(self, node: s.Node) -> bool:
        """Whether statements that set triggdata up may run there, or the way here is not known."""
        if isinstance(node, s.LabelMark):
            return True
        name = _called(node)
        return name is not None and (
            name in self.setting_up if self.own(name) else name not in _STANDARD
        )

    def is_fixed(self, one: Setting | None) -> bool:
        """Whether it is made of numbers that are the same everywhere."""
        if one is None:
            return False
        values = one.trigger.value, one.trigger.amount, one.trigger.ahead
        return all(x is None or isinstance(self.meaning.known(x), e.Number) for x in values)

    # -------------------------------------------------------------------------- what is said

    def settled(self, items: Sequence[s.Item], declared: frozenset[str]) -> Triggers:
        """What can be said without any of the variables that stay."""
        said = [(move, move.said(self.single(), self.meaning)) for move in self.taking]
        gone = self.gone(items, declared, said) if declared else set()
        made = Triggers(names=frozenset(gone))
        for name, found in self.set.items():
            for node, one in found:
                if name in gone and one is not None:
                    made.said[id(node)] = None
                    self.meaning.used.append((one.trigger.signal, Signal(one.kind, "output")))
                else:
                    made.reasons[id(node)] = SPECIAL if one is None else UNCERTAIN
        for move, what in said:
            if isinstance(what, e.Reason):
                made.reasons[id(move.node)] = what
            elif gone.issuperset(move.names):
                made.said[id(move.node)] = what
            else:
                seen = declared.issuperset(move.names)
                made.reasons[id(move.node)] = SPECIAL if seen else UNCERTAIN
        return made

    def single(self) -> dict[str, Setting]:
        """What variables are set to that one instruction alone sets up, with plain numbers."""
        return {
            name: one
            for name, found in self.set.items()
            for _, one in found
            if len(found) == 1 and one is not None and self.is_fixed(one)
        }

    def gone(
        self, items: Sequence[s.Item], declared: frozenset[str], said: Sequence[Said]
    ) -> set[str]:
        """Lower-case names of the variables that nothing needs once moves say what they mean."""
        named = _named(items)
        used = {name for move, _ in said for name in move.names}  # others may be another module's
        gone = {name for name in declared & used if named[name] == self.meant[name] + 1}
        gone -= {name for name, found in self.set.items() if any(x is None for _, x in found)}
        while True:
            left = {
                name
                for move, what in said
                if isinstance(what, e.Reason) or not gone.issuperset(move.names)
                for name in move.names
            }
            if gone.isdisjoint(left):
                return gone
            gone -= left


Said = tuple[_Taking, p.Statement | e.Reason]


def _called(node: s.Node) -> str | None:
    """The lower-case name of the routine that a node calls, empty if it is worked out."""
    match node:
        case s.ProcedureCall(name):
            return name.lower() if isinstance(name, str) else ""
        case s.FunctionCall(name):
            return name.lower()
    return None


def _setting_up(items: Sequence[s.Item], own: Callable[[str], bool]) -> frozenset[str]:
    """Lower-case names of routines that may set triggdata up, also by routines that they call."""
    callers: dict[str, set[str]] = {}
    direct: set[str] = set()
    for item in items:
        if isinstance(item, s.Routine):
            for node in nodes((item,)):
                name = _called(node)
                if set_up(node) or (name is not None and not own(name) and name not in _STANDARD):
                    direct.add(item.name.lower())
                elif name is not None:
                    callers.setdefault(name, set()).add(item.name.lower())
    return frozenset(reachable(direct, lambda name: callers.get(name, ())))


def _is_set_up_aside(items: Sequence[s.Item], setting_up: Set[str]) -> bool:
    """Whether an interrupt or what handles errors, which may run anywhere, may set triggdata up."""
    aside: list[s.Node] = []
    for item in items:
        if isinstance(item, s.Routine):
            aside += (item,) if item.kind == "TRAP" else item.handlers
    return any(set_up(node) or _called(node) in setting_up for node in nodes(tuple(aside)))


def _is_whole(items: Sequence[s.Item], own: Callable[[str], bool]) -> bool:
    """Whether nothing of another module is called, which might set up what it sees of this one."""
    names = map(_called, nodes(tuple(items)))
    return all(name is None or own(name) or name in _STANDARD for name in names)


def _data(items: Sequence[s.Item]) -> Iterator[tuple[s.Data, bool]]:
    """Declarations, and whether each is in a routine."""
    for item in items:
        inside = isinstance(item, s.Routine)
        for node in item.body if isinstance(item, s.Routine) else (item,):
            if isinstance(node, s.Data):
                yield node, inside


def _declared(data: Sequence[tuple[s.Data, bool]], whole: bool) -> frozenset[str]:
    """Lower-case names of the variables that are declared once.

    whole: whether others than those of routines and modules alone count.
    """
    found: Counter[str] = Counter()
    for node, inside in data:
        plain = node.storage == "VAR" and node.scope != "TASK" and not node.dimensions
        seen = whole or inside or node.scope == "LOCAL"
        found[node.name.lower()] += 1 if plain and seen else 2
    return frozenset(name for name, count in found.items() if count == 1)


def _named(items: Sequence[s.Item]) -> Counter[str]:
    """How often each name is mentioned, in lower case."""
    named: Counter[str] = Counter()
    for node in nodes(tuple(items)):
        match node:
            case s.NameRef(name) | s.Data(name=str(name)) | s.ParameterNode(name=str(name)):
                named[name.lower()] += 1
            case s.ForLoop(variable=str(name)):
                named[name.lower()] += 2  # hides it
    return named


def _plain(node: s.ProcedureCall) -> s.ProcedureCall | None:
    """A move without what it takes; None if that is not told by plain variables alone."""
    move = MOVES[str(node.name).lower()]
    rest: list[s.Argument] = []
    place = more = 0
    for argument in node.arguments:
        if isinstance(argument, s.Positional):
            place += 1
            if place == move.place + 1:
                continue
        elif isinstance(argument, s.Option) and argument.name.lower() in MORE:
            more += 1
            continue
        rest.append(argument)
    if len(taken(node)) != 1 + more:
        return None
    return replace(node, name=move.plain, arguments=tuple(rest))


def setting(node: s.ProcedureCall, meaning: Meaning) -> Setting | None:
    """What an instruction sets a variable to, None if the pseudo-program cannot say it."""
    known, call = SETUPS[str(node.name).lower()], called(node)
    options = {} if call is None else call.options
    outputs = [name for name in options if name in OUTPUTS]
    measures = [name for name in options if name in known.measures]
    if call is None or len(options) != len(outputs) + len(measures):
        return None
    given = [one for one in call.given if one is not None]
    if len(given) != known.count or len(outputs) != 1 or len(measures) > 1:
        return None
    signal = options[outputs[0]]
    if not isinstance(signal, s.NameRef):
        return None
    _, amount, *delay, value = map(meaning.expression, given)
    trigger = p.Trigger(
        meaning.original(signal.name),
        value,
        amount,
        MEASURES["".join(measures)],
        ahead=delay[0] if delay else None,
    )
    return Setting(trigger, OUTPUTS[outputs[0]])


def _stays(node: s.StatementNode) -> bool:
    """Whether a block is kept as its text."""
    match node:
        case s.IfThen(branches):
            return any(branch.condition is None for branch in branches)
        case s.TestOf(_, cases):
            return not all(case.values for case in cases)
    return False
