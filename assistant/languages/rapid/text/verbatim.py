"""Text of RAPID that a pseudo-program keeps as it is, and the nodes that it says."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Final, Literal, TypeVar

from assistant.base.diagnostics import Refused
from assistant.languages import vendor_statements
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.parser import parse_items, parse_statements
from assistant.languages.rapid.text.printer import print_nodes
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.vendor_statements import ParsedTexts

T = TypeVar("T")
TextKind = Literal["items", "statements", "handlers"]

LANGUAGE: Final = "rapid"
_HANDLER: Final = re.compile(r"(?:ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_TEXTS: Final = ParsedTexts(rules.NOT_RAPID)
foreign: Final = partial(vendor_statements.foreign_text_fields, language="RAPID")


def items(text: str) -> tuple[s.Item, ...]:
    """The declarations of a text; raises Refused if it is no RAPID."""
    return _TEXTS.read("items", text, parse_items)


def statements(text: str) -> tuple[s.StatementNode, ...]:
    """The statements of a text; raises Refused if it is no RAPID."""
    return _TEXTS.read("statements", text, parse_statements)


def error_handlers(text: str) -> tuple[s.Handler, ...] | None:
    """The error handlers of a text, None if it does not begin as one; raises Refused."""
    if not _HANDLER.match(text):
        return None
    known = _TEXTS.known("handlers", text)
    if known is not None:
        return known
    match items(f"PROC x()\n{text}\nENDPROC"):
        case (s.Routine(body=(), handlers=found),):
            return found
    raise _TEXTS.refused(text, "no error handler")


def expression(text: str) -> s.Expression:
    """The expression of a text; raises Refused if it is none of RAPID."""
    read = statements(f"x:={text}\n;")
    if len(read) == 1 and isinstance(read[0], s.Assignment):
        return read[0].value
    raise _TEXTS.refused(text, "no expression")


def understood(read: Callable[[str], T], text: str) -> T | None:
    """What `items`, `statements` or `expression` reads in a text, None if it is no RAPID."""
    try:
        return read(text)
    except Refused:
        return None


def declares(text: str) -> str:
    """Storage and type of data, or the word of another declaration; empty if it is none."""
    found = understood(items, text) or understood(statements, text) or ()
    match found[:1]:
        case (s.Data(storage=storage, type=type),):
            return f"{storage} {type.lower()}"
        case (s.TargetRunNode(),):
            return "CONST robtarget"
        case (s.Routine(kind=kind),):
            return kind
        case (s.Record(),):
            return "RECORD"
        case (s.Alias(),):
            return "ALIAS"
    return ""


def of_node(node: s.Item | s.StatementNode | s.Handler, kind: TextKind) -> str:
    """The text that says a declaration, a statement or an error handler."""
    return _TEXTS.remember(kind, print_nodes((node,)), (node,))
