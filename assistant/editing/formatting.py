"""The layout of a document, as changes of the lines that are to be otherwise."""

from __future__ import annotations

from assistant.editing.answers import Change
from assistant.editing.differing import hunks
from assistant.editing.places import Lines, Place, Range
from assistant.editing.workspace import Document


def formatted(document: Document) -> tuple[Change, ...]:
    """See `service.formatted`."""
    speaks = document.spoken
    if speaks is None:
        return ()
    text = speaks.laid_out(document.source)
    return () if text == document.text else changes_to(document.lines, text)


def changes_to(lines: Lines, text: str) -> tuple[Change, ...]:
    """What makes another text of this one, whole lines at a time."""
    new = Lines(text)
    before, after = _ended(lines), _ended(new)
    found = []
    for hunk in hunks(before, after):
        start = _place(lines, hunk.first)
        end = _place(lines, hunk.last)
        found.append(Change(Range(start, end), "".join(after[hunk.new_first : hunk.new_last])))
    return tuple(found)


def _ended(lines: Lines) -> list[str]:
    ends = [*lines.starts[1:], len(lines.text)]
    return [lines.text[a:b] for a, b in zip(lines.starts, ends, strict=True)]


def _place(lines: Lines, line: int) -> Place:
    return Place(line, 0) if line < len(lines) else lines.place(len(lines.text))
