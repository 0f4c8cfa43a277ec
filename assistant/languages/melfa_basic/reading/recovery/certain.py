"""Texts whose damage leaves no doubt of what is meant: plain marks instead of typographic ones.

Word processors and other keyboards write marks that no controller takes, and comments lose their
mark. Such a text stays wrong where it is; another language can be told what it says.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.base.diagnostics import Diagnostic, Severity, has_errors
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.parser import parse
from assistant.languages.melfa_basic.tree.syntax import File

_PLAIN_MARKS: Final = str.maketrans({
    **dict.fromkeys("‘’‚‛′´`＇", "'"),
    **dict.fromkeys("“”„‟″＂", '"'),
    **dict.fromkeys("，、", ","),
    **dict.fromkeys("–—−－", "-"),
    **dict.fromkeys("\u3000\u00a0\ufeff", " "),
    **{chr(code): " " for code in range(0x2000, 0x200C)},
})  # fmt: skip
"""The marks that findings of `rules.QUOTES` are about; each takes one character, as before."""
CERTAIN_FINDINGS: Final = (rules.QUOTES.code, rules.REMARK.code)


def mended(tree: File, dialect: str) -> File | None:
    """The tree of what is certainly meant, its findings as warnings; None if that is not known.

    Lines keep their numbers.
    """
    errors = [f for f in tree.findings if f.severity is Severity.ERROR]
    source = tree.source
    if source is None or any(f.code not in CERTAIN_FINDINGS or f.span is None for f in errors):
        return None
    text = source.text
    for finding in sorted(errors, key=lambda f: -f.span.start if f.span else 0):
        text = _replaced(text, finding)
    again = parse(replace(source, text=text), dialect)
    if has_errors(again.findings):
        return None
    told = (replace(f, severity=Severity.WARNING) for f in tree.findings)
    return replace(again, findings=tuple(told))


def _replaced(text: str, finding: Diagnostic) -> str:
    span = finding.span
    assert span is not None
    if finding.code == rules.REMARK.code:
        return f"{text[: span.start]}'{text[span.start :]}"
    inside = text[span.start : span.end]
    plain = inside.translate(_PLAIN_MARKS)
    if plain.startswith("'"):  # a comment, which keeps its own marks
        plain = f"'{inside[1:]}"
    return text[: span.start] + plain + text[span.end :]
