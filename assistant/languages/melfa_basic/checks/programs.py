"""Several programs: calls, slots, interrupts, files, and variables that slots share.

Shared variables that are read before anything sets them are found by a forward analysis over all
programs. At each line it holds the variables that every path from the start of the program has
set: through jumps, loops, subroutines, interrupts, `CallP`, and from an `XRun` into the program
that it starts. A `Wait` for a value that only programs here give adds what was set wherever one
gives it, so programs that hand each other the turn are not reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from itertools import chain
from typing import Final, Literal, TypeAlias

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Rule
from assistant.languages.checks.control_flow import call_chain, call_depth
from assistant.languages.checks.names import Keyed, NameSet, firsts
from assistant.languages.checks.registry import Found
from assistant.languages.line_blocks import EXIT
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import flow, motions
from assistant.languages.melfa_basic.checks.file_view import Calls, Look, given_by_data
from assistant.languages.melfa_basic.checks.flow import ScopePart, scope_parts
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.dialects import DIALECTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.control_flow import labels_of, statement_of
from assistant.languages.melfa_basic.tree.walk import (
    Use,
    awaited_programs,
    lines_with,
    literal,
    named_programs,
    nodes,
    program_key,
    program_name,
    statements_in,
    uses,
)
from assistant.languages.step_numbers import first_step, places_of_steps
from assistant.program.analysis.dataflow import Dataflow, reachable


def missing_programs(look: Look) -> Found:
    """Programs that are called, run or loaded, and are not among the files."""
    awaits = {program_key(name) for _, name in awaited_programs(look.tree)}
    for line, name, _ in firsts(named_programs(look.tree), lambda call: program_key(call[1])):
        if program_key(name) not in look.calls.by_name:
            rule = rules.NOT_CALLED if program_key(name) in awaits else rules.NO_PROGRAM
            yield look.at(rule, line, f'"{name}"', name=name)


def program_recursion(look: Look) -> Found:
    """Programs that call themselves, or call too deep: the first call of either kind."""
    own = program_name(look.tree).upper()
    most = look.dialect.calls

    def inner(name: str) -> list[str]:
        tree = look.calls.by_name.get(name)
        return (
            [program_key(other) for _, other in awaited_programs(tree)] if tree is not None else []
        )

    for line, written in awaited_programs(look.tree):
        name = program_key(written)
        chain = call_chain(own, name, inner) if own else None
        if chain is not None:
            text = " calls ".join(f"`{n}`" for n in (own, *chain))
            yield look.at(flow.CALLS_ITSELF, line, "CallP", chain=text)
            return
        deep = 1 + call_depth(name, inner)
        # Only the call that passes the limit; the programs above would report the same chain again.
        if deep == most + 1:
            yield look.at(flow.CALLED_TOO_DEEP, line, "CallP", depth=deep, most=most)
            return


def mechanism_requests(look: Look) -> Found:
    """Programs that are run in slots other than 1, and move the robot without having asked."""
    others = (call for call in named_programs(look.tree) if (call[2] or 0) > 1)
    for line, name, slot in firsts(others, lambda call: program_key(call[1])):
        tree = look.calls.by_name.get(program_key(name))
        code = tree.code if tree else ()
        asks = any(command.keyword == "GetM" for _, command in lines_with(code, s.Command))
        if any(map(_moves_robot, code)) and not asks:
            yield look.at(motions.NO_GETM, line, f'"{name}"', name=name, slot=slot)


def _moves_robot(item: s.Entry) -> bool:
    return isinstance(item, MoveRows) or isinstance(item.statement, s.Motion)


# ----------------------------------------------------------------------------------- interrupts


_NumberedLines = Keyed[float, tuple[s.Line, str]]
"""Number → the line that names it, and the word before it."""


def _without(look: Look, rule: Rule, some: _NumberedLines, others: _NumberedLines) -> Found:
    """The rule's finding at each number that is not among others."""
    for number, (line, word) in some.without(others):
        yield look.at(rule, line, word, word=word, number=f"{number:g}")


def interrupt_switches(look: Look) -> Found:
    """Interrupts that are switched but not defined, or defined but not switched on."""
    switches = list(_switches(look))
    defined = Keyed.of((literal(act.number), (line, "Act")) for line, act in look.all(s.DefAct))
    switched = Keyed.of((n, (line, "Act")) for line, n, _ in switches if n)
    # `Act 0` switches all interrupts, a computed number any: either may switch each of them on.
    on = Keyed.of(
        (n or None, (line, "Act")) for line, n, state in switches if n is None or state != 0
    )
    yield from _without(look, motions.NO_ACT, switched, defined)
    yield from _without(look, motions.ACT_OFF, defined, on)


def _switches(look: Look) -> Iterator[tuple[s.Line, float | None, float | None]]:
    """`Act n=state` statements; None for numbers that are worked out."""
    for line, command in look.all(s.Command):
        if command.keyword == "Act" and command.arguments:
            match command.arguments[0]:
                case s.Binary("=", number, state):
                    yield line, literal(number), literal(state)


# --------------------------------------------------------------------------------------- files


def file_states(look: Look) -> Found:
    """Lines that are used without being opened, opened twice, or never closed."""
    printed = ((literal(node.number), (line, "Print")) for line, node in look.all(s.Print))
    read = ((literal(node.number), (line, "Input")) for line, node in look.all(s.Input))
    used = Keyed.of((*printed, *read))
    opened = Keyed.of((literal(node.number), (line, "Open")) for line, node in look.all(s.Open))
    closed = Keyed.of(
        (number, (line, "Close"))
        for line, node in look.all(s.Close)
        for number in map(literal, node.numbers or (None,))
    )
    # A line stays open from one program to the next, so another file may have opened it.
    beside = (tree for tree in look.calls.trees if tree is not look.tree)
    others = any(any(lines_with(tree.items, s.Open)) for tree in beside)
    if not others:
        yield from _without(look, motions.NOT_OPENED, used, opened)
    yield from _without(look, motions.NOT_CLOSED, opened, closed)
    yield from _opened_twice(look)


def _opened_twice(look: Look) -> Found:
    """Opens of a number that is open, as far as the lines run straight on."""
    busy: set[float] = set()
    for line in look.lines:
        if line.label is not None:
            busy.clear()
        match line.statement:
            case s.Open(number=value):
                number = literal(value)
                if number is not None and number in busy:
                    yield look.at(motions.OPENED_TWICE, line, "Open", number=f"{number:g}")
                if number is not None:
                    busy.add(number)
            case s.Close(numbers=numbers):
                busy -= {n for value in numbers if (n := literal(value)) is not None}
                if not numbers or any(literal(value) is None for value in numbers):
                    busy.clear()
            # These may close lines, and the lines below may be reached on another path.
            case s.Command("End") | s.Jump() | s.CallP() | s.Call() | s.If():
                busy.clear()


Node: TypeAlias = tuple[int, int]
"""A line: the place of its file among the files, and its place in the code of the file."""
_Keys: TypeAlias = frozenset[str]
"""Names of shared variables in upper case."""
_Side: TypeAlias = Literal["begins", "behind"]
_Facts: TypeAlias = Dataflow[tuple[Node, _Side], _Keys]

_NO_KEYS: Final[_Keys] = frozenset()


def _common_keys(some: _Keys, others: _Keys) -> _Keys:
    return some & others


def _all_keys(known: Sequence[_Keys]) -> _Keys:
    return known[0].intersection(*known[1:])


@dataclass(frozen=True, slots=True)
class _Branch:
    """One outcome of a statement: the variables that it sets, and the first lines that it calls."""

    sets: _Keys = _NO_KEYS
    calls: tuple[Node, ...] = ()

    def __or__(self, other: _Branch) -> _Branch:
        return _Branch(self.sets | other.sets, self.calls + other.calls)


@dataclass(frozen=True, slots=True)
class Start:
    """An `XRun` of another program. node: its line. program: place of the other file."""

    node: Node
    program: int
    slot: int
    name: str


@dataclass(slots=True)
class _SharedSlots:
    """Use of shared variables in the programs of some files, line by line.

    after, calls, handlers: lines that may follow a line, that it calls, that lead to interrupts.
    outcomes: of a line. reads: by line, in their order. gives: by variable, the lines that may set
    it, each with the number that it becomes, None for an unknown value. begins: first lines of
    programs. ends: lines at which a program ends. called: by program those that it calls.
    """

    trees: tuple[s.File, ...]
    after: dict[Node, list[Node]] = field(default_factory=dict)
    calls: dict[Node, list[Node]] = field(default_factory=dict)
    handlers: dict[Node, list[Node]] = field(default_factory=dict)
    outcomes: dict[Node, tuple[_Branch, ...]] = field(default_factory=dict)
    reads: dict[Node, list[s.Variable]] = field(default_factory=dict)
    gives: dict[str, list[tuple[Node, float | None]]] = field(default_factory=dict)
    waits: dict[Node, tuple[str, float]] = field(default_factory=dict)
    begins: dict[int, Node] = field(default_factory=dict)
    ends: list[Node] = field(default_factory=list)
    starts: list[Start] = field(default_factory=list)
    called: dict[int, set[int]] = field(default_factory=dict)
    surely: dict[Node, _Keys] = field(default_factory=dict)
    """By the first line of what is called: variables that are set whenever it has come back."""
    gains: dict[Node, _Keys] = field(default_factory=dict)
    """Variables that are set once a `Wait` is over."""
    facts: _Facts = field(init=False)
    """Variables that are set where a line begins, whatever led there."""

    # ------------------------------------------------------------------------------- analysis

    def behind(self, node: Node, found: _Keys) -> _Keys | None:
        """Variables that are set behind a line; None if what it calls never comes back."""
        known: list[_Keys] = [
            outcome.sets.union(*(self.surely[entry] for entry in outcome.calls))
            for outcome in self.outcomes.get(node, (_Branch(),))
            # A branch whose call never comes back does not reach the next line.
            if all(entry in self.surely for entry in outcome.calls)
        ]
        if not known:
            return None
        key, _ = self.waits.get(node, ("", 0.0))
        # A value left in the variable from the last run would end the wait at once. Only a variable
        # that was set in this run shows which variables its setters have set.
        gained = self.gains.get(node, _NO_KEYS) if key in found else _NO_KEYS
        return found | _all_keys(known) | gained

    def settle(self) -> None:
        """Work out what calls set, then what waits tell, each until nothing changes any more."""
        # Backward from the ends: what is set on every path from a line to the return.
        before: dict[Node, list[Node]] = {node: [] for node in self.after}
        for node, places in self.after.items():
            for place in places:
                before[place].append(node)
        entries = set(chain.from_iterable(self.calls.values()))
        # The result of a call depends on the calls inside it: repeat until all are stable.
        while True:
            back = Dataflow[Node, _Keys](before, self.behind, _common_keys)
            back.spread((end, _NO_KEYS) for end in self.ends)
            found = {entry: back.found[entry] for entry in entries if entry in back.found}
            made = {e: keys for e in found if (keys := self.behind(e, found[e])) is not None}
            if made == self.surely:
                break
            self.surely = made
        # Assume first that each wait proves everything; each round drops what a setter does not
        # support.
        self.gains = dict.fromkeys(self.waits, frozenset(self.gives))
        started = {start.program for start in self.starts}.union(*self.called.values())
        roots = [begin for of, begin in self.begins.items() if of not in started]
        while True:
            self.facts = self.flow(((root, _NO_KEYS) for root in roots), started=True)
            # Programs that only start each other have no root; they may begin with nothing set.
            left = [n for n in self.begins.values() if (n, "begins") not in self.facts.found]
            self.facts.spread(((node, "begins"), _NO_KEYS) for node in left)
            gains = {node: self._gain(*self.waits[node]) for node in self.waits}
            if gains == self.gains:
                break
            self.gains = gains

    def flow(self, entries: Iterable[tuple[Node, _Keys]], *, started: bool = False) -> _Facts:
        """The variables that are set from some lines on. started: in programs of `XRun` too."""
        after: dict[tuple[Node, _Side], list[tuple[Node, _Side]]] = {}
        runs: dict[Node, list[Node]] = {}
        for start in self.starts if started else ():
            runs.setdefault(start.node, []).append(self.begins[start.program])
        for node, places in self.after.items():
            # A line has two sides: its calls begin before its own effects, what follows begins
            # after them.
            inner = (*self.calls.get(node, ()), *runs.get(node, ()))
            led = [*places, *self.handlers.get(node, ())]
            after[node, "begins"] = [(node, "behind"), *((entry, "begins") for entry in inner)]
            after[node, "behind"] = [(place, "begins") for place in led]

        def effect(at: tuple[Node, _Side], found: _Keys) -> _Keys | None:
            return found if at[1] == "begins" else self.behind(at[0], found)

        facts: _Facts = Dataflow(after, effect, _common_keys)
        facts.spread(((node, "begins"), keys) for node, keys in entries)
        return facts

    def _gain(self, key: str, number: float) -> _Keys:
        """Variables that are set wherever one may become a number."""
        reached = self.facts.found
        known = [
            behind
            for node, value in self.gives.get(key, ())
            if (value is None or value == number) and (node, "begins") in reached
            if (behind := self.behind(node, reached[node, "begins"])) is not None
        ]
        return _all_keys(known) if known else _NO_KEYS

    # ------------------------------------------------------------------------------- questions

    def with_called(self, program: int) -> set[int]:
        """A program and those that it calls, directly or not, all by their places."""
        return reachable([program], lambda of: self.called.get(of, ()))

    def unset(self, facts: _Facts, programs: Iterable[int]) -> Iterator[tuple[Node, s.Variable]]:
        """The first read of each variable that a path has not set, in the order of programs."""
        seen: set[str] = set()
        lines = ((of, at) for of in programs for at in range(len(self.trees[of].code)))
        for node in lines:
            known = facts.found.get((node, "begins"))
            for variable in self.reads.get(node, ()):
                if known is not None and variable.key not in known and variable.key not in seen:
                    seen.add(variable.key)
                    yield node, variable

    def line(self, node: Node) -> s.Entry:
        return self.trees[node[0]].code[node[1]]

    def flows_into(self, line: Node) -> set[Node]:
        """Lines that a line may lead to, those of subroutines and of called programs too."""
        return reachable([line], lambda at: (*self.after[at], *self.calls.get(at, ())))


# ------------------------------------------------------------------------------------- findings


def started_early(look: Look) -> Found:
    """Programs that are run in other slots and may read a shared variable before it is set."""
    found = look.calls.once(_shared_slots)
    if found is None:
        return
    own = _file_number(look)
    for start in found.starts:
        entry = found.facts.found.get((start.node, "begins"))
        line, name = found.line(start.node), start.name
        if start.node[0] != own or entry is None or not isinstance(line, s.Line):
            continue
        inner = found.with_called(start.program)
        facts = found.flow([(found.begins[start.program], entry)])
        order = [start.program, *sorted(inner - {start.program})]
        for node, variable in found.unset(facts, order):
            setter = _setter(found, start, variable.key)
            if setter:
                where = f'"{name}"' if f'"{name}"' in look.text_of(line).upper() else "XRun"
                yield look.at(
                    flow.READ_BEFORE_SET, line, where, name=variable.marked, program=name,
                    slot=f"slot {start.slot}" if start.slot else "another slot",
                    reading=_line_reference(found, node, start.program), setter=setter,
                )  # fmt: skip


def last_values(look: Look) -> Found:
    """Shared variables that this program may read before they are set, and another slot sets."""
    found = look.calls.once(_shared_slots)
    if found is None:
        return
    own = _file_number(look)
    tasks = map(found.with_called, found.begins)
    mine = set().union(*(task for task in tasks if own in task))
    others = {
        start.name: inner
        for start in found.starts
        if start.node[0] in mine and own not in (inner := found.with_called(start.program))
    }
    for node, variable in found.unset(found.facts, [own]):
        for name, inner in others.items():
            if any(giver[0] in inner for giver, _ in found.gives.get(variable.key, ())):
                line = found.line(node)
                yield look.at(flow.LAST_VALUE, line, variable, program=f"`{name}`")
                break


def _setter(found: _SharedSlots, start: Start, key: str) -> str:
    """The line or the other program that sets a variable beside a started program, in words.

    Empty for none. A line that may follow the start comes first.
    """
    own, inner = start.node[0], found.with_called(start.program)
    task = found.with_called(own) - inner
    givers = [node for node, _ in found.gives.get(key, ()) if node[0] not in inner]
    here = [node for node in givers if node[0] in task and (node, "begins") in found.facts.found]
    if here:
        later = found.flows_into(start.node)
        # In this order: a line that follows the start, a line of this file, the first one.
        best = min(here, key=lambda node: (node not in later, node[0] != own, node))
        return f"line {_line_reference(found, best, own)}" + (" here" if best[0] == own else "")
    for other in found.starts:
        beside = found.with_called(other.program) if other.node[0] in task else ()
        if any(node[0] in beside for node in givers):
            return f"`{other.name}`"
    return ""


def _line_reference(found: _SharedSlots, node: Node, program: int) -> str:
    """The number of a line, with the name of its file if that is not the program's."""
    tree, line = found.trees[node[0]], found.line(node)
    number = first_step(line)
    if number is None and line.span is not None and tree.source is not None:
        number = tree.source.text.count("\n", 0, line.span.start) + 1
    return f"{number}" if node[0] == program else f"{number} of `{program_name(tree).upper()}`"


def _file_number(look: Look) -> int:
    """The place of a file among the files."""
    return next(at for at, tree in enumerate(look.calls.trees) if tree is look.tree)


# ------------------------------------------------------------------------------------- reading


def _shared_slots(calls: Calls) -> _SharedSlots | None:
    """Return the variables that the programs of some files share; None if no program starts
    another.
    """
    looks = [Look(tree, DIALECTS[tree.dialect], calls) for tree in calls.trees]
    if not any(c.keyword == "XRun" for look in looks for _, c in look.all(s.Command)):
        return None
    places = {id(tree): at for at, tree in enumerate(calls.trees)}
    by_name = {name: places[id(tree)] for name, tree in calls.by_name.items()}
    found = _SharedSlots(tuple(calls.trees))
    sound = [at for at, look in enumerate(looks) if _take_paths(look, at, found)]
    shared = _Shared(calls.once(given_by_data))
    for at in sound:
        for part in looks[at].once(scope_parts):
            _Reader(looks[at], part, at, found, by_name, shared).take()
    for at in sound:
        found.starts += _starts(looks[at], at, found, by_name)
    found.settle()
    return found


def _take_paths(look: Look, of: int, found: _SharedSlots) -> bool:
    """Add the paths through a file; false if its blocks are not sound, or it has no lines."""
    scopes = look.once(scope_parts)
    if not all(part.ways and part.scope.entries for part in scopes):
        return False
    # All ways out of a file lead to one node, from which the backward analysis starts.
    found.after[of, EXIT] = []
    found.ends.append((of, EXIT))
    found.begins[of] = of, scopes[0].scope.entries[0]
    for part in scopes:
        assert part.ways is not None
        for at, places in part.ways.after.items():
            found.after[of, at] = [(of, place) for place in places]
        for at, places in part.ways.calls.items():
            found.calls[of, at] = [(of, place) for place in places]
        for place, (at, _) in part.ways.handlers.items():
            found.handlers.setdefault((of, at), []).append((of, place))
    main = scopes[0].ways
    assert main is not None
    for at in main.reached([scopes[0].scope.entries[0]]):
        if any(one == s.Command("End") for one in statements_in(statement_of(look.code[at]))):
            found.ends.append((of, at))
    return True


class _Shared:
    """True of names that programs share and no file's data gives a value: keys in upper case."""

    def __init__(self, given: NameSet) -> None:
        self._given = given
        self._known: dict[str, bool] = {}

    def __call__(self, use: Use) -> bool:
        key = use.variable.key
        if key not in self._known:
            # External variables have `_` as second letter, as some status variables do.
            plain = key[1:2] == "_" and vocabulary.status(key) is None
            self._known[key] = plain and key not in self._given
        return self._known[key]


@dataclass(slots=True)
class _Reader:
    """Adds what the lines of a scope do with shared variables."""

    look: Look
    part: ScopePart
    of: int
    found: _SharedSlots
    by_name: Mapping[str, int]
    shared: Callable[[Use], bool]
    _functions: dict[str, Node] = field(init=False)
    _labels: dict[str, int] = field(init=False)
    _steps: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        scopes = [part.scope for part in self.look.once(scope_parts)]
        self._functions = {
            scope.function.name.upper(): (self.of, scope.entries[0])
            for scope in scopes
            if scope.function is not None
        }
        self._labels = labels_of(self.look.code, self.part.scope.entries)
        self._steps = places_of_steps(self.look.code)

    def _entry(self, target: s.Target) -> Node | None:
        """The line that a jump leads to."""
        place = target.place
        steps, labels = self._steps, self._labels
        at = steps.get(place) if isinstance(place, int) else labels.get(place.upper())
        return None if at is None else (self.of, at)

    def take(self) -> None:
        for at in self.part.scope.entries:
            statement = statement_of(self.look.code[at])
            if statement is not None:
                self._line((self.of, at), statement)

    def _line(self, node: Node, statement: s.Statement) -> None:
        found = self.found
        found.outcomes[node] = outcomes = tuple(self._outcomes(statement))
        called = {entry for outcome in outcomes for entry in outcome.calls}
        if called:
            found.calls[node] = [*dict.fromkeys((*found.calls.get(node, ()), *sorted(called)))]
            others = {of for of, _ in called if of != self.of}
            found.called.setdefault(self.of, set()).update(others)
        ours = [use for use in uses(statement) if self.shared(use)]
        if ours:
            found.reads[node] = [use.variable for use in ours if use.role == "read"]
        for one in statements_in(statement):
            # An `If` sets nothing itself; its branches follow as separate statements.
            for use in () if isinstance(one, s.If) or not ours else filter(self.shared, uses(one)):
                if use.role in ("written", "either"):
                    number = literal(one.value) if isinstance(one, s.Assign) else None
                    found.gives.setdefault(use.variable.key, []).append((node, number))
        match statement:
            case s.Command("Wait", (s.Binary("=", s.Variable(key=key) as name, value),)):
                number = literal(value)
                if number is not None and self.shared(Use(name, "read")):
                    found.waits[node] = key, number

    def _outcomes(self, statement: s.Statement | s.Target | None) -> Iterator[_Branch]:
        """Yield the possible outcomes of a statement, one for each branch through it."""
        match statement:
            case None | s.Target():
                yield _Branch()
            case s.If(condition, then, otherwise) if then is not None:
                asked = self._plain(condition)
                for branch in (then, otherwise):
                    yield from (asked | outcome for outcome in self._outcomes(branch))
            case s.Motion(append=s.Append(during, condition)):
                moved = self._plain(replace(statement, append=None))
                yield from (moved | outcome for outcome in self._outcomes(during))
                if condition is not None:
                    yield moved
            case s.Jump("GoSub", target):
                entry = self._entry(target)
                yield _Branch(calls=() if entry is None else (entry,))
            case s.CallP(program=s.String(name)):
                program = self.found.begins.get(self.by_name.get(program_key(name), -1))
                yield self._plain(statement) | _Branch(calls=() if program is None else (program,))
            case _:
                yield self._plain(statement)

    def _plain(self, node: s.Statement | s.Expression) -> _Branch:
        """Return the certain effects of a node: variables written, functions called."""
        given = (use for use in uses(node) if use.role in ("written", "either"))
        return _Branch(
            frozenset(use.variable.key for use in given if self.shared(use)),
            tuple(
                self._functions[one.key]
                for one in nodes(node)
                if isinstance(one, s.Variable) and one.key in self._functions
            ),
        )


def _starts(
    look: Look, of: int, found: _SharedSlots, by_name: Mapping[str, int]
) -> Iterator[Start]:
    """`XRun` of other slots, by a name or of what the last `XLoad` on a path there has loaded."""
    runs: list[tuple[int, int, str | None]] = []
    loads: dict[int, list[tuple[int, str]]] = {}
    for at, item in enumerate(look.code):
        for statement in statements_in(statement_of(item)):
            match statement:
                case s.Command("XLoad" | "XRun" as word, (first, *rest)):
                    slot = int(literal(first) or 0)
                    named = rest[0] if rest else None
                    written = named.value if isinstance(named, s.String) else None
                    if written is not None:
                        loads.setdefault(at, []).append((slot, written))
                    # Slot 1 runs the main program; a start there is no other task.
                    if word == "XRun" and slot != 1:
                        runs.append((at, slot, written))
    for at, slot, own in runs:
        for name in _loaded(found, (of, at), slot, loads) if own is None else [own]:
            program = by_name.get(program_key(name), -1)
            if program in found.begins:
                yield Start((of, at), program, slot, program_key(name))


def _loaded(
    found: _SharedSlots, run: Node, slot: int, loads: Mapping[int, list[tuple[int, str]]]
) -> list[str]:
    """The programs that may be in a slot where it is run, by the lines of its file."""
    names = {at: [name for of, name in rows if of == slot] for at, rows in loads.items()}
    loading = {(run[0], at): named for at, named in names.items() if named}

    def led(at: Node) -> Iterable[Node]:
        # A later `XLoad` of the slot replaces what was loaded before.
        return () if at in loading else found.after[at]

    reached = (named for at, named in loading.items() if run in reachable(found.after[at], led))
    return list(dict.fromkeys(chain.from_iterable(reached)))
