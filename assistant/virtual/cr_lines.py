"""Lines of a program as they come in, looked at by the language's own parser."""

from __future__ import annotations

from assistant import languages
from assistant.program.diagnostics import Severity
from assistant.virtual.cr_store import ENCODING, CrRefusal

SYNTAX = 4220


def check(language: str, line: str) -> None:
    """Raises CrRefusal with the number and the character (from 1) of what is wrong in a line."""
    parser = languages.get(language)
    source = parser.decode(line.encode(ENCODING))
    for finding in parser.parse(source).findings:
        if finding.severity is Severity.ERROR:
            raise CrRefusal(SYNTAX, finding.column or 1)
