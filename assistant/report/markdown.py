"""Markdown for pull requests: external text is code, which it cannot escape."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final

from assistant.base.diagnostics import Diagnostic, notes_last
from assistant.base.source_text import lines_of, visible

_MOST_LINES: Final = 300
"""Lines of a difference in a comment; a site takes 65,536 characters of one."""
_MOST_CHARACTERS: Final = 20_000


def findings_markdown(findings: Sequence[Diagnostic]) -> list[str]:
    return [f"- {finding.severity} {code(_told(finding))}" for finding in notes_last(findings)]


def _told(finding: Diagnostic) -> str:
    where = f" {finding.where()}" if finding.where() else ""
    return f"{finding.code}{where}: {finding.message}"


def _longest(text: str) -> int:
    """Return the length of the longest run of backticks in a text."""
    return max(map(len, re.findall(r"`+", text)), default=0)


def code(text: str) -> str:
    """Text as inline code, whatever is in it; a line that it cannot end."""
    text = visible(text)
    fence = "`" * (_longest(text) + 1)
    return f"{fence} {text} {fence}" if "`" in text or not text.strip() else f"`{text}`"


def cell(text: str) -> str:
    return code(text).replace("|", "\\|")


def plain(text: str) -> str:
    """Text in a line of HTML, which Markdown reads as well."""
    return "".join(c if c.isalnum() or c in " .-_~$" else f"&#{ord(c)};" for c in text)


def folded(title: str, text: str) -> Iterator[str]:
    lines = [visible(line) for line in lines_of(text)]
    shown = lines[:_MOST_LINES]
    while sum(map(len, shown)) > _MOST_CHARACTERS:
        shown = shown[: len(shown) // 2]
    if len(shown) < len(lines):
        shown.append(f"… {len(lines) - len(shown)} lines more")
    fence = "`" * max(3, _longest("\n".join(shown)) + 1)
    yield f"<details><summary>{title}</summary>"
    yield from ("", f"{fence}diff", *shown, fence, "", "</details>")
