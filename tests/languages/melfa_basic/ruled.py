"""What the rules of MELFA-BASIC find in small programs.

A row of a table is a program and what is found in it, as `CODE line:column`. Most come in pairs:
one that has the finding, and one that comes near to it and has not.
"""

from __future__ import annotations

from assistant import languages
from assistant.base.source_text import SourceText

Row = tuple[str, list[str]]

QUIET = ("MB116", "MB710")
"""What nothing uses, and tools: nearly every small program has these; they have tests below."""


def found(version: int, *texts: str, quiet: tuple[str, ...] = QUIET, first: str = "A") -> list[str]:
    """Findings in the first of some programs, named A, B and so on, which stand together."""
    language = languages.get(f"melfa-basic-{version}")
    names = [first, *"BCDEFGHIJK"][: len(texts)]
    pairs = zip(texts, names, strict=True)
    trees = [language.parse(SourceText(text + "\n", f"{name}.prg")) for text, name in pairs]
    assert not [f for tree in trees for f in tree.findings]
    findings = [f for f in language.check(trees) if f.path == f"{first}.prg"]
    assert all(f.cure and "{" not in f.message + f.cure for f in findings)
    return [f"{f.code} {f.line}:{f.column}" for f in findings if f.code not in quiet]


def numbered(lines: str, step: int = 10) -> str:
    return "\n".join(f"{i * step} {line}" for i, line in enumerate(lines.split("\n"), 1))


POINT = "({x},0,300,180,0,180)({flag},0)"


def taught(*names: str, flag: int = 7) -> str:
    """Lines of positions, 100 mm apart."""
    return "\n".join(
        f"{name}={POINT.format(x=(i + 1) * 100, flag=flag)}" for i, name in enumerate(names)
    )
