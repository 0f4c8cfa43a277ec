r"""Pulses that `PulseDO \High` does not have: to 0, or to a value that is worked out.

The output is set, and set back by `SetDO \SDelay` while the program goes on. Reference manual of
instructions: SetDO, PulseDO.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar, Final

from assistant.languages.rapid.lower.expressions import Expressions
from assistant.languages.rapid.lower.names import NAMES
from assistant.languages.rapid.tables.words import LONGEST_PULSE, SHORTEST_PULSE
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.program import Program
from assistant.program.rewriting import is_repeatable, records
from assistant.program.statement_index import records_in_procedures

ON: Final = e.Number(1)


def with_pulses(job: Legalisation) -> Program:
    """The program with such pulses as two instructions."""
    pulses = (
        one for one in records_in_procedures(job.program, p.SetSignal) if one.pulse is not None
    )
    if all(one.value == ON for one in pulses):
        return job.program
    said = _Pulses(job)
    return replace(job.program, procedures=tuple(map(said.procedure, job.program.procedures)))


class _Pulses(Rewording):
    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        self.names = NAMES.naming(job.program)
        self.signals = {name.lower(): one for name, one in job.program.signals.items()}

    def pulse(self, node: p.SetSignal) -> Iterator[p.Statement]:
        signal = self.signals.get(node.signal.lower())
        plain = signal is None or signal.kind == "digital"
        seconds = None if node.pulse is None else e.plain_number(node.pulse)
        short = seconds is None or SHORTEST_PULSE <= seconds <= LONGEST_PULSE
        plain = plain and short and self.is_steady(node.value)
        if node.pulse is None or node.value == ON or not plain:
            yield node
            return
        yield replace(node, pulse=None)
        back = e.Binary("-", ON, node.value)
        if isinstance(node.value, e.Number):
            back = e.Number(1 - node.value.value)  # type: ignore[assignment]
        lower = Expressions(self.names, self.names.value).lower
        call = s.ProcedureCall(
            "SetDO",
            (
                s.Option("SDelay", lower(node.pulse)),
                s.Positional(s.NameRef(self.names.get("signals", node.signal))),
                s.Positional(lower(back)),
            ),
        )
        text = verbatim.of_node(call, "statements")
        yield p.Opaque(verbatim.LANGUAGE, text, span=node.span)

    def is_steady(self, value: e.Expression) -> bool:
        """True if the value may be worked out twice."""
        names = {x.name.lower() for x in records(value) if isinstance(x, e.Name)}
        return is_repeatable(value) and names.isdisjoint(self.signals)

    changes: ClassVar[Changes] = {p.SetSignal: pulse}
