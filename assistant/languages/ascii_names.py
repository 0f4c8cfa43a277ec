r"""Names in the ASCII of a comment: letters beyond it are written as `\xf6` or `\u4e2d`.

A controller, and the tools around it, may open a file in any code page.
"""

from __future__ import annotations

import re
from typing import Final

_ESCAPE: Final = r"\\(?:x[0-9a-f]{2}|u[0-9a-f]{4}|U[0-9a-f]{8})"

ASCII_NAME: Final = rf"(?:[A-Za-z_]|{_ESCAPE})(?:[A-Za-z0-9_]|{_ESCAPE})*"
"""The regular expression of a name as `in_ascii` writes it."""


def in_ascii(name: str) -> str:
    return name.encode("ascii", "backslashreplace").decode("ascii")


def from_ascii(text: str) -> str:
    """The name that was written; the text as it stands if that is none."""
    name = re.sub(_ESCAPE, lambda m: chr(min(int(m[0][2:], 16), 0x10FFFF)), text)
    return name if re.fullmatch(r"[^\W\d]\w*", name) else text
