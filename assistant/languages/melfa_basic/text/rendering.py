"""The text of a tree: what was read as it stood, what changed in its place, what is new printed."""

from __future__ import annotations

from assistant.languages.melfa_basic.text.lines import Lines
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.texts import line_text
from assistant.languages.texts.line_text import print_items


def render(file: s.File) -> str:
    """The text of a tree; lines that were read and not changed keep their bytes."""
    if file.source is None:
        return "".join(print_items(Lines(file), "\r\n"))
    if file.items is file.parsed:
        return file.source.text
    return line_text.render_changed_file(file.source, file.parsed, Lines(file))
