r"""Texts that a program reads from a socket byte by byte, up to the end of a line or a comma.

    t:="";
    SocketReceive s\Str:=c\ReadNoOfBytes:=1\Time:=WAIT_MAX;
    WHILE c<>"\0D" AND c<>"," DO
        IF c<>"\0A" THEN t:=t+c; ENDIF
        SocketReceive s\Str:=c\ReadNoOfBytes:=1\Time:=WAIT_MAX;
    ENDWHILE
    ok:=StrToVal(t,n);
    IF NOT ok THEN EXIT; ENDIF

becomes `n:=ReadNum(s\Delim:=",");`, and without the last two lines `t:=ReadStr(s\Delim:=",");`, as
other languages read a line. That is how channels of other languages are written in RAPID
(`lower/adapt/channels.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.program.rewriting import rewrite

SHORTEST_LOOP: Final = 3
"""Statements that read a text; two more make a number of it."""
TEXT_ENDS: Final = frozenset(("\r", ","))
SKIPPED_CHARACTER: Final = "\n"
Body = tuple[s.StatementNode, ...]


def with_line_reads(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules with one statement for each text that is read so."""
    return [rewrite(module, _with_reads_in, ()) for module in modules]


def _with_reads_in(node: Any) -> Any:
    match node:
        case s.Routine(body=body) | s.IfBranch(body=body) | s.ForLoop(body=body):
            pass
        case s.WhileLoop(body=body) | s.TestCase(body=body):
            pass
        case _:
            return node
    made = _with_line_reads(body)
    return node if made is body else replace(node, body=made)


def _with_line_reads(body: Body) -> Body:
    made: list[s.StatementNode] = []
    at = 0
    while at < len(body):
        text = _line_read(body[at : at + SHORTEST_LOOP])
        if text is None:
            made.append(body[at])
            at += 1
            continue
        target = _number_target(body[at + SHORTEST_LOOP : at + SHORTEST_LOOP + 2], text.into)
        word = "ReadStr" if target is None else "ReadNum"
        given = s.Positional(text.socket), s.Option("Delim", s.StringLiteral(","))
        into = text.into if target is None else target
        made.append(s.Assignment(into, s.FunctionCall(word, given), span=body[at].span))
        at += SHORTEST_LOOP if target is None else SHORTEST_LOOP + 2
    return tuple(made) if len(made) < len(body) else body


@dataclass(frozen=True, slots=True)
class _LineRead:
    """A text that is read. into: its variable."""

    socket: s.Expression
    into: s.NameRef


def _line_read(some: Body) -> _LineRead | None:
    match some:
        case (
            s.Assignment(s.NameRef() as into, s.StringLiteral("")),
            s.ProcedureCall() as first,
            s.WhileLoop(
                s.Infix("AND", left, right),
                (
                    s.IfThen(
                        (s.IfBranch(beside, (s.Assignment(grown, s.Infix("+", one, more)),)),), None
                    ),
                    s.ProcedureCall() as again,
                ),
            ),
        ):
            received = _received_byte(first)
        case _:
            return None
    if received is None or first != again or (grown, one) != (into, into):
        return None
    socket, last = received
    marks = {_tested_text(left, last), _tested_text(right, last)}
    if marks != TEXT_ENDS or _tested_text(beside, last) != SKIPPED_CHARACTER or more != last:
        return None
    return _LineRead(socket, into)


def _received_byte(call: s.ProcedureCall) -> tuple[s.Expression, s.Expression] | None:
    """The socket that a byte is received from, and the text that it comes into."""
    if not isinstance(call.name, str) or call.name.lower() != "socketreceive":
        return None
    socket: s.Expression | None = None
    options: dict[str, s.Expression | None] = {}
    for one in call.arguments:
        match one:
            case s.Positional(value) if socket is None:
                socket = value
            case s.Option(name, value):
                options[name.lower()] = value
            case _:
                return None
    into, count = options.pop("str", None), options.pop("readnoofbytes", None)
    endless = options.pop("time", None) == s.NameRef("WAIT_MAX")
    if socket is None or into is None or options or not endless or count != s.NumberLiteral("1"):
        return None
    return socket, into


def _tested_text(condition: s.Expression | None, last: s.Expression) -> str | None:
    """The text that a condition says something is not."""
    match condition:
        case s.Infix("<>", left, s.StringLiteral(mark)) if left == last:
            return mark
    return None


def _number_target(some: Body, text: s.NameRef) -> s.Variable | None:
    """What gets the number of a text; the program ends where it is none."""
    match some:
        case (
            s.Assignment(s.NameRef() as read, s.FunctionCall(str(word), (given, target))),
            s.IfThen((s.IfBranch(s.Prefix("NOT", asked), (s.Word("EXIT"),)),), None),
        ) if word.lower() == "strtoval" and asked == read:
            pass
        case _:
            return None
    match given, target:
        case s.Positional(value), s.Positional(s.NameRef() | s.Element() | s.Component() as into):
            return into if value == text else None
    return None
