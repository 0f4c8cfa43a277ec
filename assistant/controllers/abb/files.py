"""Files on the disk of an ABB controller: names that are safe, and how two texts differ."""

from __future__ import annotations

import re
from typing import Final

from assistant.controllers import rules
from assistant.program.diagnostics import Refused

TEMPORARY: Final = "~{name}"
"""Name of a file until it is whole; keeps the suffix, so that a server may look into it."""
MOST_FOLDERS: Final = 32
"""How deep folders are looked into."""


def checked_name(name: str) -> str:
    """The name, if a file of an IRC5 can have it; raises Refused."""
    checks = (
        (not name, "it is empty"),
        (len(name) > 64, "it has more than 64 characters"),
        (name.startswith(("~", ".", "-")), "it must begin with a letter, digit or `_`"),
        (name.endswith(("~", ".", " ")), "it must end with a letter, digit or `_`"),
        (
            re.fullmatch(r"[A-Za-z0-9_. ~-]*", name) is None,
            "only ASCII letters, digits, blanks, `_`, `-` and `.` are safe",
        ),
    )
    for wrong, reason in checks:
        if wrong:
            raise Refused(rules.FILE_NAME(place=name, name=name, reason=reason))
    return name


def first_difference(left: bytes, right: bytes) -> int:
    """Index of the first byte that differs."""
    low, high = 0, min(len(left), len(right))
    while low < high:  # the first `low` bytes are equal, the first `high + 1` are not
        middle = (low + high + 1) // 2
        low, high = (middle, high) if left[:middle] == right[:middle] else (low, middle - 1)
    return low


def checked_path(path: str) -> str:
    """The path of a file or folder below that of the address, `parts/seam.mod`; raises Refused."""
    for part in path.split("/"):
        checked_name(part)
    return path


def told_name(name: str) -> str:
    """A name that a server told, if it is safe as the name of a local file; raises Refused."""
    bad = re.search(r'[\x00-\x1f\x7f/\\:*?"<>|]', name)
    if bad or name in ("", ".", "..") or name.endswith((".", " ")):
        reason = "it cannot be a file of this computer"
        raise Refused(rules.FILE_NAME(place=repr(name), name=repr(name), reason=reason))
    return name
