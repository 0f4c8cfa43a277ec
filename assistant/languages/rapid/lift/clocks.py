"""Clocks: timers of the pseudo-program where possible, and for other languages timers with a sum.

`ClkReset` stops a clock and sets it to 0, `ClkStart` lets it run on, `ClkStop` holds it; started
twice it runs on (RAPID reference manual, instructions). A clock that is only restarted and read is
a timer. Any other clock is lifted as a vendor statement. Other languages get a timer and two
variables for it, the seconds that it ran before and 1 while it runs, so that the clock `c` reads
`c_ran + c_runs * elapsed(c)`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names, lists, nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import declared
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier
from assistant.program.rewriting import Body, map_bodies, map_head
from assistant.program.statement_index import names_in_procedures
from assistant.program.vendor_statements import effect_of

CLOCK_TYPE: Final = "clock"
_READ_FUNCTION: Final = "clkread"


def timer_clocks(modules: Sequence[s.Module]) -> frozenset[str]:
    """Lower-case names of the clocks that are timers: of a module, restarted and read only."""
    items = tuple(item for module in modules for item in module.items)
    data = [item for item in items if isinstance(item, s.Data)]
    found = {item.name.lower() for item in data if _is_clock(item)}
    if not found:
        return frozenset()
    # Every mention must be a reading or a part of a restart.
    named: Counter[str] = Counter()
    meant: Counter[str] = Counter()
    for node in nodes(items):
        match node:
            case s.NameRef(name):
                named[name.lower()] += 1
            case s.FunctionCall() if (clock := _read_clock(node)) is not None:
                meant[clock] += 1
    routines = [item for item in items if isinstance(item, s.Routine)]
    started: set[str] = set()
    for body in chain.from_iterable(map(lists, routines)):
        for pair in pairwise(body):
            if (again := restarted_clock(pair)) is not None:
                # The restart mentions the clock twice.
                meant[again.name.lower()] += 2
                started.add(again.name.lower())
    declared = Counter(item.name.lower() for item in data)
    alone = started & found - {name.lower() for name in inner_names(routines)}
    return frozenset(n for n in alone if declared[n] == 1 and named[n] == meant[n])


def restarted_clock(nodes: Sequence[s.Node]) -> s.NameRef | None:
    """The clock that `ClkReset c; ClkStart c;` restarts."""
    match nodes:
        case (
            s.ProcedureCall(str(reset), (s.Positional(s.NameRef(name) as clock, None),)),
            s.ProcedureCall(str(start), (s.Positional(s.NameRef(same), None),)),
        ) if (reset.lower(), start.lower(), name.lower()) == ("clkreset", "clkstart", same.lower()):
            return clock
    return None


def _read_clock(node: s.FunctionCall) -> str | None:
    """The lower-case name of the clock that `ClkRead(c)` reads."""
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(name), None),)) if (
            word.lower() == _READ_FUNCTION
        ):
            return name.lower()
    return None


def _is_clock(item: s.Data) -> bool:
    plain = item.storage == "VAR" and item.scope != "TASK" and item.value is None
    return plain and item.type.lower() == CLOCK_TYPE and not item.dimensions


_PREDEFINED_CLOCKS: Final = ("clock1",)
"""Those that every controller has, in lower case (user.sys)."""
_STOPPED: Final = e.Number(0)
RUNNING: Final = e.Number(1)
_HIGH_RESOLUTION: Final = "highres"


@dataclass(frozen=True, slots=True)
class _Stopwatch:
    """timer: its name. ran: seconds before it was started last. runs: 1 while it does, else 0."""

    timer: str
    ran: e.Name
    runs: e.Name

    @property
    def now(self) -> e.Expression:
        running = e.Binary("*", self.runs, e.Elapsed(self.timer))
        return e.Binary("+", self.ran, running)

    def variables(self) -> dict[str, Variable]:
        return {name.name: Variable("number", _STOPPED) for name in (self.ran, self.runs)}


_Stopwatches = Mapping[str, _Stopwatch]
"""By lower-case name."""


def with_stopwatches(program: Program, findings: Findings) -> Program:
    """The program whose clocks are timers with what they counted before."""
    named = {
        d: name for d in program.declarations if (name := _declared_clock(verbatim.items, d.text))
    }
    own = [tuple(_declared_clocks(procedure)) for procedure in program.procedures]
    taken = TakenNames(declared(program))
    predefined = [
        name
        for name in _PREDEFINED_CLOCKS
        if name not in taken.lower and _uses_undeclared_clock(program, name)
    ]
    if not named and not any(own) and not predefined:
        return program

    def clock(name: str) -> _Stopwatch:
        names = []
        for stem in (name, f"{name}_ran", f"{name}_runs"):
            # The timer keeps the clock's name if nothing else has it.
            free = stem if stem is name and stem.lower() not in taken.lower else None
            names.append(free or identifier(stem, taken))
            taken.add(names[-1])
        timer, ran, runs = names
        return _Stopwatch(timer, e.Name(ran), e.Name(runs))

    known = {name.lower(): clock(name) for name in (*named.values(), *predefined)}
    procedures = [
        _with_stopwatches_in_procedure(
            q, known, {name.lower(): clock(name) for name in names}, findings
        )
        for q, names in zip(program.procedures, own, strict=True)
    ]
    variables = dict(chain.from_iterable(c.variables().items() for c in known.values()))
    return replace(
        program,
        declarations=tuple(d for d in program.declarations if d not in named),
        variables={**program.variables, **variables},
        procedures=tuple(procedures),
    )


def _uses_undeclared_clock(program: Program, name: str) -> bool:
    """True if the name refers to a clock that nothing declares."""
    if any(name in effect_of(one).names for one in program.declarations):
        return False
    return any(name == one.lower() for one in names_in_procedures(program))


def _declared_clock(read: Any, text: str) -> str:
    """The name of the clock that a text declares, empty if it is something else."""
    match verbatim.understood(read, text) if CLOCK_TYPE in text.lower() else None:
        case (s.Data(storage="VAR", type=type, name=str(name), dimensions=(), value=None),):
            return name if type.lower() == CLOCK_TYPE else ""
    return ""


def _declared_clocks(procedure: Procedure) -> Iterator[str]:
    for node in procedure.body:
        if isinstance(node, p.Opaque) and (name := _declared_clock(verbatim.statements, node.text)):
            yield name


def _with_stopwatches_in_procedure(
    procedure: Procedure, known: _Stopwatches, own: _Stopwatches, findings: Findings
) -> Procedure:
    """known: of the program. own: of the procedure; they begin anew at each call."""
    hidden = {n.lower() for n in (*procedure.variables, *(q.name for q in procedure.parameters))}
    clocks = {**{n: c for n, c in known.items() if n not in hidden}, **own}
    if not clocks:
        return procedure
    body = tuple(
        n for n in procedure.body
        # The declaration goes: its variables take its place.
        if not (isinstance(n, p.Opaque) and _declared_clock(verbatim.statements, n.text))
    )  # fmt: skip
    variables = dict(chain.from_iterable(c.variables().items() for c in own.values()))
    said = _StopwatchLowering(clocks, findings).body(body)
    return replace(procedure, body=said, variables={**procedure.variables, **variables})


class _StopwatchLowering:
    def __init__(self, clocks: _Stopwatches, findings: Findings) -> None:
        self.clocks, self.findings = clocks, findings

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            made += self.statement(node, made)
        return tuple(made)

    def statement(self, node: p.Statement, before: list[p.Statement]) -> Iterator[p.Statement]:
        match self.asked(node):
            case "clkreset", clock:
                yield p.Assign(clock.ran, _STOPPED, span=node.span)
                yield p.Assign(clock.runs, _STOPPED, span=node.span)
            case "clkstart", clock:
                start = p.StartTimer(clock.timer, span=node.span)
                runs = p.Assign(clock.runs, RUNNING, span=node.span)
                # A clock that is known to stand needs no question.
                if before and before[-1] == p.Assign(clock.runs, _STOPPED):  # it was just reset
                    before.pop()
                    yield from (start, runs)
                else:
                    # Starting a clock that runs must not set its timer back.
                    stands = e.Binary("=", clock.runs, _STOPPED)
                    yield p.If((p.Branch(stands, (start, runs)),), span=node.span)
            case "clkstop", clock:
                yield p.Assign(clock.ran, clock.now, span=node.span)
                yield p.Assign(clock.runs, _STOPPED, span=node.span)
            case _:
                with self.findings.at(node.span):
                    said = map_head(node, self.expression)
                yield map_bodies(said, self.body)

    def asked(self, node: p.Statement) -> tuple[str, _Stopwatch] | None:
        """Return the clock instruction of a statement and its clock, None for any other
        statement.
        """
        if not isinstance(node, p.Opaque) or not node.text.lower().startswith("clk"):
            return None
        match verbatim.understood(verbatim.statements, node.text):
            case (s.ProcedureCall(str(word), (s.Positional(s.NameRef(name), None),)),):
                clock = self.clocks.get(name.lower())
                return None if clock is None else (word.lower(), clock)
        return None

    def expression(self, x: e.Expression) -> e.Expression:
        match x:
            case e.Apply(function, (e.Name(name),)) if function.lower() == "clkread":
                clock = self.clocks.get(name.lower())
                return x if clock is None else clock.now
            case e.Verbatim(verbatim.LANGUAGE, text) if text.lower().startswith("clkread("):
                clock = self._finely(text)
                if clock is not None:
                    self.findings.append(rules.LEFT_OUT(
                        what=r"\HighRes", loss="the clock is read in the units of the timer there",
                        cure="none is needed where milliseconds do",
                    ))  # fmt: skip
                    return clock.now
        return x

    def _finely(self, text: str) -> _Stopwatch | None:
        r"""The clock of `ClkRead(c\HighRes)`."""
        match verbatim.understood(verbatim.expression, text):
            case s.FunctionCall(
                str(), (s.Positional(s.NameRef(name), None), s.Option(option, None))
            ) if option.lower() == _HIGH_RESOLUTION:
                return self.clocks.get(name.lower())
        return None
