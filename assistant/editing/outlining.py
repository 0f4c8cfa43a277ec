"""The outline of a text: what it declares, one inside another."""

from __future__ import annotations

from typing import Final, cast

from assistant.editing.answers import OutlineItem, OutlineKind
from assistant.editing.naming import range_of
from assistant.editing.places import Range
from assistant.editing.workspace import Document
from assistant.program.editor_support import Declaration

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
    """What follows a module or program is in it, up to the next one."""
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
    from assistant.editing.places import Place

    assert isinstance(end, Place)
    whole = Range(holder.range.start, end)
    return OutlineItem(
        holder.name, holder.kind, whole, holder.selection, holder.detail, tuple(inside)
    )
