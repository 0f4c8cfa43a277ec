"""Text from outside as a terminal, a log or a page may show it: nothing in it that they obey."""

from __future__ import annotations

import re
from typing import Final

STEERING: Final = (
    "\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u0600-\u0605\u061c\u06dd\u070f\u0890\u0891\u08e2\u180e"
    "\u200b-\u200f\u2028-\u202e\u2060-\u2064\u2066-\u206f\ud800-\udfff\ufeff\ufff9-\ufffb\ufffe\uffff"
    "\U000110bd\U000110cd\U00013430-\U0001343f\U0001bca0-\U0001bca3\U0001d173-\U0001d17a"
    "\U000e0001\U000e0020-\U000e007f"
)
"""Control and format characters, ends of lines and paragraphs, and what stands for bytes that are
no text (Unicode's Cc, Cf, Zl, Zp and Cs), and the two code points that no XML may hold, for a class
of a regular expression; not the tab and the line feed."""
_SHOWN_AS_MARK: Final = re.compile(f"[{STEERING}\n]")


def visible(text: str) -> str:
    """The text on one line, with a mark for what steers a terminal or turns a text around."""
    return _SHOWN_AS_MARK.sub("�", text)
