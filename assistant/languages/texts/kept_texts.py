"""Vendor text that a program keeps: what it is read as, remembered from one pass to the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.program.expressions import Verbatim
from assistant.program.statements import Opaque
from assistant.program.vendor_statements import VendorText

SHOWN_CHARACTERS: Final = 60
"""Characters of a text that a finding shows."""
MOST_REMEMBERED: Final = 1 << 14
"""Texts that are remembered."""


class ParsedTexts:
    """What texts say: lifting, adapting, naming and building each ask for the same ones.

    unreadable: the rule for a text that is none of the language; it names `text` and `why`.
    """

    def __init__(self, unreadable: Rule) -> None:
        self._unreadable = unreadable
        self._known: dict[tuple[str, str], tuple[Any, ...]] = {}

    def known(self, kind: str, text: str) -> tuple[Any, ...] | None:
        """The nodes of a text that was read or remembered as of a kind."""
        return self._known.get((kind, text))

    def read(
        self, kind: str, text: str, parse: Callable[[str], tuple[Any, ...] | Diagnostic]
    ) -> tuple[Any, ...]:
        """The nodes of a text; raises Refused if it cannot be parsed."""
        known = self.known(kind, text)
        if known is not None:
            return known
        read = parse(text)
        if isinstance(read, Diagnostic):
            raise self.refused(text, read.message)
        self.remember(kind, text, read)
        return read

    def remember(self, kind: str, text: str, nodes: tuple[Any, ...]) -> str:
        """The text, which says these nodes."""
        if len(self._known) >= MOST_REMEMBERED:
            self._known.clear()
        self._known[kind, text] = nodes
        return text

    def refused(self, text: str, why: str) -> Refused:
        return Refused(self._unreadable(text=text[:SHOWN_CHARACTERS], why=why))


def foreign_text_fields(kept: VendorText, language: str) -> dict[str, Any]:
    """What a finding says of the text of another language: fields `language`, `text`, `cure`.

    language: the title of the one that is written.
    """
    text = kept.text if len(kept.text) <= SHOWN_CHARACTERS else kept.text[:SHOWN_CHARACTERS] + "…"
    reason = kept.reason if isinstance(kept, Opaque | Verbatim) else None
    if reason is None:
        cure = f"write it in the pseudo-program or in {language}"
        return {"language": kept.language, "text": text, "cure": cure}
    return {"language": kept.language, "text": f"{text}; {reason.why}", "cure": reason.cure}
