"""What words of a language do, in a sentence each, from a text file of its tables."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files


def abouts(package: str) -> Mapping[str, str]:
    """Sentences by lower-case word, of `abouts.txt` in a package: lines `word, word: sentence`."""
    text = files(package).joinpath("abouts.txt").read_text("utf-8")
    told: dict[str, str] = {}
    for line in text.splitlines():
        listed, colon, sentence = line.partition(": ")
        if colon and not line.startswith("#"):
            told |= {word.strip().lower(): sentence.strip() for word in listed.split(",")}
    return told
