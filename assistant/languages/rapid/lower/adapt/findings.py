"""What is found while a program is rewritten into what RAPID can say."""

from __future__ import annotations

from assistant.languages.rapid import rules
from assistant.program import diagnostics
from assistant.program.subjects import Subject


class Findings(diagnostics.Findings):
    """At the statements that they are about."""

    def changed(
        self, what: str, instead: str, hint: str, about: Subject | str | None = None
    ) -> None:
        self.append(rules.CHANGED(what=what, instead=instead, hint=hint, about=about))

    def cannot(self, what: str, cure: str, about: Subject | str | None = None) -> None:
        self.append(rules.NO_MEANING(what=what, cure=cure, about=about))
