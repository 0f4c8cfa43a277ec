"""Words that may stand at a place."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, cast

from assistant.editing.answers import Completion, CompletionKind
from assistant.editing.naming import editable, range_of
from assistant.editing.places import Place, Range
from assistant.editing.workspace import Document
from assistant.program.editor_support import Declaration, Editable, Word

MOST_COMPLETIONS: Final = 500
"""Words that are told at once."""
_COMPLETION_KINDS: Final = {
    "procedure": "procedure", "function": "function", "interrupt": "procedure", "record": "type",
    "type": "type", "constant": "variable", "variable": "variable", "target": "target",
    "parameter": "parameter", "label": "label", "step": "label",
}  # fmt: skip
_LATER_RANK: Final = 1000
"""Added to the rank of words that do not begin with what is written."""
_STARTING: Final = ("instruction", "procedure", "keyword", "variable")
_VALUES: Final = ("target", "variable", "parameter", "function", "label")


def completions(document: Document, place: Place) -> tuple[Completion, ...]:
    """See `service.completions`."""
    speaks = editable(document)
    if speaks is None or place.line >= len(document.facts) or place.line < 0:
        return ()
    lines = document.lines
    column = lines.offset(place) - lines.starts[place.line]
    said = document.facts[place.line].words
    inside = next((word for word in said if word.start < column <= word.end), None)
    if inside is not None and inside.kind in ("comment", "string", "number"):
        return ()
    words = [word for word in said if word.end < column or word is inside]
    begun = inside if inside is not None and inside.kind != "operator" else None
    before = [word for word in words if word is not begun]
    start = column if begun is None else begun.start
    range = range_of(lines, place.line, start, column)
    prefix = lines.line(place.line)[start:column]
    offered = _offered(document, speaks, place.line, before)
    return tuple(_fitting(speaks, offered, prefix, range))


Offer = tuple[str, CompletionKind, str, str, int]
"""Label, kind, detail, more, and rank."""


def _offered(
    document: Document, speaks: Editable, line: int, before: list[Word]
) -> Iterator[Offer]:
    last = before[-1].text if before else ""
    if last == "." and len(before) > 1:
        detail = _detail(document, speaks, line, before[-2].text)
        for rank, (name, type) in enumerate(speaks.members(detail).items()):
            yield name, "property", type, "", rank
        return
    if last == "\\":
        called = next((word for word in before if word.kind == "name"), None)
        options = speaks.options(called.text) if called else {}
        for rank, (name, type) in enumerate(options.items()):
            yield name, "property", type, "", rank
        return
    begins = not any(word.kind != "number" for word in before)
    first = _STARTING if begins else _VALUES
    for one in _declared(document, line):
        kind = cast(CompletionKind, _COMPLETION_KINDS.get(one.kind, "variable"))
        own = one.scope == "routine"
        yield one.name, kind, one.detail, "", (0 if kind in first else 2) - own
    for known in speaks.known().values():
        kind = cast(CompletionKind, known.sort)
        yield known.name, kind, known.detail, known.about, _rank(kind, first)


def _rank(kind: str, first: tuple[str, ...]) -> int:
    """Words of the language behind what is declared; those that begin a statement first."""
    return 3 + first.index(kind) if kind in first else 9


def _declared(document: Document, line: int) -> Iterator[Declaration]:
    """What a line sees: of its routine, its file, and what other files share."""
    routine = document.made_of.routine_at(line)
    for other in document.workspace.task(document):
        for at, facts in enumerate(other.facts):
            for one in facts.declares:
                if one.kind in ("module", "program"):
                    continue
                home = None if not facts.declares else other.made_of.routine_at(at)
                inner = home is not None and (at > home.head or one.scope == "routine")
                if other is not document and (inner or one.scope != "task"):
                    continue
                if inner and not one.implied and home is not routine:
                    continue
                yield one


def _detail(document: Document, speaks: Editable, line: int, name: str) -> str:
    key = speaks.folded(name)
    for one in _declared(document, line):
        if speaks.folded(one.name) == key:
            return one.detail
    return ""


def _fitting(
    speaks: Editable, offered: Iterator[Offer], prefix: str, range: Range
) -> Iterator[Completion]:
    wanted = speaks.folded(prefix)
    found: dict[str, tuple[int, Offer]] = {}
    for offer in offered:
        key = speaks.folded(offer[0])
        if not _fits(key, wanted):
            continue
        rank = offer[4] + (0 if key.startswith(wanted) else _LATER_RANK)
        if key not in found or rank < found[key][0]:
            found[key] = rank, offer
    ranked = sorted(found.values(), key=lambda one: (one[0], one[1][0].lower()))
    for rank, (name, kind, detail, about, _) in ranked[:MOST_COMPLETIONS]:
        yield Completion(name, kind, name, range, detail, about, rank)


def _fits(key: str, wanted: str) -> bool:
    """Whether the letters of one stand in the other in their order, the first one first."""
    if not wanted:
        return True
    if not key or key[0] != wanted[0]:
        return False
    letters = iter(key)
    return all(letter in letters for letter in wanted)
