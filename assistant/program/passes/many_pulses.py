"""Pulses that begin at once: more than a language has at a time wait for earlier ones to end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import records_in_procedures
from assistant.program.passes.legalising import Legalisation, Outputs
from assistant.program.program import Program
from assistant.program.rewriting import Body, map_bodies

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
    if len(pulses) <= most or len(names) < len(pulses) or not all(map(_is_plain, values)):
        yield from row
        return
    later = {id(one): before for before, one in zip(pulses, pulses[most:], strict=False)}
    for node in row:
        before = later.get(id(node))
        if before is not None and isinstance(node, p.SetSignal):
            ended = e.Number(int(before.value == e.Number(0)))
            yield p.WaitSignal(before.signal, ended, span=node.span)
            if can.waiting is not None:
                with job.findings.at(node.span):
                    told = can.waiting(name=node.signal, before=before.signal, most=most)
                    job.findings.append(told)
        yield node


def _is_plain(value: e.Expression) -> bool:
    return value in (e.Number(0), e.Number(1))
