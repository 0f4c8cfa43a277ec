"""Two programs that differ in some statements, compared."""

from __future__ import annotations

from pathlib import Path

from assistant import compare
from assistant.compiler.comparison import Comparison

Around = tuple[str, str]
"""The text before some statements, and behind them."""


def compared(folder: Path, first: str, second: str, *, rapid: Around, melfa: Around) -> Comparison:
    """Compare two programs by their statements, in MELFA-BASIC V where those name its variables.

    rapid, melfa: what stands around the statements in either language.
    """
    paths = []
    for name, text in (("first", first), ("second", second)):
        suffix, (head, foot) = ("mb5", melfa) if "M_" in text else ("mod", rapid)
        path = folder / f"{name}.{suffix}"
        path.write_text(head + text + foot, encoding="utf-8")
        paths.append(path)
    return compare(*paths)
