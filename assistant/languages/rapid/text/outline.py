"""Sections of an emitted module."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from assistant.languages.language_types import Outline
from assistant.languages.rapid.text.header import is_header_item

_OPENING_COMMENTS: Final = re.compile(r"(?: *!.*\n)*")
_ROUTINE_LINE: Final = re.compile(
    r"^(?:\r?\n)?    (?:LOCAL )?(?:(?:PROC|FUNC \w+) \w+\(|TRAP )", re.MULTILINE
)
_TARGET_LINE: Final = re.compile(
    r"^    (?:(?:LOCAL|TASK) )?CONST (?:robtarget|jointtarget) .*;\r?\n", re.MULTILINE
)
_END: Final = "ENDMODULE"


def sections(text: str) -> Mapping[str, str]:
    """The lines between `MODULE` and `ENDMODULE`: opening comments, declarations, routines."""
    start, end = text.index("\n") + 1, text.rindex(_END)
    comments = _OPENING_COMMENTS.match(text, start, end)
    below = comments.end() if comments else start
    routine = _ROUTINE_LINE.search(text, below, end)
    first = routine.start() if routine else end
    return {
        "header": text[start:below],
        "declarations": text[below:first],
        "routines": text[first:end],
    }


def _module_name(text: str) -> str:
    found = re.match(r"MODULE (\w+)", text)
    return found[1] if found else ""


OUTLINE: Final = Outline(
    template="rapid/module.mod.j2",
    sections=sections,
    within={
        "data": ("declarations", lambda text: _TARGET_LINE.sub("", text)),
        "targets": ("declarations", lambda text: "".join(_TARGET_LINE.findall(text))),
    },
    name=_module_name,
    rank={"MODULE": 0, "header": 1, "declarations": 2, "data": 2, "targets": 2, "routines": 3}
    | {_END: 4},
    complete=(
        ("MODULE", "header", "declarations", "routines", _END),
        ("MODULE", "header", "data", "targets", "routines", _END),
    ),
    item=is_header_item,
    frame={
        # A system module has no `main`; the other attributes change nothing that the program does.
        # Their order and what excludes what: technical reference manual, RAPID kernel, modules.
        "MODULE": r"MODULE {name} ?(?:\( ?(?:NOVIEW|NOSTEPIN(?: ?, ?(?:VIEWONLY|READONLY))?"
        r"|VIEWONLY|READONLY) ?\))?",
        _END: _END,
    },
    numbered=lambda _: None,
    blank=True,
)
