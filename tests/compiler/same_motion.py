"""Source and translation run by the interpreters of `assistant.virtual`, which never lift."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from assistant import languages
from assistant.compiler import Translation, translate
from assistant.program.geometry import Pose
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Moved, Run
from assistant.virtual.proving.comparison import difference
from tests.virtual.one_cycle import one_cycle

MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")


def translated(folder: Path, text: str, to: str, **options: Any) -> Translation:
    """The text of either language in another one, without an arm."""
    name = "cell.mod" if text.lstrip().startswith("MODULE") else "CELL.mb5"
    (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return translate(folder / name, to=to, **options)


def ran(text: str, language: str, entry: str = "main") -> Run:
    """One cycle of a program; all inputs are 0."""
    tree = languages.get(language).parse(one_cycle(text))
    start = Pose((400.0, 0.0, 500.0), (0.0, 1.0, 0.0, 0.0))
    if language == "rapid":
        return rapid.run(tree, entry=entry, start=start)
    return melfa.run(tree, start=start)


def moves_alike(folder: Path, text: str, to: str, moves: int, **options: Any) -> str:
    """The text of the translation, which moves and switches as its source does.

    moves: how many motions the source makes, so that the test runs what it means to.
    """
    found = translated(folder, text, to, **options)
    assert found.ok, [str(f) for f in found.findings]
    (data,) = found.files.values()
    made = data.decode("ascii")
    source = "rapid" if text.lstrip().startswith("MODULE") else "melfa-basic-5"
    first, second = ran(text, source, options.get("entry", "main")), ran(made, to)
    assert (first.ended, second.ended) == ("end", "end"), (first.message, second.message, made)
    assert len([x for x in first.events if isinstance(x, Moved)]) == moves
    assert difference(first, second) is None, (difference(first, second), made)
    return made
