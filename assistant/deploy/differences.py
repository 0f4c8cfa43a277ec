"""Differences of two versions of a program, as people read them."""

from __future__ import annotations

import difflib
from typing import Final

from assistant.base.source_text import decode, lines_of, visible
from assistant.deploy.comparing import module_difference
from assistant.deploy.held import Held
from assistant.deploy.site import Site

SHOWN_ENCODINGS: Final = ("utf-8", "latin-1")
"""To show a program in; differences are found on its bytes."""
ABSENT_FILE: Final = "/dev/null"
"""Where a program is that is not there, as a unified difference says it."""


def difference(before: bytes | None, after: bytes | None, one: str, other: str) -> str:
    """A unified diff of two versions of a program, "" if there is none. one, other: which ones."""
    left, right = _shown_lines(before or b""), _shown_lines(after or b"")
    origin = one if before is not None else ABSENT_FILE
    target = other if after is not None else ABSENT_FILE
    lines = difflib.unified_diff(left, right, origin, target, lineterm="")
    return "".join(f"{line}\n" for line in lines)


def difference_since(site: Site, name: str, left: Held | None, now: Held) -> str:
    """A unified difference from what the last deployment left to what is there, "" if unknown."""
    if left is None:
        return ""
    one, other = site.forms(left), site.forms(now)
    here = f"{name} (on the controller)"
    text = difference(one.file, other.file, f"{name} (as it was left)", here)
    labels = (f"{name} (loaded, as it was left)", f"{name} (in memory)")
    if left.loaded is not None and now.loaded is not None:
        text += module_difference(left.loaded, now.loaded, site.language, labels)
    elif left.loaded is not None or now.loaded is not None:
        text += difference(left.loaded, now.loaded, *labels)
    return text


def _shown_lines(data: bytes) -> list[str]:
    """The lines, with no character in them that a terminal would obey."""
    lines = lines_of(decode(data, None, SHOWN_ENCODINGS).text)
    return [visible(line) for line in lines if line]
