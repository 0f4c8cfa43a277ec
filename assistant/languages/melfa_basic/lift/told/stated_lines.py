"""Communication lines whose other end the program states itself: `C_Com(2)="ETH:10.0.0.5,2001"`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.contents import everywhere
from assistant.program.program import Program
from assistant.program.rewriting import exchanged, rewrite

_STATES: Final = re.compile(
    r'C_Com\((\d+)\)\s*=\s*"ETH:\s*(\d+(?:\.\d+){3})\s*,\s*(\d+)\s*"', re.IGNORECASE
)
"""The line, the address of the other computer and its port (manual of the Ethernet function)."""


def with_stated_lines(program: Program) -> Program:
    """The program with clients for the lines that it states one address of."""
    texts = [match for one in everywhere(program, p.Opaque) if (match := _stated(one))]
    if not texts:
        return program
    ends: dict[int, set[tuple[str, int]]] = {}
    for match in texts:
        ends.setdefault(int(match[1]), set()).add((match[2], int(match[3])))
    known = {line: next(iter(found)) for line, found in ends.items() if len(found) == 1}

    def opened(part: Any) -> Any:
        match part:
            case p.Attach(kind="line", place=(e.Number(number),)) if number in known:
                address, port = known[int(number)]
                return replace(part, kind="client", place=(e.Text(address), e.Number(port)))
        return part

    def left(node: p.Opaque) -> Iterator[p.Statement]:
        match = _stated(node)
        if match is None or int(match[1]) not in known:
            yield node

    return exchanged(rewrite(program, opened), left)


def _stated(node: p.Opaque) -> re.Match[str] | None:
    return _STATES.fullmatch(node.text.strip())
