"""The layout of pseudo text: two blanks a block, nothing at the ends of lines."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.compiler.formatting import NOT_THE_SAME
from assistant.compiler.loading import parse_pseudo
from assistant.editing.places import LINE_END
from assistant.program.pseudo.editor_support import EditablePseudo

PSEUDO_INDENT: Final = "  "
_DIVIDING: Final = ("else", "elseif", "case")


def laid_out_pseudo(source: SourceText, folder: FilePath | None) -> str:
    """The text in its layout, proven to say the same; raises Refused where it cannot be read.

    folder: of tables that are files of their own.
    """
    before = parse_pseudo(source, folder)
    text = _indented(source.text)
    if text != source.text:
        after = parse_pseudo(SourceText(text, source.path, source.encoding), folder)
        if before != after or before.comments != after.comments:
            raise Refused(NOT_THE_SAME(path=source.path))
    return text


def _indented(text: str) -> str:
    language, depth, made, at = EditablePseudo(), 0, "", 0
    ends = [match.span() for match in LINE_END.finditer(text)]
    for stop, behind in [*ends, (len(text), len(text))]:
        line, end = text[at:stop], text[stop:behind]
        at = behind
        bare = line.strip(" \t\f")
        if bare.startswith("|"):  # what stands behind it is as it is
            made += PSEUDO_INDENT * depth + line.lstrip(" \t\f") + end
            continue
        facts = language.facts(line)
        first = facts.words[0].text if facts.words else ""
        less = facts.opens < 0 or first in _DIVIDING
        depth = max(depth + min(facts.opens, 0), 0)
        inner = depth - (less and facts.opens >= 0)
        made += (PSEUDO_INDENT * max(inner, 0) + bare if bare else "") + end
        depth += max(facts.opens, 0) + facts.begins
    return made
