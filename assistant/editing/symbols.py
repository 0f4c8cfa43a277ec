"""Symbols of a document: definition, references, renaming, and the outline.

A name is looked up in its routine, its file, and the other files of the task. The rules say why a
name cannot be changed, and why a language server cannot be started.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, cast

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Span, error
from assistant.base.installation import missing_extra
from assistant.editing.answers import Change, Changes, Location, OutlineItem, OutlineKind
from assistant.editing.text_lines import Lines, Place, Range
from assistant.editing.workspace import Document
from assistant.program.editor_support import Declaration, Editable, Word

_NO_NAME: Final = error("ED001", "the name `{name}` {why}", "choose another name")
_TAKEN: Final = error(
    "ED002",
    "`{name}` is taken: line {first} of `{file}` has it already",
    "choose a name that is not in use there, or rename that one first",
)
_NOT_DECLARED: Final = error(
    "ED003",
    "nothing with a name that can be changed stands here",
    "put the cursor on a name that the program declares",
)
NO_LIBRARY: Final = missing_extra(
    "ED010",
    "the language server is made with the library {name}, which is not installed",
    "lsp",
)
NOT_BOUND: Final = error(
    "ED011",
    "the port {port} cannot be listened on: {reason}",
    "choose another port: `robot-assistant lsp --tcp 0` takes a free one",
)


@dataclass(frozen=True, slots=True)
class Named:
    """A name at a place, and what declares it. line: of the name, from 0.

    declared: None for what nothing in the task declares; `document` and `at` are where it is.
    first, last: lines of the routine whose own it is, -1 without one.
    """

    word: Word
    line: int
    declared: Declaration | None
    document: Document
    at: int = -1
    first: int = -1
    last: int = -1


def editable(document: Document) -> Editable | None:
    speaks = document.spoken
    return None if speaks is None else speaks.editable


def word_at(document: Document, place: Place) -> tuple[int, Word] | None:
    """The word that a place is in, or just behind, with its line."""
    lines = document.lines
    offset = lines.offset(place)
    line = lines.place(offset).line
    column = offset - lines.starts[line]
    best = None
    for word in document.facts[line].words:
        if word.start <= column <= word.end and (best is None or word.kind in ("name", "label")):
            best = word
    return None if best is None else (line, best)


def named(document: Document, place: Place) -> Named | None:
    """The name at a place."""
    found = word_at(document, place)
    speaks = editable(document)
    if found is None or speaks is None or found[1].kind not in ("name", "label", "keyword"):
        return None
    line, word = found
    if word.kind == "keyword" and not any(
        one.start == word.start for one in document.facts[line].declares
    ):
        return None
    return _meant(document, speaks, line, word)


def _meant(document: Document, speaks: Editable, line: int, word: Word) -> Named:
    key = speaks.folded(word.text)
    own = _in_routine(document, speaks, line, key)
    if own is not None:
        first, last, at, declared = own
        return Named(word, line, declared, document, at, first, last)
    outer = _outside(document, speaks, key, own_file=True)
    if outer is not None:
        return Named(word, line, outer[1], document, outer[0])
    for other in document.workspace.task(document)[1:]:
        outer = _outside(other, speaks, key, own_file=False)
        if outer is not None:
            return Named(word, line, outer[1], other, outer[0])
    implied = _implied(document, speaks, key)
    if implied is not None:
        return Named(word, line, implied[1], document, implied[0])
    return Named(word, line, None, document)


def _in_routine(
    document: Document, speaks: Editable, line: int, key: str
) -> tuple[int, int, int, Declaration] | None:
    """Lines of the routine whose own a name is, and where it declares it."""
    routine = document.made_of.routine_at(line)
    if routine is None:
        return None
    for at in range(routine.first, routine.last + 1):
        for one in document.facts[at].declares:
            inner = at > routine.head or one.scope == "routine"
            if inner and not one.implied and speaks.folded(one.name) == key:
                return routine.first, routine.last, at, one
    return None


def _outside(
    document: Document, speaks: Editable, key: str, *, own_file: bool
) -> tuple[int, Declaration] | None:
    """Return the line and declaration of a name that a file declares outside its routines."""
    heads = {line for one in document.made_of.routines for line in range(one.first, one.head + 1)}
    for at, facts in enumerate(document.facts):
        for one in facts.declares:
            if one.implied or one.scope == "routine" or speaks.folded(one.name) != key:
                continue
            if not own_file and one.scope != "task":
                continue
            if at in heads or document.made_of.routine_at(at) is None:
                return at, one
    return None


def _implied(document: Document, speaks: Editable, key: str) -> tuple[int, Declaration] | None:
    for at, facts in enumerate(document.facts):
        for one in facts.declares:
            if speaks.folded(one.name) == key:
                return at, one
    return None


def location(document: Document, line: int, start: int, end: int) -> Location:
    return Location(document.path, range_of(document.lines, line, start, end))


def range_of(lines: Lines, line: int, start: int, end: int) -> Range:
    begin = lines.starts[line]
    return lines.range(Span(begin + start, begin + end))


def definition(document: Document, place: Place) -> Location | None:
    found = named(document, place)
    if found is None or found.declared is None:
        return None
    return location(found.document, found.at, found.declared.start, found.declared.end)


def references(document: Document, place: Place, declaration: bool) -> tuple[Location, ...]:
    found = named(document, place)
    if found is None:
        return ()
    own = None if found.declared is None else (found.document.path, found.at, found.declared.start)
    return tuple(
        location(other, line, word.start, word.end)
        for other, line, word in uses(found)
        if declaration or (other.path, line, word.start) != own
    )


def uses(found: Named) -> Iterator[tuple[Document, int, Word]]:
    """Yield all uses of a name, including its declaration; the other files follow its file."""
    speaks = editable(found.document)
    assert speaks is not None
    key = speaks.folded(found.word.text)
    documents: tuple[Document, ...] = (found.document,)
    if found.first < 0 and (found.declared is None or found.declared.scope == "task"):
        documents = found.document.workspace.task(found.document)
    for document in documents:
        hidden = document is not found.document and _outside(document, speaks, key, own_file=True)
        if hidden:
            continue
        yield from _uses_in(document, speaks, key, found)


def _uses_in(
    document: Document, speaks: Editable, key: str, found: Named
) -> Iterator[tuple[Document, int, Word]]:
    lines = range(len(document.facts)) if found.first < 0 else range(found.first, found.last + 1)
    shadowed: dict[int, bool] = {}
    for line in lines:
        facts = document.facts[line]
        if key not in facts.names and not any(
            speaks.folded(one.name) == key for one in facts.declares
        ):
            continue
        if found.first < 0:
            routine = document.made_of.routine_at(line)
            if routine is not None:
                if routine.first not in shadowed:
                    own = _in_routine(document, speaks, line, key)
                    shadowed[routine.first] = own is not None
                if shadowed[routine.first]:
                    continue
        starts = {one.start for one in facts.declares}
        for word in facts.words:
            counts = word.kind in ("name", "label") or word.start in starts
            if counts and speaks.folded(word.text) == key:
                yield document, line, word


def renameable(document: Document, place: Place) -> Range | None:
    found = named(document, place)
    if found is None or found.declared is None:
        return None
    begin = int(found.word.kind == "label" and found.word.text.startswith("*"))
    return range_of(document.lines, found.line, found.word.start + begin, found.word.end)


def rename(document: Document, place: Place, name: str) -> Changes:
    found = named(document, place)
    speaks = editable(document)
    if found is None or found.declared is None or speaks is None:
        raise Refused(_NOT_DECLARED(path=document.path, line=place.line + 1))
    mark = "*" if found.word.text.startswith("*") else ""
    name = mark + name.removeprefix("*") if mark else name
    if why := speaks.no_name(name, found.word.text):
        raise Refused(_NO_NAME(path=document.path, line=found.line + 1, name=name, why=why))
    every = list(uses(found))
    if speaks.folded(name) != speaks.folded(found.word.text):
        _check_free(found, speaks, name, document.path)
    changes: dict[str, list[Change]] = {}
    for other, line, word in every:
        place_of = range_of(other.lines, line, word.start, word.end)
        changes.setdefault(other.path, []).append(Change(place_of, name))
    return changes


def _check_free(found: Named, speaks: Editable, name: str, path: str) -> None:
    """Raises Refused where the new name means something in a place of the old one."""
    key = speaks.folded(name)
    documents = {id(other): other for other, _, _ in uses(found)}
    documents[id(found.document)] = found.document
    for document in documents.values():
        lines = (
            range(len(document.facts)) if found.first < 0 else range(found.first, found.last + 1)
        )
        for line in lines:
            if key in document.facts[line].names:
                raise Refused(_TAKEN(path=path, name=name, first=line + 1, file=document.path))


_HELD: Final = ("module", "program")
_LEFT_OUT: Final = ("parameter",)


def outline(document: Document) -> tuple[OutlineItem, ...]:
    """See `service.outline`."""
    routines = {one.first: one for one in document.made_of.routines}
    made: list[OutlineItem] = []
    inner: list[OutlineItem] | None = None
    head: tuple[OutlineItem, int] | None = None
    for line, facts in enumerate(document.facts):
        if head is not None and line > head[1]:
            made.append(_with(head[0], inner or []))
            head, inner = None, None
        for one in facts.declares:
            if one.kind in _LEFT_OUT or (one.implied and one.kind != "label"):
                continue
            if one.kind == "variable" and one.detail in ("FOR", "for"):
                continue
            item = _outline_item(
                document, line, one, routines[line].last if line in routines else line
            )
            if line in routines and head is None:
                head, inner = (item, routines[line].last), []
            else:
                (made if inner is None else inner).append(item)
    if head is not None:
        made.append(_with(head[0], inner or []))
    return _in_modules(document, made)


def _outline_item(document: Document, line: int, one: Declaration, last: int) -> OutlineItem:
    lines = document.lines
    whole = Range(
        range_of(lines, line, 0, 0).start, range_of(lines, last, 0, len(lines.line(last))).end
    )
    name = range_of(lines, line, one.start, one.end)
    return OutlineItem(one.name, cast(OutlineKind, one.kind), whole, name, one.detail)


def _with(item: OutlineItem, children: list[OutlineItem]) -> OutlineItem:
    return OutlineItem(
        item.name, item.kind, item.range, item.selection, item.detail, tuple(children)
    )


def _in_modules(document: Document, items: list[OutlineItem]) -> tuple[OutlineItem, ...]:
    """Nest the items after a module or program in it, up to the next one."""
    found: list[OutlineItem] = []
    inside: list[OutlineItem] = []
    holder: OutlineItem | None = None
    end = document.lines.place(len(document.text))
    for item in items:
        if item.kind not in _HELD:
            (found if holder is None else inside).append(item)
            continue
        if holder is not None:
            found.append(_closed(holder, inside, item.range.start))
        holder, inside = item, []
    if holder is not None:
        found.append(_closed(holder, inside, end))
    return tuple(found)


def _closed(holder: OutlineItem, inside: list[OutlineItem], end: object) -> OutlineItem:
    from assistant.editing.text_lines import Place

    assert isinstance(end, Place)
    whole = Range(holder.range.start, end)
    return OutlineItem(
        holder.name, holder.kind, whole, holder.selection, holder.detail, tuple(inside)
    )
