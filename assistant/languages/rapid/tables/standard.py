"""Names of routines that RAPID and its options define: nothing else may take them."""

from __future__ import annotations

from typing import Final

from assistant.languages.rapid.tables.signatures import rows


def _names(word: str, *, options: bool) -> frozenset[str]:
    lines = rows().items()
    return frozenset(n for n, (line, of) in lines if line.startswith(word) and bool(of) == options)


INSTRUCTIONS: Final = _names("PROC", options=False)
FUNCTIONS: Final = _names("FUNC", options=False)
OF_OPTIONS: Final = _names("", options=True)
"""Instructions and functions of RobotWare's options, lower case as all of these."""
