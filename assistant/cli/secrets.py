"""Passwords that were typed with an address: refused before any command can repeat them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from assistant.base.diagnostics import Refused

NOT_AN_ADDRESS: Final = re.compile(r"[A-Za-z_$][^=:@/]*=|[A-Za-z]:[\\/]")
"""What gives something a value, `text="a:b@c"`, and what stands on a drive of Windows."""


def refuse_passwords(words: Sequence[str]) -> None:
    """Raises Refused, of exit status 2, if one looks like an address that holds a password.

    Whichever command and option it belongs to: what takes no address would take it for a file.
    """
    for word in words:
        if not ("@" in word or "%" in word) or NOT_AN_ADDRESS.match(word) or _path_exists(word):
            continue
        from assistant.controllers import rules
        from assistant.controllers.address import holds_password, without_password

        if holds_password(word):
            _adopt_format(words)
            finding = rules.PASSWORD_IN_ADDRESS(place=without_password(word))
            raise Refused(finding, exit_status=2)


def _path_exists(word: str) -> bool:
    """Whether it is the name of a file or a folder."""
    try:
        return Path(word).exists()
    except (OSError, ValueError):
        return False


def _adopt_format(words: Sequence[str]) -> None:
    """What reads the options has not been there yet."""
    from assistant.cli.presentation import FindingFormat, PlanFormat, answer_as

    text = " ".join(words)
    for format in (one for one in FindingFormat if one is not FindingFormat.TEXT):
        if re.search(rf"--format[ =]{format}\b", text):
            answer_as(format)
    if re.search(rf"--format[ =]{PlanFormat.MARKDOWN}\b", text):
        answer_as(PlanFormat.MARKDOWN)
