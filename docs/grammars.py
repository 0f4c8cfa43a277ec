"""Write the words of MELFA-BASIC into its grammar, from the table of its statements.

python -m docs.grammars
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from assistant.languages.melfa_basic.tables.vocabulary import words

GRAMMAR: Final = Path(__file__).parent.parent / "grammars" / "melfa_basic.lark"
_OWN: Final = re.compile(r"^[A-Z_]+(?:\.\d)?: /([a-z]+)\\b/i$", re.MULTILINE)
"""A word with a terminal to itself."""
SPACED: Final = {"endif": r"end[ \t]*if"}
"""Words that blanks may divide."""
NUMBERED: Final = "mxt"
"""A command that its number may follow without a blank: `Mxt1`."""


def current(text: str) -> str:
    """Return the grammar with its lists of moves and commands as the table has them."""
    own = {*_OWN.findall(text)}
    commands = [word for word in map(str.lower, words("command")) if word not in own]
    listed = {
        "MOTION": _any(map(str.lower, words("motion"))),
        "COMMAND": rf"{_any(commands)}|{NUMBERED}(?=[0-9]+\b)",
    }
    for name, pattern in listed.items():
        head, _, rest = text.partition(f"\n{name}.3: /")
        rest = rest.partition("\n")[2]
        text = f"{head}\n{name}.3: /{pattern}/i\n{rest}"
    return text


def _any(listed: Iterable[str]) -> str:
    spelled = (SPACED.get(word) or word.replace(" ", r"[ \t]+") for word in listed)
    return rf"(?:{'|'.join(spelled)})\b"


if __name__ == "__main__":
    GRAMMAR.write_text(current(GRAMMAR.read_text("utf-8")), "utf-8")
