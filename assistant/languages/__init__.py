"""Vendor languages by name. A new one is a folder here, a grammar, and a row of `ROOMS`."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import UnknownName, error
from assistant.base.near_names import did_you_mean
from assistant.base.source_text import path_of
from assistant.languages.language import Language
from assistant.languages.language_types import Adapted, Precision, Tree
from assistant.program.expressions import Effect
from assistant.program.vendor_statements import VendorText, vendor_text_kind

ROOMS: Final = {
    "rapid": "assistant.languages.rapid",
    "melfa-basic-4": "assistant.languages.melfa_basic",
    "melfa-basic-5": "assistant.languages.melfa_basic",
    "melfa-basic-6": "assistant.languages.melfa_basic",
}
"""Language name → package, whose `language(name)` gives the `Language`."""

__all__ = ["Adapted", "Language", "Precision", "Tree", "effect", "get", "names", "of_file"]


_UNKNOWN_LANGUAGE: Final = error("CO001", "there is no language `{name}`", "{cure}")
_LONGEST_NAME: Final = 80


def names() -> tuple[str, ...]:
    """The languages, in the order in which they are listed."""
    return tuple(ROOMS)


def get(name: str) -> Language[Any]:
    """Return the language of that name, in any case; raises Refused, also a KeyError, without
    one.
    """
    known = str(name)[:_LONGEST_NAME]
    known = known if known in ROOMS else known.lower()
    if known not in ROOMS:
        cure = did_you_mean(known, ROOMS, f"choose one of {', '.join(ROOMS)}")
        raise UnknownName(_UNKNOWN_LANGUAGE(name=str(name)[:_LONGEST_NAME], cure=cure))
    return _of_room(known)


@cache
def _of_room(name: str) -> Language[Any]:
    language: Language[Any] = importlib.import_module(ROOMS[name]).language(name)
    return language


def effect(kept: VendorText) -> Effect | None:
    """Return the effect of a vendor statement or expression, None for an unknown language."""
    return (
        get(kept.language).effect(kept.text, vendor_text_kind(kept))
        if kept.language in ROOMS
        else None
    )


def of_file(path: str | FilePath, data: bytes) -> Language[Any] | None:
    """Return the language of a file, by its content and its suffix; None if no language fits.

    `.prg` is used by both vendors, so each candidate's `recognises` inspects the text. A file
    without a suffix, or a `.txt`, may be any language's, if it is text.
    """
    suffix = path_of(path).suffix.lower()
    spoken = [get(name) for name in names()]
    # A binary mark identifies the language even if the suffix is another's.
    foreign = [one for one in spoken if one.begins and data.startswith(one.begins)]
    told = [one for one in foreign or spoken if suffix in one.suffixes]
    if not told and (foreign or (suffix in UNTOLD and b"\0" not in data)):
        told = foreign or spoken
    return next((one for one in told if one.recognises(data, suffix)), None)


UNTOLD: Final = ("", ".txt")
"""Suffixes that identify no language."""
