"""The text of a tree: what was read as it stood, what changed in its place, what is new printed."""

from __future__ import annotations

from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.layout.printing import print_items


def render(file: s.File) -> str:
    """The text of a tree; lines that were read and not changed keep their bytes."""
    if file.source is None:
        return "".join(print_items(file.items, file.dialect, "\r\n"))
    text = file.source.text
    if file.items is file.parsed:
        return text
    spans = {id(item): item.span for item in file.parsed}
    newline = file.source.newline
    parts: list[str] = []
    printed = print_items(file.items, file.dialect, newline)
    for item, part in zip(file.items, printed, strict=True):
        span = spans.get(id(item))
        part = part if span is None else text[span.start : span.end]
        if parts and parts[-1] and not parts[-1].endswith("\n"):
            parts.append(newline)  # the last line of a file may have no line end
        parts.append(part)
    return "".join(parts)
