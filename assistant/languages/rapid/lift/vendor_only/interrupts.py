"""Interrupts of RAPID, as conditions that are watched and procedures that answer them.

`ISignalDI door,1,opened;` interrupts when the signal changes to 1. Other languages watch whether a
condition holds: that the signal differs from its last value. The procedure that is called first
stores the new value, and calls the trap routine if the change is one to 1. A started timer and a
persistent variable are watched in the same way.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.patterns import Called
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver
from assistant.languages.rapid.lift.vendor_only import waits
from assistant.languages.rapid.lift.vendor_statements import instruction_of
from assistant.languages.rapid.tables.signals import SIGNAL_TYPES
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import with_used_signals
from assistant.program.analysis.uses import called as calls_of
from assistant.program.analysis.uses import declared, names_in
from assistant.program.program import (
    Procedure,
    Program,
    TakenNames,
    ValueType,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import (
    Body,
    map_bodies,
    records,
    rewrite,
    with_vendor_statements_replaced,
)
from assistant.program.statement_index import records_in_procedures
from assistant.program.undeclared_names import interrupts

Call = Called[s.Expression]
_LEVELS: Final = {"low": 0.0, "high": 1.0, "edge": 2.0}
_EDGE_LEVEL: Final = 2.0
_SIGNAL_ORDERS: Final = {
    f"isignal{letters[-2:]}": signal for letters, signal in SIGNAL_TYPES.items()
}
"""By the instruction in lower case, what its signal is."""
_SINGLE_INSTRUCTIONS: Final = frozenset(("idelete", "isleep", "iwatch"))
_GLOBAL_INSTRUCTIONS: Final = {"idisable": "off", "ienable": "on"}
BROKEN_OFF: Final = e.Reason(
    "the move that the interrupt came in is not made to its end, and the program goes on",
    "end the cycle behind it with ExitCycle, or search with SearchL",
)
_CLEAR_PATH: Final = re.compile(r"ClearPath\b", re.IGNORECASE)
_RAISE_WORD: Final = re.compile(r"\bRAISE\b", re.IGNORECASE)
_ORDERS: Final = frozenset((*_SIGNAL_ORDERS, "itimer", "ipers"))


@dataclass(frozen=True, slots=True)
class _Watch:
    """One order of one interrupt.

    begin: what is done where it is ordered, or goes on after a sleep. holds: when its procedure is
    called. noted: what that does first. counts: whether it then is an interrupt, None for always.
    """

    begin: Body
    holds: e.Expression
    noted: Body
    counts: e.Expression | None = None


@dataclass(frozen=True, slots=True)
class _Ordered:
    """name: of the interrupt. trap: the routine that answers it."""

    name: str
    trap: str
    watch: _Watch
    single: bool


def with_interrupts(program: Program, findings: Findings) -> Program:
    """Return the program that watches for its interrupts. Interrupts without an equivalent remain
    vendor statements.
    """
    asked = [node for node in program.statements() if _interrupt_instruction(node) is not None]
    if not asked:
        return program
    return _InterruptLowering(program, findings).said()


def _interrupt_instruction(node: p.Statement) -> tuple[str, str, Call | s.Connect] | None:
    """The word of an instruction in lower case, its interrupt, and itself."""
    if not isinstance(node, p.Opaque):
        return None
    match verbatim.understood(verbatim.statements, node.text):
        case (s.Connect(variable) as connect,):
            name = _interrupt_name(variable)
            return None if name is None else ("connect", name, connect)
    call = instruction_of(node)
    found = None if call is None else called(call)
    if found is None:
        return None
    word = found.word.lower()
    if word in _GLOBAL_INSTRUCTIONS and not found.given:
        return word, "", found
    # The interrupt is the last argument of each.
    if (word in _SINGLE_INSTRUCTIONS or word in _ORDERS) and found.given:
        last = found.given[-1]
        name = None if last is None else _interrupt_name(last)
        return None if name is None else (word, name, found)
    return None


def _interrupt_name(node: s.Expression) -> str | None:
    """Return the name of an interrupt: its variable, with the number of an element."""
    match node:
        case s.NameRef(name):
            return name
        case s.Element(s.NameRef(name), (index,)):
            number = None if isinstance(index, s.Whole) else literal_number(index)
            return None if number is None else f"{name}_{number:g}"
    return None


class _InterruptLowering:
    """traps: what each interrupt is connected to, orders: how it is ordered, by lower-case name."""

    def __init__(self, program: Program, findings: Findings) -> None:
        self.program, self.findings = program, findings
        self.meaning = NameResolver()
        self.taken = TakenNames(declared(program))
        self.variables: dict[str, Variable] = {}
        self.procedures: list[Procedure] = []
        self.traps: dict[str, dict[str, None]] = {}
        self.orders: dict[str, dict[str, tuple[str, Call]]] = {}
        self.known = {q.name.lower(): q for q in program.procedures}
        given = {q.name.lower() for r in program.procedures for q in r.parameters}
        self.kept = given | {n.lower() for r in program.procedures for n in r.variables}
        """Interrupts that stay as their text, by lower-case name."""
        self.names = TakenNames()
        """Names of interrupts, separate from all other names."""
        self.answers: dict[str, str] = {}
        self._gather()
        self.made: dict[str, list[_Ordered]] = {}
        for key, orders in self.orders.items():
            self._make(key, list(orders.values()))

    def _gather(self) -> None:
        for node in self.program.statements():
            match _interrupt_instruction(node):
                case "connect", name, s.Connect(trap=trap):
                    self.traps.setdefault(name.lower(), {})[trap.lower()] = None
                case word, name, Called() as call if word in _ORDERS:
                    assert isinstance(node, p.Opaque)
                    orders = self.orders.setdefault(name.lower(), {})
                    # Equal orders in several places are one interrupt.
                    orders.setdefault(node.text.lower(), (name, call))

    def _make(self, key: str, orders: list[tuple[str, Call]]) -> None:
        """The interrupts that one variable stands for, one for each way in which it is ordered."""
        traps = list(self.traps.get(key, ()))
        # A variable that is connected to several routines would need to know which one is
        # connected.
        if len(traps) != 1 or not self._can_answer(traps[0]):
            self.kept.add(key)
            return
        made = []
        for name, call in orders:
            own = identifier(name, self.names)
            self.names.add(own)
            watch = _WATCHES[call.word.lower()](self, call, own)
            if watch is None:
                self.kept.add(key)
                return
            single = bool(call.options.keys() & {"single", "singlesafe"})
            made.append(_Ordered(own, self.known[traps[0]].name, watch, single))
        self.made[key] = made

    def _can_answer(self, trap: str) -> bool:
        """True if nothing in a trap routine raises an error."""
        pending, seen = [trap], set[str]()
        while pending:
            procedure = self.known.get(key := pending.pop())
            if procedure is None or key in seen:
                if key == trap and procedure is None:
                    return False
                continue
            seen.add(key)
            pending += calls_of(procedure)
            for node in walk(procedure.body):
                if isinstance(node, p.Opaque) and _RAISE_WORD.search(node.text):
                    return False
        return True

    # ------------------------------------------------------------------------- what is watched

    def place(self, given: s.Expression | None) -> e.Expression | None:
        """Return the variable that an expression names, None for any other expression."""
        value = None if given is None else self.meaning.expression(given)
        return value if isinstance(value, e.Name | e.Member | e.Index) else None

    def variable(self, name: str, type: ValueType = "number") -> e.Name:
        """A variable that is made, by the name that is wanted."""
        own = identifier(name, self.taken)
        self.taken.add(own)
        self.variables[own] = Variable(type)
        return e.Name(own)

    def signal(self, call: Call, name: str) -> _Watch | None:
        """A signal that changes to a value, or at all."""
        match call.given:
            case (s.NameRef(signal), value, _) if (level := _level_number(value)) is not None:
                pass
            case (s.NameRef(signal), _):
                level = _EDGE_LEVEL
            case _:
                return None
        self.meaning.used.append((signal, _SIGNAL_ORDERS[call.word.lower()]))
        watch = self.changing(e.Name(signal), f"{name}_seen")
        # Any change counts.
        if level == _EDGE_LEVEL:
            return watch
        (note,) = watch.noted
        assert isinstance(note, p.Assign)
        return replace(watch, counts=e.Binary("=", note.target, e.Number(level)))

    def persistent(self, call: Call, name: str) -> _Watch | None:
        data = self.place(call.given[0]) if len(call.given) == 2 else None
        match data:
            case e.Name(own):
                known = {n.lower(): v for n, v in self.program.variables.items()}.get(own.lower())
                if known is None or known.size or known.type not in ("number", "truth"):
                    return None
                return self.changing(data, f"{name}_seen", known.type)
        return None

    def changing(self, value: e.Expression, name: str, type: ValueType = "number") -> _Watch:
        seen = self.variable(name, type)
        note: Body = (p.Assign(seen, value),)
        return _Watch(note, e.Binary("<>", value, seen), note)

    def timer(self, call: Call, name: str) -> _Watch | None:
        """A time that is over, again and again."""
        if len(call.given) != 2 or call.given[0] is None:
            return None
        seconds = self.meaning.expression(call.given[0])
        clock = identifier(f"{name}_time", self.taken)
        self.taken.add(clock)
        start: Body = (p.StartTimer(clock),)
        begin = start
        # The time is fixed when the timer is ordered, so a computed one is stored.
        if not isinstance(seconds, e.Number):
            after = self.variable(f"{name}_seconds")
            begin = (p.Assign(after, seconds), *start)
            seconds = after
        return _Watch(begin, e.Binary(">=", e.Elapsed(clock), seconds), start)

    # ------------------------------------------------------------------------------ what is said

    def said(self) -> Program:
        program = with_vendor_statements_replaced(self.program, self.statement)
        procedures = [*program.procedures, *self.procedures]
        # The variable of an interrupt goes, unless something else reads it.
        left = {name.lower() for name in names_in(tuple(procedures))}
        told = {
            name: one
            for name, one in program.variables.items()
            if name.lower() not in self.made or name.lower() in left
        }
        return replace(
            program,
            procedures=tuple(procedures),
            variables={**told, **self.variables},
            signals=with_used_signals(program.signals, self.meaning.used),
        )

    def statement(self, node: p.Opaque) -> tuple[p.Statement, ...]:
        asked = _interrupt_instruction(node)
        if asked is None:
            return (node,)
        word, name, call = asked
        key = name.lower()
        if word in _GLOBAL_INSTRUCTIONS:
            return (p.SwitchInterrupts("off" if word == "idisable" else "on", span=node.span),)
        if key in self.kept:
            return (node,)
        made = self.made.get(key, [])
        said: list[p.Statement] = []
        if word == "connect":
            for one in made:
                answer = p.Call(self._answer(one, node))
                said.append(p.Interrupt(one.name, one.watch.holds, answer))
            with self.findings.at(node.span):
                self.findings.append(rules.INTERRUPTED(name=name))
        elif word in _ORDERS:
            assert isinstance(call, Called)
            at = list(self.orders[key]).index(node.text.lower())
            said += self._on(made[at])
        elif word == "iwatch":
            # IWatch does not say which of several orders goes on.
            if len(made) != 1:
                return (node,)
            said += self._on(made[0])
        else:
            said += (p.SwitchInterrupt(one.name, "off") for one in made)
        return tuple(replace(one, span=node.span) for one in said)

    def _on(self, made: _Ordered) -> Iterator[p.Statement]:
        yield from made.watch.begin
        yield p.SwitchInterrupt(made.name, "on")

    def _answer(self, made: _Ordered, node: p.Opaque) -> str:
        """The procedure that an interrupt calls, which calls the trap routine."""
        name = self.answers.get(made.name)
        if name is None:
            name = self.answers[made.name] = identifier(f"{made.name}_came", self.taken)
            self.taken.add(name)
            inner: Body = (p.Call(made.trap),)
            if made.single:
                # Switched off first: the trap routine may order it again.
                inner = (p.SwitchInterrupt(made.name, "off"), *inner)
            counts = made.watch.counts
            then = inner if counts is None else (p.If((p.Branch(counts, inner),)),)
            self.procedures.append(Procedure(name, (*made.watch.noted, *then), span=node.span))
        return name


def with_moves_ended_by_interrupts(program: Program) -> Program:
    """The program in which `ClearPath` stays where an interrupt does not end the cycle with it.

    Elsewhere the arm would go on to the end of the move that the interrupt came in.
    """
    going_on = {
        one.call.procedure.lower()
        for one in records_in_procedures(program, p.Interrupt)
        if one.ends is None
    }
    inside = _called_procedures(program, going_on)

    def body(statements: Body) -> Body:
        return tuple(
            replace(node, reason=BROKEN_OFF)
            if isinstance(node, p.Opaque) and _CLEAR_PATH.match(node.text)
            else map_bodies(node, body)
            for node in statements
        )

    procedures = (
        replace(q, body=body(q.body)) if q.name.lower() in inside else q for q in program.procedures
    )
    return replace(program, procedures=tuple(procedures)) if inside else program


def with_interrupt_wait_timers(program: Program) -> Program:
    """Return the program with a separate timer for the timeouts of waits in interrupts."""
    inside = _called_procedures(program, _answer_procedures(program))
    if not inside:
        return program

    def own(part: Any) -> Any:
        match part:
            case e.Elapsed(waits.WAIT_TIMER) | p.StartTimer(waits.WAIT_TIMER):
                return replace(part, timer=f"{waits.WAIT_TIMER}_of_interrupts")
        return part

    procedures = (rewrite(q, own) if q.name.lower() in inside else q for q in program.procedures)
    return replace(program, procedures=tuple(procedures))


def with_interrupt_errors(program: Program, error: e.Name) -> Program:
    """The program whose interrupts leave its error as it was, if they come back.

    error: the number of the error that is on its way to a handler.
    """
    answers = _answer_procedures(program)
    inside = _called_procedures(program, answers)
    used = any(error in records(q) for q in program.procedures if q.name.lower() in inside)
    if not used:
        return program
    before = e.Name(f"{error.name}_before")
    # The interrupt may come between an error and its handler.
    first: Body = (p.Assign(before, error), p.Assign(error, e.Number(0)))
    last: Body = (p.Assign(error, before),)
    procedures = (
        replace(q, body=(*first, *q.body, *last)) if q.name.lower() in answers else q
        for q in program.procedures
    )
    variables = {**program.variables, before.name: Variable("number", e.Number(0))}
    return replace(program, procedures=tuple(procedures), variables=variables)


def _answer_procedures(program: Program) -> set[str]:
    """Return the procedures that interrupts call, in lower case."""
    return {one.call.procedure.lower() for one in interrupts(program)}


def _called_procedures(program: Program, answers: set[str]) -> set[str]:
    """The same with all that this calls."""
    calls = {q.name.lower(): set(calls_of(q)) for q in program.procedures}
    found: set[str] = set()
    while pending := (answers & calls.keys()) - found:
        found |= pending
        answers = set().union(*(calls[name] for name in pending))
    return found


def _level_number(node: s.Expression | None) -> float | None:
    match node:
        case s.NameRef(name):
            return _LEVELS.get(name.lower())
        case None:
            return None
    number = literal_number(node)
    return number if number in _LEVELS.values() else None


_WATCHES: Final[Mapping[str, Callable[[_InterruptLowering, Call, str], _Watch | None]]] = {
    **dict.fromkeys(
        ("isignaldi", "isignaldo", "isignalgi", "isignalgo"), _InterruptLowering.signal
    ),
    **dict.fromkeys(("isignalai", "isignalao"), lambda *_: None),
    "itimer": _InterruptLowering.timer,
    "ipers": _InterruptLowering.persistent,
}
