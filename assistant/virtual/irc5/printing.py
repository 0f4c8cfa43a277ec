"""Modules as a controller prints them from its memory, where it keeps no layout.

Modules of public projects that were saved by controllers show it: values of data with six digits
at most, whole numbers without a point, `9E+09`. How much else is laid out anew no manual at hand
tells: here blanks, indents and line ends are, and comments are gone.
"""

from __future__ import annotations

import re
from typing import Final

from assistant.base.source_text import lines_of
from assistant.languages.rapid import Rapid

COMMENT_LINE: Final = re.compile(r'("[^"\n]*")|[ \t]*!.*')
DATA_LINE: Final = re.compile(
    r"^[ \t]*(?:(?:LOCAL|TASK)[ \t]+)?(?:CONST|PERS|VAR)[ \t].*", re.I | re.M
)
PRINTED_NUMBER: Final = re.compile(r'"[^"]*"|(?<![\w.])\d+(?:\.\d*)?(?:E[+-]?\d+)?(?![\w.])', re.I)


def printed_anew(text: str) -> str:
    """A module in the controller's own layout; data that runs over lines stays as it is."""
    rapid = Rapid()
    lines = COMMENT_LINE.sub(lambda found: found[1] or "", rapid.format(rapid.parse(text)))
    anew = DATA_LINE.sub(lambda found: PRINTED_NUMBER.sub(_printed_number, found[0]), lines)
    return "\n".join(line.strip() for line in lines_of(anew) if line.strip()) + "\n"


def _printed_number(found: re.Match[str]) -> str:
    text = found[0]
    return text if text.startswith('"') or text.isdecimal() else f"{float(text):.6G}"
