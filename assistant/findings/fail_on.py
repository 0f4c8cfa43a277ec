"""How bad a finding must be for a check to fail."""

from __future__ import annotations

import enum
from collections.abc import Iterable

from assistant.program.diagnostics import Diagnostic, Severity


class FailOn(enum.StrEnum):
    """The least severity that fails a check, or that none does."""

    ERROR = "error"
    WARNING = "warning"
    NEVER = "never"

    def counts(self, finding: Diagnostic) -> bool:
        """Whether the check fails for this finding."""
        if self is FailOn.NEVER or finding.severity is Severity.INFO:
            return False
        return finding.severity is Severity.ERROR or self is FailOn.WARNING

    def status(self, findings: Iterable[Diagnostic], *, unreadable: bool = False) -> int:
        """The exit status of a check: 0, 1 where it fails, 2 where something was not read."""
        return 2 if unreadable else int(any(map(self.counts, findings)))
