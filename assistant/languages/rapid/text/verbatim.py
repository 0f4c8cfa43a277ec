"""Text of RAPID that a pseudo-program keeps as it is, and the nodes that it says."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Final, TypeVar

from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.program.diagnostics import Refused
from assistant.program.expressions import Verbatim
from assistant.program.program import Declaration
from assistant.program.statements import Opaque

T = TypeVar("T")

LANGUAGE: Final = "rapid"
_HANDLER: Final = re.compile(r"(?:ERROR|UNDO|BACKWARD)\b", re.IGNORECASE)
_SHOWN: Final = 60
_MOST: Final = 1 << 14
_known: dict[tuple[str, str], tuple[Any, ...]] = {}
"""What texts say: lifting, adapting, naming and building each ask for the same ones."""


def foreign(kept: Opaque | Verbatim | Declaration) -> dict[str, Any]:
    """What a finding says of the text of another language: fields of `rules.OTHER_LANGUAGE`."""
    text = kept.text if len(kept.text) <= _SHOWN else kept.text[:_SHOWN] + "…"
    reason = None if isinstance(kept, Declaration) else kept.reason
    if reason is None:
        cure = "write it in the pseudo-program or in RAPID"
        return {"language": kept.language, "text": text, "cure": cure}
    return {"language": kept.language, "text": f"{text}; {reason.why}", "cure": reason.cure}


def items(text: str) -> tuple[s.Item, ...]:
    """The declarations of a text; raises Refused if it is no RAPID."""
    from assistant.languages.rapid.reading.parser import parse_items

    read: tuple[s.Item, ...] = _read(text, "items", parse_items)
    return read


def statements(text: str) -> tuple[s.StatementNode, ...]:
    """The statements of a text; raises Refused if it is no RAPID."""
    from assistant.languages.rapid.reading.parser import parse_statements

    read: tuple[s.StatementNode, ...] = _read(text, "statements", parse_statements)
    return read


def handlers(text: str) -> tuple[s.Handler, ...] | None:
    """The error handlers of a text, None if it does not begin as one; raises Refused."""
    if not _HANDLER.match(text):
        return None
    known = _known.get(("handlers", text))
    if known is not None:
        return known
    match items(f"PROC x()\n{text}\nENDPROC"):
        case (s.Routine(body=(), handlers=found),):
            return found
    raise Refused(rules.NOT_RAPID(text=text[:60], why="no error handler"))


def expression(text: str) -> s.Expression:
    """The expression of a text; raises Refused if it is none of RAPID."""
    read = statements(f"x:={text}\n;")
    if len(read) == 1 and isinstance(read[0], s.Assignment):
        return read[0].value
    raise Refused(rules.NOT_RAPID(text=text[:60], why="no expression"))


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


def of_item(node: s.Item) -> str:
    """The text that says a declaration."""
    from assistant.languages.rapid.text.printer import print_items

    return _remember("items", print_items([node]), (node,))


def of_statement(node: s.StatementNode) -> str:
    """The text that says a statement."""
    from assistant.languages.rapid.text.printer import print_statements

    return _remember("statements", print_statements([node]), (node,))


def of_handler(node: s.Handler) -> str:
    """The text that says an error handler."""
    from assistant.languages.rapid.text.printer import print_handler

    return _remember("handlers", print_handler(node), (node,))


def _remember(kind: str, text: str, nodes: tuple[Any, ...]) -> str:
    if len(_known) >= _MOST:
        _known.clear()
    _known[kind, text] = nodes
    return text


def _read(text: str, kind: str, parse: Any) -> Any:
    known = _known.get((kind, text))
    if known is not None:
        return known
    read = parse(text)
    if not isinstance(read, tuple):
        raise Refused(rules.NOT_RAPID(text=text[:60], why=read.message))
    _remember(kind, text, read)
    return read
