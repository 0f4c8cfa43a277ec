"""Lines of a program as they come in, looked at by the language's own parser and rules."""

from __future__ import annotations

from typing import Final

from assistant import languages
from assistant.base.diagnostics import Refused, Severity
from assistant.virtual.cr.store import ENCODING, CrRefusal

SYNTAX: Final = 4220
CHARACTER: Final = 4310
LINE_RULES: Final = {"MB106": 4300, "MB107": 4210, "MB109": 4420, "MB111": SYNTAX}
"""Rules that one line alone can break → error number: long name, long step, step number out
of range, a word that this version lacks. Labels, blocks and values are looked for when the
program runs, so other rules keep no line out."""


def check_line(language: str, line: str) -> None:
    """Raises CrRefusal with the number and the character (from 1) of what is wrong in a line."""
    parser = languages.get(language)
    try:
        source = parser.decode(line.encode(ENCODING))
    except Refused:
        raise CrRefusal(CHARACTER, 1) from None
    tree = parser.parse(source)
    for finding in tree.findings:
        if finding.severity is Severity.ERROR:
            raise CrRefusal(SYNTAX, finding.column or 1)
    for finding in parser.check([tree]):
        if finding.code in LINE_RULES and finding.severity is Severity.ERROR:
            raise CrRefusal(LINE_RULES[finding.code], finding.column or 1)
