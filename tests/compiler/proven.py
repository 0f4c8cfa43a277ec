"""Small programs that cross over, with the proof of their motion."""

from __future__ import annotations

from typing import Any

from assistant.base.source_text import SourceText
from assistant.compiler import Translation, translate
from assistant.compiler.loader import load_text
from assistant.compiler.motion_proof import Proving

SIX = "melfa-basic-6"


def crossed(
    text: str,
    language: str = "rapid",
    to: str = SIX,
    *,
    runs: int = 1,
    seconds: float = 2.0,
    **options: Any,
) -> Translation:
    """The translation of a text, run on both sides.

    runs, seconds: how often at the most, with other inputs each time, and how long.
    """
    loaded = load_text(SourceText(text), language=language)
    return translate(loaded, to=to, proving=Proving(runs=runs, seconds=seconds), **options)


def crossed_module(head: str, body: str, **options: Any) -> Translation:
    """See `crossed`: a module of RAPID, of which `head` is the beginning."""
    return crossed(f"{head}{body}\nENDMODULE\n", **options)


def moves_the_same(done: Translation) -> int:
    """How many places both sides visit; fails where the translation is not proven by moves."""
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    assert done.motion is not None and done.motion.found is not None
    assert done.motion.found.visits
    return done.motion.found.visits
