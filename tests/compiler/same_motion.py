"""Source and translation run by the interpreters of `assistant.virtual`, which never lift."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from assistant import languages
from assistant.compiler import Translation, translate
from assistant.program.geometry import Pose
from assistant.program.rotations import angle_between
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Event, Moved, Run

NEAR_MM, NEAR_DEGREES = 0.02, 0.02
"""What printed decimals of targets, tools and frames may add up to."""
MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")


def translated(folder: Path, text: str, to: str, **options: Any) -> Translation:
    """The text of either language in another one, without an arm."""
    name = "cell.mod" if text.lstrip().startswith("MODULE") else "CELL.mb5"
    (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return translate(folder / name, to=to, **options)


def ran(text: str, language: str, entry: str = "main") -> Run:
    """One cycle of a program; all inputs are 0."""
    tree = languages.get(language).parse(text)
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
    there, back = map(_motions, (first.events, second.events))
    assert len(there) == moves
    assert len(back) == moves, made
    for number, (one, other) in enumerate(zip(there, back, strict=True)):
        assert _same(one, other), (number, one, other, made)
    return made


def _motions(events: tuple[Event, ...]) -> list[Event]:
    """What moves; a move to where the arm stands already is none."""
    return [event for event in events if isinstance(event, Moved)]


def _same(one: Event, other: Event) -> bool:
    assert isinstance(one, Moved)
    assert isinstance(other, Moved)
    assert one.flange is not None
    assert other.flange is not None
    poses = [(one.flange, other.flange), (one.tool, other.tool)]
    return one.kind == other.kind and all(_near(a, b) for a, b in poses)


def _near(a: Pose, b: Pose) -> bool:
    apart = np.linalg.norm(np.subtract(a.position, b.position))
    turned = angle_between(np.array(a.quaternion), np.array(b.quaternion))
    return bool(apart < NEAR_MM and float(turned) < NEAR_DEGREES)
