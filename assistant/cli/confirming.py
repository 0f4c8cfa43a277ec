"""What may move an arm is asked for: by `--yes`, or by typing the controller's name."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.controllers import Named

NOT_CONFIRMED: Final = error(
    "CL203",
    "this {what}, and nobody confirmed it; nothing was changed",
    "look that nobody is near, then add --yes, or run it in a terminal and type `{word}`",
)
OTHER_WORD: Final = error(
    "CL204",
    "`{word}` was not typed, so nothing was changed",
    "type it as it stands there to confirm",
)


def confirm(one: Named, what: str, yes: bool) -> None:
    """Returns if somebody wants it; raises Refused else. what: it does, to be read after "this"."""
    if yes:
        return
    if not sys.stdin.isatty():
        raise Refused(
            NOT_CONFIRMED(place=str(one.address), what=what, word=one.word), exit_status=2
        )
    sys.stderr.write(f"{one.name}: this {what}.\nType `{one.word}` to confirm: ")
    sys.stderr.flush()
    if sys.stdin.readline().strip() != one.word:
        raise Refused(OTHER_WORD(place=str(one.address), word=one.word), exit_status=2)
