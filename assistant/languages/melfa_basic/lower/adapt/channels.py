"""Channels with the numbers of files, and the communication lines that ports of TCP/IP are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

from assistant.base.diagnostics import Diagnostic
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables.channels import (
    ETHERNET_LINES,
    FILE_NUMBERS,
    LONGEST_FILE_NAME,
    line_name,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names
from assistant.program.analysis.io_use import channels_open_together
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.program import Program
from assistant.program.pseudo.expressions import expression_text


def with_channels(job: Legalisation) -> Program:
    """The program with numbered channels to lines and files."""
    program = job.program
    if not undeclared_names.channels(program):
        return program
    reworded = _NumberedChannels(job)
    procedures = tuple(map(reworded.procedure, program.procedures))
    made = replace(program, procedures=procedures)
    numbers = undeclared_names.numbered_channels(made, FILE_NUMBERS, channels_open_together)
    return undeclared_names.with_channels_renamed(
        made, {n: undeclared_names.name_of_channel(k) for n, k in numbers.items()}
    )


class _NumberedChannels(Rewording):
    """lines: those of channels that no line was stated for, by the channel's lower-case name."""

    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        self.numbers = undeclared_names.numbered_channels(
            job.program, FILE_NUMBERS, channels_open_together
        )
        self.lines: dict[str, int] = {}
        self.told: set[str] = set()
        places = ((x.kind, x.place) for x in job.program.statements() if isinstance(x, p.Attach))
        self.taken = set[int]()
        for place in places:
            match place:
                case (("line" | "serial"), (e.Number(number),)):
                    self.taken.add(int(number))

    def attach(self, node: p.Attach) -> Iterator[p.Statement]:
        if node.channel.lower() not in self.numbers:
            self.job.cannot(f"more than {len(FILE_NUMBERS)} channels at once", "open fewer of them")
        match node.kind, node.place:
            case "file", (place,):
                yield p.Attach(node.channel, "file", (self.file(place),), node.mode)
            case "serial", (e.Number(number),):
                role = "is serial, as the other controller's is"
                self.tell(node.channel, int(number), role, 'COMDEV(n)="RS232" and its speed')
                yield p.Attach(node.channel, "line", node.place)
            case "server", (port, *_):
                role = f"listens at port {expression_text(port)}"
                yield self.line(node, role, "1", port)
            case "client", (host, port):
                role = f"connects to {expression_text(host)}, port {expression_text(port)}"
                where = f"0, NETHSTIP(n)={expression_text(host)}"
                yield self.line(node, role, where, port)
            case _:
                yield node

    def file(self, place: e.Expression) -> e.Expression:
        """The name of a file without its folder, of which there are none."""
        if not isinstance(place, e.Text):
            self.told_once(rules.FILE_NAMED(given=expression_text(place), name="that text"))
            return place
        name = place.value.replace("\\", "/").rpartition("/")[2].rpartition(":")[2].upper()
        if not 0 < len(name) <= LONGEST_FILE_NAME:
            what = (
                f"a file named `{place.value}`, whose name has not 1 to {LONGEST_FILE_NAME} letters"
            )
            self.job.cannot(what, "give it a shorter name")
        if name != place.value:
            self.told_once(rules.FILE_NAMED(given=place.value, name=f"`{name}`"))
        return e.Text(name)

    def line(self, node: p.Attach, role: str, mode: str, port: e.Expression) -> p.Statement:
        """A communication line for a port, with the parameters that make it one."""
        key = node.channel.lower()
        if key not in self.lines:
            free = (n for n in ETHERNET_LINES if n not in {*self.taken, *self.lines.values()})
            number = next(free, None)
            if number is None:
                self.job.cannot(f"more than {len(ETHERNET_LINES)} ports", "open fewer of them")
                return node
            self.lines[key] = number
        number = self.lines[key]
        parameters = 'COMDEV(n)="OPT1n", CPRCE1n=2, NETMODE(n)='
        parameters += f"{mode}, NETPORT({number + 1})={expression_text(port)}"
        self.tell(node.channel, number, role, parameters)
        return p.Attach(node.channel, "line", (e.Number(number),))

    def tell(self, channel: str, number: int, role: str, parameters: str) -> None:
        """parameters: with n for the number of the line."""
        said = re.sub(r"(?<=[(1])n", str(number), parameters)
        com = line_name(number)
        self.told_once(rules.LINE(name=channel, com=com, role=role, parameters=said))

    def told_once(self, finding: Diagnostic) -> None:
        if finding.message not in self.told:
            self.told.add(finding.message)
            self.job.findings.append(finding)

    changes: ClassVar[Changes] = {p.Attach: attach}
