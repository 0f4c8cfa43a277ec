"""Changed programs written in another language: whatever they say, what is written is proven."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final

import assistant
from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from assistant.languages.language_types import Frames
from tests.fuzz import programs
from tests.fuzz.target import Target, promise, refusing, sound

FRAMES: Final[tuple[Frames, ...]] = ("base", "product")
ROBOTS: Final = (None, "irb1200-7-0.7", "rv-2aj")


def crossed(name: str | None, data: bytes) -> None:
    """name: of the language, None for pseudo text. The first byte says how it is written."""
    how, data = (data[:1] or b"\0")[0], data[1:]
    to = languages.names()[how % len(languages.names())]
    frames = FRAMES[how // 4 % len(FRAMES)]
    robot = ROBOTS[how // 8 % len(ROBOTS)]
    with refusing("input"):
        if name is None:
            source = SourceText(data.decode("utf-8", "replace"))
        else:
            source = languages.get(name).decode(data, "input" + languages.get(name).suffixes[0])
        loaded = load_text(source, language=name)
        done = assistant.compile(loaded, language=to, frames=frames, robot=robot)
        sound(finding.within("input") for finding in done.findings)  # as every command does
        if done.files:
            promise(done.proof.holds or has_errors(done.found), "written without a proof")


def _target(name: str | None, like: str) -> Target:
    (known,) = (target for target in programs.TARGETS if target.name == like)

    def seeds() -> Iterator[bytes]:
        for number, data in enumerate(known.seeds()):
            for how in range(number % 5, 24, 5):
                yield bytes([how]) + data

    run = partial(crossed, name)
    return Target(f"{like}-crossed", run, lambda: list(seeds()), known.words, most=1200, tried=6)


TARGETS: Final = (
    _target("rapid", "rapid"),
    _target("melfa-basic-4", "melfa-basic-4"),
    _target("melfa-basic-5", "melfa-basic-5"),
    _target(None, "pseudo"),
)
