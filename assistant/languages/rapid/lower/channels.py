"""Channels as files, serial ports and sockets of RAPID.

Each is written in RAPID's own statements, which stay vendor text when they are read again. A text
ends with a carriage return on serial ports and sockets, and with the end of a line in files;
reading goes up to that or to a comma. Reference manual of instructions: Open, Write, SocketAccept;
of functions: ReadStr, ReadNum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from typing import Any, ClassVar, Final

from assistant.languages.rapid.lift.expressions import verbatim_of
from assistant.languages.rapid.lower.expressions import NAMES, Expressions
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names
from assistant.program.analysis.declared_types import is_value
from assistant.program.passes.legalisation import Changes, Legalisation, Rewording
from assistant.program.passes.operator_texts import lines_of_parts
from assistant.program.program import Declaration, Procedure, Program, Variable
from assistant.program.rewriting import rewrite

_TEXT_END: Final = "\r"
_LONGEST_TEXT: Final = 79
"""Characters of a text, which has room for its end in the 80 of a string."""
_HOME_FOLDER: Final = "HOME:"
_FOR_EVER: Final = s.Option("Time", s.NameRef("WAIT_MAX"))
_SOCKET_STATUS: Final = ("SocketGetStatus", "SOCKET_CONNECTED")
_STATUS_COMPARISONS: Final = {("=", 1): "=", ("<>", 0): "=", ("=", 0): "<>", ("<>", 1): "<>"}
"""Comparisons of `connected` with 0 or 1, and the operator of the same comparison on the status of
a socket.
"""


def with_channels(job: Legalisation) -> Program:
    """The program with what RAPID opens, writes and reads in place of its channels."""
    if not undeclared_names.channels(job.program):
        return job.program
    said = _ChannelLowering(job)
    procedures = tuple(map(said.procedure, job.program.procedures))
    made = replace(
        job.program,
        procedures=procedures,
        variables={**job.program.variables, **said.variables},
        declarations=(*job.program.declarations, *said.declarations()),
    )
    return rewrite(made, said.asked)


class _ChannelLowering(Rewording):
    """kinds: of channels by lower-case name. variables: that reading takes."""

    def __init__(self, job: Legalisation) -> None:
        super().__init__(job)
        self.names = NAMES.naming(job.program)
        self.kinds: dict[str, p.ChannelKind] = {}
        self.variables: dict[str, Variable] = {}
        self.inner: dict[str, str] = {}
        for node in job.program.statements():
            if isinstance(node, p.Attach):
                self.kinds.setdefault(node.channel.lower(), node.kind)

    def enter(self, procedure: Procedure) -> None:
        super().enter(procedure)
        self.inner = self.names.inner[procedure.name.lower()]

    def declarations(self) -> Iterator[Declaration]:
        """Files and sockets, which have no value."""
        for name, kind in self.kinds.items():
            sockets = kind in ("server", "client")
            # A server listens on one socket and talks on another.
            made = [name, f"{name}_server"] if kind == "server" else [name]
            for one in made:
                node = s.Data("", "VAR", "socketdev" if sockets else "iodev", one)
                yield Declaration(verbatim.LANGUAGE, verbatim.of_node(node, "items"))

    def asked(self, part: Any) -> Any:
        """A question for the connection, as one for the status of a socket."""
        match part:
            case e.Binary(
                ("=" | "<>") as relation, e.Apply("connected", (e.Text(name),)), e.Number(value)
            ) if (relation, value) in _STATUS_COMPARISONS and self.kinds.get(name.lower()) in (
                "server",
                "client",
            ):
                function, state = _SOCKET_STATUS
                status = e.Apply(function, (e.Name(name.lower()),))
                sign: Any = _STATUS_COMPARISONS[relation, int(value)]
                return e.Binary(sign, status, e.Name(state))
        return part

    # ------------------------------------------------------------------------------ texts

    def node(self, value: e.Expression) -> s.Expression:
        def named(name: str) -> str:
            return self.inner.get(name.lower()) or self.names.value(name)

        return Expressions(self.names, named).lower(value)

    def call(self, word: str, *given: s.Argument) -> p.Opaque:
        node = s.ProcedureCall(word, given)
        return p.Opaque(verbatim.LANGUAGE, verbatim.of_node(node, "statements"))

    def attach(self, node: p.Attach) -> Iterator[p.Statement]:
        channel, given = node.channel.lower(), [s.Positional(self.node(x)) for x in node.place]
        own, server = _named_argument(channel), _named_argument(f"{channel}_server")
        if self.kinds[channel] != node.kind:
            self.job.cannot(f"the channel `{channel}` of two kinds", "give each a name of its own")
        match node.kind, node.place:
            case "file", (place,):
                file = place if isinstance(place, e.Text) else None
                # A path with a drive is complete; any other is in the controller's home folder.
                whole = file is not None and ":" in file.value
                words: tuple[s.Argument, ...] = (
                    s.Positional(s.StringLiteral(_HOME_FOLDER)),
                    s.Option("File", given[0].value),
                )
                mode = s.Option(node.mode.capitalize())
                if whole:
                    yield self.call("Open", *given, own, mode)
                else:
                    yield self.call("Open", *words, own, mode)
            case "serial", (e.Number(number),):
                yield self.call("Open", s.Positional(s.StringLiteral(f"com{number}:")), own)
            case "client", (_, _):
                yield self.call("SocketCreate", own)
                yield self.call("SocketConnect", own, *given, _FOR_EVER)
            case "server", (_, _):
                self.job.changed(
                    "a line that is open before somebody is connected",
                    "one that waits until somebody is",
                    "see that nothing is to be done before that",
                )
                port, address = given
                yield self.call("SocketCreate", server)
                yield self.call("SocketBind", server, address, port)
                yield self.call("SocketListen", server)
                yield self.call("SocketAccept", server, own, _FOR_EVER)
                # One connection at a time: the listening socket is not needed any more.
                yield self.call("SocketClose", server)
            case _:
                self.job.cannot(
                    f"what `{channel}` leads to, which the program does not say",
                    "state the line in the process file: its role, port and address",
                )

    def detach(self, node: p.Detach) -> Iterator[p.Statement]:
        socket = self.kind(node.channel) in ("server", "client")
        yield self.call("SocketClose" if socket else "Close", _named_argument(node.channel.lower()))

    def kind(self, channel: str) -> p.ChannelKind | None:
        found = self.kinds.get(channel.lower())
        if found is None:
            self.job.cannot(f"the channel `{channel}`, which nothing opens", "open it first")
        return found

    def send(self, node: p.Send) -> Iterator[p.Statement]:
        kind, own = self.kind(node.channel), _named_argument(node.channel.lower())
        rows: list[list[e.Expression]] = (
            lines_of_parts(node.parts, _LONGEST_TEXT) if node.parts else [[e.Text("")]]
        )
        for number, row in enumerate(rows, 1):
            # Long texts go out in pieces, of which only the last one ends the line.
            whole = node.kind == "line" and number == len(rows)
            parts: list[e.Expression] = [
                e.Apply("text", (x,)) if is_value(x, self.known) else x for x in row
            ]
            # In files `Write` ends the line itself.
            if whole and kind != "file":
                parts.append(e.Text(_TEXT_END))
            text = self.node(reduce(lambda a, b: e.Binary("+", a, b), parts))
            if kind in ("file", "serial"):
                written: tuple[s.Argument, ...] = (own, s.Positional(text))
                if not whole or kind == "serial":
                    written += (s.Option("NoNewLine"),)
                yield self.call("Write", *written)
            else:
                yield self.call("SocketSend", own, s.Option("Str", text))

    # ---------------------------------------------------------------------------- reading

    def assign(self, node: p.Assign) -> Iterator[p.Statement]:
        match node.value:
            case e.Apply(function, (e.Text(channel),)) if function in e.TAKING:
                kind, number = self.kind(channel), function != "received"
                if kind in ("server", "client"):
                    yield from self.received(node.target, channel.lower(), number)
                    return
                word = "ReadNum" if number else "ReadStr"
                given: tuple[s.Argument, ...] = (s.Option("Delim", s.StringLiteral(",")),)
                given += (_FOR_EVER,) if kind == "serial" else ()
                call = s.FunctionCall(word, (_named_argument(channel.lower()), *given))
                node = replace(node, value=verbatim_of(call))
        yield node

    def received(self, target: e.Expression, channel: str, number: bool) -> Iterator[p.Statement]:
        """Character by character, up to the end of the text."""
        text, last, read = (e.Name(f"{channel}_{word}") for word in ("text", "last", "read"))
        self.variables |= {text.name: Variable("text"), last.name: Variable("text")}
        one = s.Option("ReadNoOfBytes", s.NumberLiteral("1"))
        into = s.Option("Str", s.NameRef(last.name))
        # One byte at a time, as bytes of the next text may have arrived already.
        next_one = self.call("SocketReceive", _named_argument(channel), into, one, _FOR_EVER)
        ends = (e.Binary("<>", last, e.Text(mark)) for mark in (_TEXT_END, ","))
        # The line feed of CR LF belongs to the text before, but arrives with the next one.
        plain = p.Branch(
            e.Binary("<>", last, e.Text("\n")), (p.Assign(text, e.Binary("+", text, last)),)
        )
        yield p.Assign(text, e.Text(""))
        yield next_one
        inside = (p.If((plain,)), next_one)
        yield p.While(reduce(lambda a, b: e.Binary("and", a, b), ends), inside)
        if not number:
            yield p.Assign(target, text)
            return
        self.variables[read.name] = Variable("truth")
        yield p.Assign(read, e.Apply("StrToVal", (text, target)))
        # A text that is no number ends the program, as in the other language.
        yield p.If((p.Branch(e.Unary("not", read), (p.Stop(end=True),)),))

    changes: ClassVar[Changes] = {
        p.Attach: attach,
        p.Detach: detach,
        p.Send: send,
        p.Assign: assign,
    }


def _named_argument(name: str) -> s.Positional:
    return s.Positional(s.NameRef(name))
