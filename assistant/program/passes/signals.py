"""Signals: computed values of outputs, waits for bits, pulses, and the end of a program.

Any number but 0 is 1 in a digital signal, and what a group cannot hold stops the program; a
language may write as many bits of a number as there is room for. An error reports a number that
the bits of a signal cannot hold. Of pulses that begin at once, more than a language has at a time
wait for earlier ones to end. Some controllers begin the next cycle after an end, so an end becomes
a stop in a loop.
"""

from __future__ import annotations

import itertools
from collections import ChainMap
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import read_by_another_name
from assistant.program.passes.legalisation import Legalisation, Outputs, Rewording
from assistant.program.program import Procedure, Program, Signal, ValueType, Variable
from assistant.program.rewriting import Body, map_bodies
from assistant.program.statement_index import records_in_procedures

_FOR_GOOD: Final = p.While(e.Number(1), (p.Stop(),))
"""A permanent stop, also after a restart: the program would continue after a single stop."""


def end_for_good(r: Rewording, node: p.Stop) -> Iterator[p.Statement]:
    """A stop in a loop for an end that is one for good."""
    if node.end and r.job.can.ended is not None:
        r.job.findings.append(r.job.can.ended())
        yield replace(_FOR_GOOD, body=(p.Stop(span=node.span),), span=node.span)
    else:
        yield node


_TRUTHS: Final = (*e.RELATIONS, "and", "or")
_ZERO: Final = e.Number(0)


def with_checked_outputs(job: Legalisation) -> Program:
    """The program with a choice of 0 and 1, or a stop behind a group's range, before each.

    One that a language of the same kin said stays as it is.
    """
    program, origin = job.program, job.program.origin
    if origin is not None and origin.language in job.can.kin:
        return program
    taken = {n.lower() for t in (program.variables, program.targets, program.signals) for n in t}
    taken |= {name.lower() for q in program.procedures for name in q.variables}
    shared = _SharedNames.of(program)
    return replace(
        program,
        procedures=tuple(_OutputChecks(shared, q, taken).checked() for q in program.procedures),
    )


def find_outputs_of_two_names(job: Legalisation) -> None:
    """Report outputs that are read by another name than they are set by, for signals known by
    names.
    """
    for statement, name, other in read_by_another_name(job.program):
        with job.findings.at(statement.span):
            job.cannot(
                f"that `{name}` is read, which is set as part of `{other}`",
                "read and set the output by one name, or keep its value in a variable",
            )


@dataclass(frozen=True, slots=True)
class _SharedNames:
    """Names shared by the procedures of a program, in lower case: signals, types of variables and
    of results.
    """

    signals: Mapping[str, Signal]
    kinds: dict[str, ValueType]
    results: Mapping[str, ValueType | None]

    @staticmethod
    def of(program: Program) -> _SharedNames:
        return _SharedNames(
            {name.lower(): signal for name, signal in program.signals.items()},
            {name.lower(): v.type for name, v in program.variables.items()},
            {q.name.lower(): q.result for q in program.procedures},
        )


class _OutputChecks:
    """One procedure. taken: names in lower case that a variable may not have."""

    def __init__(self, shared: _SharedNames, procedure: Procedure, taken: set[str]) -> None:
        self.procedure, self.taken = procedure, taken
        self.signals, self.results = shared.signals, shared.results
        own = {q.name.lower(): q.type for q in procedure.parameters}
        own |= {name.lower(): v.type for name, v in procedure.variables.items()}
        self.kinds = ChainMap(own, shared.kinds)
        self.kept: dict[str, Variable] = {}

    def checked(self) -> Procedure:
        body = self.body(self.procedure.body)
        if body == self.procedure.body:
            return self.procedure
        variables = {**self.procedure.variables, **self.kept}
        return replace(self.procedure, body=body, variables=variables)

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            node = map_bodies(node, self.body)
            parts = self.set(node, made) if isinstance(node, p.SetSignal) else (node,)
            made += (x if x.span else replace(x, span=node.span) for x in parts)
        return tuple(made)

    def set(self, node: p.SetSignal, above: list[p.Statement]) -> Iterator[p.Statement]:
        signal = self.signals.get(node.signal.lower())
        if signal is None or signal.kind == "analog" or self.fits(node.value, signal):
            yield node
        elif signal.kind == "digital":
            one, zero = (replace(node, value=e.Number(n)) for n in (1, 0))
            is_set = p.Branch(e.Binary("<>", node.value, _ZERO), (one,))
            yield p.If((is_set,), (zero,))
        else:
            value = node.value
            if not isinstance(value, e.Name):
                value = self.keep()
                yield p.Assign(value, node.value)
            most = e.Number((1 << signal.bits) - 1)
            outside = e.Binary("or", e.Binary("<", value, _ZERO), e.Binary(">", value, most))
            if not (above and _is_guarded(above[-1], outside)):
                yield p.If((p.Branch(outside, (_FOR_GOOD,)),))
            yield replace(node, value=value)

    def fits(self, value: e.Expression, signal: Signal) -> bool:
        """True if a value is surely a truth, fits into the signal's bits, or is not computed from
        numbers.
        """
        match value:
            case e.Number() | e.Truth() | e.Verbatim() | e.Unary("not"):
                return True
            case e.Binary(operator):
                return operator in _TRUTHS
            case e.Apply(name):
                return self.results.get(name.lower()) == "truth"
            case e.Name(name) if name.lower() not in self.kinds:
                other = self.signals.get(name.lower())
                return other is not None and other.kind != "analog" and other.bits <= signal.bits
            case e.Name(name):
                return self.kinds[name.lower()] == "truth"
        return False

    def keep(self) -> e.Name:
        """Return a local variable of the procedure that holds a value during its check."""
        if not self.kept:
            free = (f"out_{n}" for n in itertools.count(1))
            name = next(n for n in free if n not in self.taken)
            self.taken.add(name)
            self.kept[name] = Variable("number")
        return e.Name(next(iter(self.kept)))


def _is_guarded(node: p.Statement, outside: e.Expression) -> bool:
    """True if a statement stops the program for a condition: the value is checked already."""
    match node:
        case p.If((p.Branch(condition, (stop,)),), ()):
            return condition == outside and stop == _FOR_GOOD
    return False


def wait_signal(r: Rewording, node: p.WaitSignal) -> Iterator[p.Statement]:
    """One for another value than a number, or for an analog signal, is a wait for a condition."""
    if isinstance(node.value, e.Number) and not _is_analog(r, node.signal):
        check_fit(r, node.signal, node.value)
        yield node
    else:
        condition = e.Binary("=", e.Name(node.signal), node.value)
        yield p.WaitUntil(condition, node.timeout, span=node.span)


def wait_until(r: Rewording, node: p.WaitUntil) -> Iterator[p.Statement]:
    """One for bits of a signal and a number is a wait for the signal."""
    match node.condition:
        case e.Binary("=", e.Name(name)) if _is_analog(r, name):
            # An analog signal has no bits to wait for.
            yield node
        case e.Binary("=", e.Name(name), e.Number() as value) if r.spelling.signal(name):
            check_fit(r, name, value)
            yield p.WaitSignal(name, value, node.timeout, span=node.span)
        case e.Name(name) if r.spelling.signal(name):
            yield p.WaitSignal(name, e.Number(1), node.timeout, span=node.span)
        case _:
            yield node


def _is_analog(r: Rewording, name: str) -> bool:
    signal = r.spelling.signal(name)
    return signal is not None and signal.kind == "analog"


def check_fit(r: Rewording, name: str, value: e.Expression) -> None:
    """An error where a digital signal or a group is to have what its bits cannot hold."""
    signal, rule = r.spelling.signal(name), r.job.can.no_fit
    if signal is None or signal.kind == "analog" or not isinstance(value, e.Number):
        return
    most = (1 << signal.bits) - 1
    if rule and not (0 <= value.value <= most and value.value == int(value.value)):
        bits = "1 bit" if signal.bits == 1 else f"{signal.bits} bits"
        r.job.findings.append(rule(bits=bits, name=name, value=value.value, most=most))


_NO_TIME = p.SetSignal | p.Assign | p.Comment
"""Statements between which pulses do not end."""


def with_few_pulses(job: Legalisation) -> Program:
    """The program in which no more pulses run beside one another than the language has.

    One more waits until the first of them has ended.
    """
    can = job.can.outputs
    if can is None or can.most_pulses is None:
        return job.program
    pulses = [
        one for one in records_in_procedures(job.program, p.SetSignal) if one.pulse is not None
    ]
    if len(pulses) <= can.most_pulses:
        return job.program

    def waiting(body: Body) -> Body:
        made: list[p.Statement] = []
        row: list[p.Statement] = []
        for node in body:
            if isinstance(node, _NO_TIME):
                row.append(node)
                continue
            made += (*_waiting(job, can, row), map_bodies(node, waiting))
            row = []
        return (*made, *_waiting(job, can, row))

    procedures = tuple(replace(q, body=waiting(q.body)) for q in job.program.procedures)
    return replace(job.program, procedures=procedures)


def _waiting(job: Legalisation, can: Outputs, row: list[p.Statement]) -> Iterator[p.Statement]:
    """Statements that take no time together."""
    pulses = [one for one in row if isinstance(one, p.SetSignal) and one.pulse is not None]
    most = can.most_pulses or len(pulses)
    values = [one.value for one in pulses]
    names = {one.signal.lower() for one in pulses}
    # A pulse that begins anew, or an unknown value, has no sure end to wait for.
    if len(pulses) <= most or len(names) < len(pulses) or not all(map(_is_plain, values)):
        yield from row
        return
    # Each pulse over the limit waits for the one that began that many before.
    later = {id(one): before for before, one in zip(pulses, pulses[most:], strict=False)}
    for node in row:
        before = later.get(id(node))
        if before is not None and isinstance(node, p.SetSignal):
            # A pulse ends by going back to the opposite value.
            ended = e.Number(int(before.value == e.Number(0)))
            yield p.WaitSignal(before.signal, ended, span=node.span)
            if can.waiting is not None:
                with job.findings.at(node.span):
                    told = can.waiting(name=node.signal, before=before.signal, most=most)
                    job.findings.append(told)
        yield node


def _is_plain(value: e.Expression) -> bool:
    return value in (e.Number(0), e.Number(1))
