"""Files and communication lines: their numbers, names and modes.

Sources: COSIROP help and the CR controller manuals (Open, Print, Input, Close, M_Open); BFP-A3379,
Ethernet function (COMDEV, CPRCE11 to 19, NETMODE, NETPORT, NETHSTIP).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from assistant.program.statements import ChannelMode

FILE_NUMBERS: Final = range(1, 9)
"""Files that may be open at once."""
FILE_MODES: Final[Mapping[str, ChannelMode]] = {
    "Input": "read",
    "Output": "write",
    "Append": "append",
}
FILE_MODE_WORDS: Final[Mapping[str, str]] = {mode: word for word, mode in FILE_MODES.items()}
LINE_NAME: Final = re.compile(r"\s*COM([1-8]):\s*", re.IGNORECASE)
ETHERNET_LINES: Final = (3, 4, 5, 6, 7, 8, 2)
"""Lines that channels of TCP/IP get, in this order: the first ones are often serial."""
LONGEST_FILE_NAME: Final = 16
"""Characters of the name of a file (COSIROP: OPEN)."""
CONNECTION_STATUS: Final = "M_Open"


def line_name(number: int) -> str:
    return f"COM{number}:"
