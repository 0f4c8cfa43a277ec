"""Files, serial lines and sockets as channels, for other languages.

A file or a serial line is opened and closed as it is. Of a listening socket only the clients that
it accepts are channels; a socket that connects tries again until the server answers or the time is
over. A file opened for both directions is for writing or reading alone if the program does only
that with it. The state of a socket is kept as a number where the program asks for more than whether
it is connected. A socket of bytes goes through a gateway, with which the program exchanges a
greeting first (option `Gateway` in `tables/bytes.txt`). Text and bytes are the same, in Latin-1.
Reference manual of instructions: Open, Write, WriteStrBin, SocketAccept and their kin; of
functions: ReadStr, ReadNum, SocketGetStatus.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import NameResolver
from assistant.languages.rapid.lift.vendor_statements import (
    GATEWAY,
    NotExpressible,
    Replacement,
    VendorCall,
    instruction_of,
    with_lowered_calls,
)
from assistant.languages.rapid.tables.constants import SOCKET_STATES
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import name_of, nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program import undeclared_names
from assistant.program.program import Procedure, Program, TakenNames, Variable, identifier, walk
from assistant.program.rewriting import (
    Body,
    head,
    map_bodies,
    records,
    rewrite,
    with_vendor_statements_replaced,
)

_WITHOUT_MODE: Final = ("open", "close")


def _file_modes(program: Program) -> Mapping[str, p.ChannelMode]:
    """Which of the two, by lower-case name; without those of which neither is sure."""
    ways: dict[str, set[str]] = {}
    for node in program.statements():
        for part in records(head(node)):
            for word, name in _named_files(part):
                ways.setdefault(name.lower(), set()).add(_access_of(word.lower()))
    modes: dict[str, p.ChannelMode] = {}
    for name, found in ways.items():
        # Opening and closing say nothing about the direction.
        match found - {""}:
            case one if one == {"write"}:
                modes[name] = "write"
            case one if one == {"read"}:
                modes[name] = "read"
    return modes


def _access_of(word: str) -> str:
    """Return the access of an instruction or function to a file that it names: `read`, `write`,
    `both` or empty.
    """
    if word in _WITHOUT_MODE:
        return ""
    return next((way for way in ("write", "read") if word.startswith(way)), "both")


def _named_files(part: Any) -> Iterator[tuple[str, str]]:
    """Yield each routine that names a file, with the name: calls in vendor statements, and other
    calls.
    """
    match part:
        case p.Opaque(verbatim.LANGUAGE, text):
            yield from _files_in_tree(verbatim.understood(verbatim.statements, text))
        case e.Verbatim(verbatim.LANGUAGE, text):
            yield from _files_in_tree(verbatim.understood(verbatim.expression, text))
        case e.Apply(word, arguments) | p.Call(word, arguments):
            for one in arguments:
                if isinstance(one, e.Name):
                    yield word, one.name


def _files_in_tree(tree: Any) -> Iterator[tuple[str, str]]:
    for call in nodes(tree) if tree is not None else ():
        if isinstance(call, s.ProcedureCall | s.FunctionCall) and isinstance(call.name, str):
            for argument in call.arguments:
                if isinstance(argument, s.Positional) and isinstance(argument.value, s.NameRef):
                    yield call.name, argument.value.name


_STATUS_FUNCTION: Final = "socketgetstatus"
_STATE_CHANGES: Final = {
    "socketcreate": (0, 1), "socketconnect": (0, 2), "socketaccept": (1, 2),
    "socketbind": (0, 3), "socketlisten": (0, 4), "socketclose": (0, 5),
}  # fmt: skip
"""By lower-case instruction, the position of its socket argument and the state of the socket
afterwards.
"""


class _SocketStates:
    """names: of the variables of sockets by their lower-case names, where a program asks for more
    than whether one is connected.
    """

    def __init__(self, program: Program) -> None:
        asked: dict[str, str] = {}
        times: Counter[str] = Counter()
        plain: Counter[str] = Counter()
        for part in records((program.procedures, program.variables)):
            match part:
                case e.Apply(function, (e.Name(name),)) if function.lower() == _STATUS_FUNCTION:
                    asked.setdefault(name.lower(), name)
                    times[name.lower()] += 1
                case e.Binary("=" | "<>", e.Apply(function, (e.Name(name),)), e.Name(state)) if (
                    function.lower() == _STATUS_FUNCTION and state.lower() == "socket_connected"
                ):
                    plain[name.lower()] += 1
        # Questions other than for the connection need the state as a number.
        other = {name for name, count in times.items() if count > plain[name]}
        taken = TakenNames((*program.variables, *program.signals, *program.targets))
        self.names = {
            low: identifier(f"{asked[low]}_state", taken) for low in asked if low in other
        }

    def variables(self) -> dict[str, Variable]:
        closed = e.Number(SOCKET_STATES["socket_closed"])
        return {name: Variable("number", closed) for name in self.names.values()}

    def behind(self, word: str, names: list[str]) -> Iterator[p.Statement]:
        """Yield the state change that an instruction makes. names: its arguments, empty for one
        that is not a name.
        """
        place, state = _STATE_CHANGES.get(word, (0, 0))
        own = self.names.get(names[place].lower()) if state and place < len(names) else None
        if own is not None:
            yield p.Assign(e.Name(own), e.Number(state))

    def asked(self, program: Program) -> Program:
        """The program with these variables where it asks for states."""

        def change(part: Any) -> Any:
            match part:
                case e.Apply(function, (e.Name(name),)) if function.lower() == _STATUS_FUNCTION:
                    own = self.names.get(name.lower())
                    return part if own is None else e.Name(own)
            return part

        return rewrite(program, change) if self.names else program


_GATEWAY_OPTION: Final = GATEWAY
_GREETING: Final = "GATEWAY 1"
"""Greeting that both sides send when a connection opens: the number is the version of their
protocol.
"""


class _Gateways:
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
            yield p.Send(socket, "line", (e.Text(_GREETING),))
            yield p.Assign(answer, e.Apply("received", (e.Text(socket),)))
            other = e.Binary("<>", answer, e.Text(_GREETING))
            # Another protocol than the one that is spoken here cannot go on.
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
    if not isinstance(node, p.Opaque) or f"\\{_GATEWAY_OPTION}" not in node.text.lower():
        return ""
    match instruction_of(node):
        case s.ProcedureCall(arguments=(s.Positional(s.NameRef(name)), *_)):
            return name.lower()
    return ""


_CHANNEL_TYPES: Final = frozenset(("iodev", "socketdev"))
_SERIAL: Final = re.compile(r"com([1-8]):", re.IGNORECASE)
MODES: Final[Mapping[str, p.ChannelMode]] = {"read": "read", "write": "write", "append": "append"}
_DEFAULT_TIMEOUT: Final = 60.0
r"""Seconds that a socket waits without `\Time` (reference manual: SocketAccept, SocketConnect)."""
_FOR_EVER: Final = "wait_max"
_LINE_END: Final = re.compile(r"\r\n?\Z|\n\Z")
"""The end of a line behind a text."""

_BYTES_REASON: Final = e.Reason(
    "bytes are read or written, and other controllers have texts of lines alone",
    "send and receive texts that end with a carriage return",
)
_GATEWAY_REASON: Final = e.Reason(
    "bytes go over this socket as well, by way of a gateway", "send and receive bytes alone there"
)
_READ_AND_WRITE_REASON: Final = e.Reason(
    "the file is open for both reading and writing", r"open it with \Read, \Write or \Append"
)
_NO_PORT_REASON: Final = e.Reason(
    "which port the socket listens at is not said by one SocketBind",
    "bind each socket that listens in one place",
)


def with_channels(program: Program, findings: Findings) -> Program:
    """The program with channels for what it opens, writes, reads and closes."""
    ports, modes = _bound_ports(program), _file_modes(program)
    states, gateways = _SocketStates(program), _Gateways(program)

    def said(call: VendorCall, node: p.Statement) -> Replacement:
        word = call.word
        names = [name_of(one) for one in call.call.given]
        if word in _PREPARING:
            # Refuses a socket that is no name, before the instruction is left out.
            call.name(0)
            with findings.at(node.span):
                loss, cure = _OMITTED_LOSS
                findings.append(rules.LEFT_OUT(what=call.call.word, loss=loss, cure=cure))
            yield from states.behind(word, names)
            return
        accepts, by_gateway = word == "socketaccept", _GATEWAY_OPTION in call.call.options
        # A gateway takes bytes only, so that plain texts on its socket have no meaning.
        if word in _OF_TEXTS and not by_gateway and names[0].lower() in gateways.sockets:
            raise NotExpressible(_GATEWAY_REASON)
        made: tuple[p.Statement, ...]
        if accepts:
            made = tuple(_accept(call, ports))
        elif word == "open":
            made = tuple(_open(call, modes))
            mode = made[0].mode if made and isinstance(made[0], p.Attach) else "both"
            # Other languages empty a file that they open for writing.
            if mode == "write" and "write" not in call.call.options:
                with findings.at(node.span):
                    findings.append(rules.OPENED_ANEW(name=call.name(1)))
        else:
            made = tuple(_LOWERINGS[word](call))
        if word in ("socketaccept", "socketconnect"):
            made += (*gateways.greeting(call.name(int(accepts))),)
        made += (*states.behind(word, names),)
        with findings.at(node.span):
            if word in _READING and not by_gateway:
                findings.append(rules.RECEIVED(what=call.call.word))
            if accepts and "clientaddress" in call.call.options:
                findings.append(rules.LEFT_OUT(
                    what=r"\ClientAddress", loss="nobody tells the address of who connected",
                    cure="do without it",
                ))  # fmt: skip
        yield from made

    instructions = {*_LOWERINGS, *_PREPARING, "socketaccept", "open"}
    made = with_lowered_calls(program, instructions, _READING, said)
    # Without a channel that is opened nothing has changed its meaning.
    if made is program or not undeclared_names.channels(made):
        return program
    gateways.tell(made, findings)
    own = {**made.variables, **gateways.variables(), **states.variables()}
    made = states.asked(replace(made, variables=own))
    told = {name.lower() for name in undeclared_names.channels(made)}
    opened = {x.channel.lower() for x in made.statements() if isinstance(x, p.Attach)}
    # After the states: what asks for the connection alone is a question to the channel.
    made = rewrite(made, lambda part: _connection_test(part, told))
    return _without_handles(_without_unopened(made, opened))


def _without_unopened(program: Program, opened: set[str]) -> Program:
    """Without what closes sockets that only listen, which nothing has opened."""

    def body(statements: Body) -> Body:
        return tuple(
            map_bodies(node, body)
            for node in statements
            if not isinstance(node, p.Detach) or node.channel.lower() in opened
        )

    procedures = tuple(replace(q, body=body(q.body)) for q in program.procedures)
    return replace(program, procedures=procedures)


def _without_handles(program: Program) -> Program:
    """Without the declarations of files and sockets, which channels have none of."""
    program = with_vendor_statements_replaced(
        program, lambda node: () if _declares_channel(node.text) else (node,)
    )
    kept = tuple(one for one in program.declarations if not _declares_channel(one.text))
    return replace(program, declarations=kept)


def _declares_channel(text: str) -> bool:
    storage, _, type = verbatim.declares(text).partition(" ")
    return storage == "VAR" and type in _CHANNEL_TYPES


def _bound_ports(program: Program) -> Mapping[str, e.Expression]:
    """The port that a socket is bound to, by its lower-case name."""
    found: dict[str, e.Expression] = {}
    for procedure in program.procedures:
        for node in walk(procedure.body):
            if not isinstance(node, p.Opaque) or node.text[:10].lower() != "socketbind":
                continue
            match instruction_of(node):
                case s.ProcedureCall(
                    arguments=(s.Positional(s.NameRef(name)), _, s.Positional(port))
                ):
                    value = _argument_of_all_calls(
                        NameResolver().expression(port), procedure, program
                    )
                    # Two ports for one socket: nothing tells which of them counts.
                    if found.setdefault(name.lower(), value) != value:
                        return {}
    return found


def _argument_of_all_calls(value: e.Expression, of: Procedure, program: Program) -> e.Expression:
    """Return the argument that all calls of a procedure pass for a parameter, if it is the same in
    each; else the value itself.
    """
    names = [one.name.lower() for one in of.parameters]
    if isinstance(value, e.Name) and value.name.lower() in names:
        place, key = names.index(value.name.lower()), of.name.lower()
        calls = [x for x in program.statements() if isinstance(x, p.Call)]
        given = {x.arguments[place] for x in calls if x.procedure.lower() == key}
        if len(given) == 1:
            return given.pop()
    return value


def _connection_test(part: Any, known: set[str]) -> Any:
    """`SocketGetStatus(s) = SOCKET_CONNECTED` of a channel; any other expression as it is."""
    match part:
        case e.Binary(
            ("=" | "<>") as relation, e.Apply(function, (e.Name(name),)), e.Name(state)
        ) if (
            function.lower() == "socketgetstatus"
            and state.lower() == "socket_connected"
            and name.lower() in known
        ):
            connected = e.Apply("connected", (e.Text(name),))
            return e.Binary(relation, connected, e.Number(1))
    return part


# ------------------------------------------------------------------------- opening, closing


def _open(q: VendorCall, one_way: Mapping[str, p.ChannelMode]) -> Replacement:
    """one_way: what is done with files that are opened for nothing."""
    channel = q.name(1)
    of, file = q.given(0), q.option("file")
    if not q.only("file", "read", "write", "append", "bin") or of is None:
        raise NotExpressible
    serial = _SERIAL.fullmatch(of.value) if isinstance(of, e.Text) and file is None else None
    if serial is not None:
        yield p.Attach(channel, "serial", (e.Number(int(serial[1])),))
        return
    modes = [mode for word, mode in MODES.items() if word in q.call.options]
    if not modes and channel.lower() in one_way:
        modes = [one_way[channel.lower()]]
    if len(modes) != 1:
        raise NotExpressible(_READ_AND_WRITE_REASON)
    if isinstance(of, e.Text) and isinstance(file, e.Text):
        place: e.Expression = e.Text(f"{of.value}/{file.value}")
    else:
        place = of if file is None else file
    yield p.Attach(channel, "file", (place,), modes[0])


def _close(q: VendorCall) -> Replacement:
    if not q.only():
        raise NotExpressible
    yield p.Detach(q.name(0))


def _accept(q: VendorCall, ports: Mapping[str, e.Expression]) -> Replacement:
    server, channel = q.name(0), q.name(1)
    if not q.only("time", "clientaddress"):
        raise NotExpressible
    port = ports.get(server.lower())
    if port is None:
        raise NotExpressible(_NO_PORT_REASON)
    yield p.Attach(channel, "server", (port,))
    yield p.WaitUntil(_connected(channel, 1), _timeout(q))


def _connect(q: VendorCall) -> Replacement:
    """Closes and opens it again while nobody is there."""
    channel, host, port = q.name(0), q.given(1), q.given(2)
    if not q.only("time") or host is None or port is None:
        raise NotExpressible
    attach, most = p.Attach(channel, "client", (host, port)), _timeout(q)
    again: list[p.Statement] = [p.Detach(channel), p.Wait(e.Number(_RETRY_PAUSE)), attach]
    if most is not None:
        timer = f"{channel}_time"
        yield p.StartTimer(timer)
        in_time = e.Binary("<", e.Elapsed(timer), most)
        # Once the time is over the condition never holds again, so that this wait ends as one whose
        # time is over.
        again.insert(0, p.WaitUntil(in_time, e.Number(_RETRY_PAUSE)))
    yield attach
    yield p.While(_connected(channel, 0), tuple(again))


_RETRY_PAUSE: Final = 0.1
"""Seconds between one try and the next."""


def _connected(channel: str, value: int) -> e.Expression:
    return e.Binary("=", e.Apply("connected", (e.Text(channel),)), e.Number(value))


def _timeout(q: VendorCall) -> e.Expression | None:
    """The longest time of a socket, None for ever."""
    node = q.call.options.get("time")
    if node is None:
        return e.Number(_DEFAULT_TIMEOUT)
    return None if name_of(node).lower() == _FOR_EVER else q.value(node)


# --------------------------------------------------------------------------------- writing


def _write(q: VendorCall) -> Replacement:
    channel, text = q.name(0), q.given(1)
    if text is None or not q.only("num", "dnum", "bool", "pos", "orient", "nonewline"):
        raise NotExpressible
    kind: Any = "piece" if "nonewline" in q.call.options else "line"
    truth = q.option("bool")
    if truth is not None:
        # RAPID writes a truth as a word, whatever other languages write for it.
        yes, no = (p.Send(channel, kind, (text, e.Text(word))) for word in ("TRUE", "FALSE"))
        yield p.If((p.Branch(truth, (yes,)),), (no,))
        return
    yield p.Send(channel, kind, (text, *_option_values(q)))


def _option_values(q: VendorCall) -> Iterator[e.Expression]:
    """Yield the texts that an option adds to a text; a record is written in brackets."""
    for option, parts in (("num", ()), ("dnum", ()), ("pos", "xyz"), ("orient", _QUATERNION)):
        node = q.call.options.get(option)
        if node is None:
            continue
        if not parts:
            yield q.value(node)
            return
        items = node.items if isinstance(node, s.AggregateNode) else None
        if items is None:
            if not isinstance(node, s.NameRef | s.Component | s.Element):
                raise NotExpressible
            items = tuple(s.Component(node, part) for part in parts)
        for mark, item in zip(("[", *("," for _ in parts)), items, strict=False):
            yield e.Text(mark)
            yield q.value(item)
        yield e.Text("]")


_QUATERNION: Final = ("q1", "q2", "q3", "q4")


def _write_text(q: VendorCall) -> Replacement:
    text = q.given(1)
    if text is None or not q.only():
        raise NotExpressible
    yield _send_text(q.name(0), text)


def _send(q: VendorCall) -> Replacement:
    text = q.option("str")
    if text is None or not q.only("str", _GATEWAY_OPTION):
        raise NotExpressible(_BYTES_REASON)
    yield _send_text(q.name(0), text)


def _send_text(channel: str, text: e.Expression) -> p.Send:
    """A text that ends as lines do is a line, whatever ends those there."""
    parts = [*_text_terms(text)]
    match parts[-1]:
        case e.Text(last) if _LINE_END.search(last):
            rest = _LINE_END.sub("", last)
            given = [*parts[:-1], *((e.Text(rest),) if rest or len(parts) == 1 else ())]
            found = p.Send(channel, "line", tuple(given))
        case _:
            found = p.Send(channel, "piece", tuple(parts))
    for part in found.parts:
        # Other control characters would be lost in a line of text.
        if isinstance(part, e.Text) and not part.value.isprintable():
            raise NotExpressible(_BYTES_REASON)
    return found


def _text_terms(text: e.Expression) -> Iterator[e.Expression]:
    match text:
        case e.Binary("+", left, right):
            yield from _text_terms(left)
            yield from _text_terms(right)
        case _:
            yield text


# --------------------------------------------------------------------------------- reading


def _receive(q: VendorCall) -> Replacement:
    target = q.option("str")
    if target is None or not q.only("str", "time", "readnoofbytes", _GATEWAY_OPTION):
        raise NotExpressible(_BYTES_REASON)
    yield p.Assign(target, e.Apply("received", (e.Text(q.name(0)),)))


def _reading(function: str) -> Callable[[VendorCall], Replacement]:
    def said(q: VendorCall) -> Replacement:
        if q.answer is None or not q.only("delim", "removecr", "discardheaders", "time"):
            raise NotExpressible
        yield p.Assign(q.answer, e.Apply(function, (e.Text(q.name(0)),)))

    return said


_PREPARING: Final = frozenset(("socketcreate", "socketbind", "socketlisten"))
"""Instructions behind which a socket may be used."""
_OMITTED_LOSS: Final = (
    "a line is there as soon as it is opened, by SocketAccept or SocketConnect",
    "none is needed, if nobody connects before that",
)
"""Loss when these instructions are omitted, and its cure."""
_OF_TEXTS: Final = frozenset(("socketsend", "socketreceive"))
_READING: Final = frozenset(("readstr", "readnum", "socketreceive"))
_LOWERINGS: Final[Mapping[str, Callable[[VendorCall], Replacement]]] = {
    "close": _close,
    "write": _write,
    "writestrbin": _write_text,
    "socketconnect": _connect,
    "socketsend": _send,
    "socketclose": _close,
    "socketreceive": _receive,
    "readstr": _reading("received"),
    "readnum": _reading("received_number"),
}
"""By lower-case names of instructions and functions."""
