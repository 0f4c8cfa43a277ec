"""Where what was read stood in its text."""

from __future__ import annotations

from dataclasses import dataclass, field

from assistant.program.diagnostics import Span


@dataclass(frozen=True, slots=True, kw_only=True)
class Spanned:
    """Where in a source text a statement stood; not part of what it says."""

    span: Span | None = field(default=None, compare=False, repr=False)
