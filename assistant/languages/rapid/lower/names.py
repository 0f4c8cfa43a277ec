"""Names that RAPID takes; the header of a module keeps the original of one that got another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.predefined import taken_names
from assistant.languages.rapid.tables.words import LONGEST_NAME, RESERVED
from assistant.languages.rapid.text import verbatim
from assistant.languages.scoped_names import Scopes
from assistant.program.geometry import FLANGE
from assistant.program.program import Program


def _declared_names(program: Program) -> Iterator[str]:
    """Names that declarations in the words of RAPID declare; raises Refused if they are none."""
    for declaration in program.declarations:
        if declaration.language == verbatim.LANGUAGE:
            for item in verbatim.items(declaration.text):
                if hasattr(item, "name"):
                    yield item.name


NAMES: Final = Scopes(
    longest=LONGEST_NAME,
    reserved=taken_names() | RESERVED,
    kept=_declared_names,
    flange=FLANGE,
    base="",
    renamed=rules.SHORTENED,
    language="RAPID",
)
