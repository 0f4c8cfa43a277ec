"""The same program in another layout: blanks, line ends, case of words, jumps spelled in full."""

from __future__ import annotations

import re
from typing import Final

TOKENS: Final = re.compile(
    r"""(?P<comment>'[^\r\n]*|\bREM(?![A-Z0-9_])[^\r\n]*) | (?P<string>"[^"\r\n]*")
    | (?P<word>\#INCLUDE|[A-Z]\w*[$%&!\#]?)
    | (?P<number>(?:(?<=[(,])[+-])?(?:&H[0-9A-F]+|&B[01]+|(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?)
      [%&!\#]?)
    | (?P<mark><>|><|<=|=<|>=|=>|<<|>>|\S)""",
    re.VERBOSE | re.IGNORECASE,
)
