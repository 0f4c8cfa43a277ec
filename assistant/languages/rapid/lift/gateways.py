r"""Sockets whose bytes go by way of a gateway, which a line of texts can be led through.

The routines of `tables/bytes.txt` say with `\Gateway` what is for it. Before that a program and its
gateway say to each other which words they speak.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.told.calls import GATEWAY, instruction_of
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program, TakenNames, Variable, identifier, walk
from assistant.program.rewriting import head, records

GATEWAY_OPTION: Final = GATEWAY
GREETING: Final = "GATEWAY 1"
"""Both say it when a line is open: the number is that of the words that they speak."""


class Gateways:
    """Those of a program. sockets: that need one, in lower case. answer: what one said first."""

    def __init__(self, program: Program) -> None:
        self.sockets: set[str] = set()
        self._routines: set[str] = set()
        for one in program.procedures:
            found = {name for node in walk(one.body) if (name := _gateway_socket(node))}
            if found:
                self.sockets |= found
                self._routines.add(one.name.lower())
        taken = TakenNames((*program.variables, *program.signals, *program.targets))
        self.answer = identifier("gateway_said", taken)

    def variables(self) -> dict[str, Variable]:
        return {self.answer: Variable("text")} if self.sockets else {}

    def greeting(self, socket: str) -> Iterator[p.Statement]:
        """Behind what opens a socket that needs one."""
        if socket.lower() in self.sockets:
            answer = e.Name(self.answer)
            yield p.Send(socket, "line", (e.Text(GREETING),))
            yield p.Assign(answer, e.Apply("received", (e.Text(socket),)))
            other = e.Binary("<>", answer, e.Text(GREETING))
            yield p.If((p.Branch(other, (p.Stop(end=True),)),))

    def tell(self, program: Program, findings: Findings) -> None:
        """At each statement that sends or takes bytes."""
        for node in program.statements():
            if node.span is not None and any(map(self._is_used, records(head(node)))):
                with findings.at(node.span):
                    findings.append(rules.GATEWAY())

    def _is_used(self, part: Any) -> bool:
        match part:
            case p.Call(name) | e.Apply(name):
                return name.lower() in self._routines
        return False


def _gateway_socket(node: p.Statement) -> str:
    """The socket that a text says something for a gateway to, in lower case; else nothing."""
    if not isinstance(node, p.Opaque) or f"\\{GATEWAY_OPTION}" not in node.text.lower():
        return ""
    match instruction_of(node):
        case s.ProcedureCall(arguments=(s.Positional(s.NameRef(name)), *_)):
            return name.lower()
    return ""
