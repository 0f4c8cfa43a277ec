"""The texts of the page: every word has its row, in every language."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Final

import pytest

from assistant import studio
from assistant.studio.app import FIRST_LANGUAGE, words
from assistant.studio.studio import SUFFIX_KINDS

FOLDER: Final = Path(studio.__file__).parent
USED: Final = (
    r'data-(?:word|title|placeholder)="(\w+)"',
    r'\bword\("(\w+)"\)',
    r'\bsaid\("\w+", "(\w+)"',
    r'dataset\.(?:word|title) = "(\w+)"',
)
"""How the page and its scripts ask for a word."""


def table(language: str) -> dict[str, str]:
    return tomllib.loads((FOLDER / "words" / f"{language}.toml").read_text(encoding="utf-8"))


def sources() -> dict[str, str]:
    files = (FOLDER / "studio.html", *sorted((FOLDER / "scripts").glob("*.js")))
    return {file.name: file.read_text(encoding="utf-8") for file in files}


def test_every_word_that_is_asked_for_has_a_row() -> None:
    known = table(FIRST_LANGUAGE)
    asked = {
        (name, key)
        for name, text in sources().items()
        for form in USED
        for key in re.findall(form, text)
    }
    assert len(asked) > 60
    assert sorted((name, key) for name, key in asked if key not in known) == []


def test_every_row_is_asked_for() -> None:
    names = set(re.findall(r"\w+", "\n".join(sources().values())))
    kinds = {*SUFFIX_KINDS.values(), "process", "program", "project", "settings", "table", "file"}
    composed = {f"kind_{kind}" for kind in kinds}  # of files, as the tree has them
    assert sorted(set(table(FIRST_LANGUAGE)) - names - composed) == []
    assert composed <= set(table(FIRST_LANGUAGE))


@pytest.mark.parametrize("language", sorted(set(words()) - {FIRST_LANGUAGE}))
def test_every_language_has_every_word(language: str) -> None:
    known, theirs = table(FIRST_LANGUAGE), table(language)
    assert sorted(set(known) ^ set(theirs)) == []
    assert all(isinstance(text, str) and text.strip() == text != "" for text in theirs.values())
    assert "<" not in "".join(theirs.values())


def test_german_and_japanese_are_there() -> None:
    assert {"de", "en", "ja"} <= set(words())
