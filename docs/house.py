"""Prints what the rooms of each language cost, in lines of code.

python -m docs.house

Blank lines, comments and docstrings are not counted.
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

LANGUAGES: Final = Path(__file__).parent.parent / "assistant" / "languages"
PROGRAM: Final = LANGUAGES.parent / "program"
SHARED_ROOMS: Final = ("checks", "recovery", "runs", "texts")
"""Folders beside the languages that are none: what one room of all of them shares."""
SILENT: Final = frozenset(
    {
        *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT),
        *(tokenize.ENCODING, tokenize.ENDMARKER),
    }
)
"""Tokens that are no code."""


def code_lines(text: str) -> int:
    """Lines of a module on which code stands."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in SILENT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines.difference(_docstrings(ast.parse(text))))


def _docstrings(tree: ast.AST) -> Iterator[int]:
    """Lines of texts that stand on their own, as docstrings do."""
    for node in ast.walk(tree):
        match node:
            case ast.Expr(ast.Constant(str()), lineno=first, end_lineno=int(last)):
                yield from range(first, last + 1)


def sizes() -> dict[str, dict[str, int]]:
    """Lines by language and room; what all languages share is the language `shared`."""
    found = {"shared": {"languages": _lines(LANGUAGES.glob("*.py"))}}
    for room in SHARED_ROOMS:
        found["shared"][room] = _lines((LANGUAGES / room).glob("*.py"))
    for room in ("passes", "analysis"):
        found["shared"][room] = _lines((PROGRAM / room).glob("*.py"))
    for folder in sorted(path.parent for path in LANGUAGES.glob("*/__init__.py")):
        if folder.name in SHARED_ROOMS:
            continue
        rooms = sorted(folder.iterdir())
        inside = {room.stem: _lines(room.rglob("*.py")) for room in rooms if room.is_dir()}
        files = _lines(folder.glob("*.py"))
        found[folder.name] = {k: n for k, n in inside.items() if n} | {"its own files": files}
    return found


def _lines(files: Iterable[Path]) -> int:
    return sum(code_lines(file.read_text("utf-8")) for file in files)


def table(sizes: Mapping[str, Mapping[str, int]]) -> str:
    """A row for each room, a column for each language."""
    rooms = sorted({room for inside in sizes.values() for room in inside})
    lines = [f"{'':14}" + "".join(f"{name:>14}" for name in sizes)]
    for room in rooms:
        counts = (inside.get(room, "") for inside in sizes.values())
        lines.append(f"{room:14}" + "".join(f"{count:>14}" for count in counts))
    totals = (sum(inside.values()) for inside in sizes.values())
    lines.append(f"{'all':14}" + "".join(f"{total:>14}" for total in totals))
    return "\n".join(lines)


if __name__ == "__main__":
    sys.stdout.write(table(sizes()) + "\n")
