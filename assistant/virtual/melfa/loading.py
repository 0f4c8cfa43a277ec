"""Programs of MELFA-BASIC in the slots of a controller."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from assistant.base.diagnostics import Refused, error
from assistant.virtual.parts import Group

SEVERAL_PROGRAMS: Final = error(
    "VC202",
    "the folder holds {count} programs: {names}",
    "name the one of slot 1 first, then those of the other slots",
)
TOO_MANY: Final = error(
    "VC203", "there are {count} programs for the {most} slots of a controller", "name fewer"
)
MOST_SLOTS: Final = 32
"""The most that the parameter TASKMAX may say; it is 8 at first (CR1D 4.2)."""


def melfa_slots(files: Sequence[str], folder: str | None) -> list[Group]:
    """The first program in slot 1, the next one in slot 2, and so on."""
    if folder is not None and len(files) > 1:
        names = ", ".join(f"`{Path(file).name}`" for file in files)
        raise Refused(SEVERAL_PROGRAMS(path=folder, count=len(files), names=names), exit_status=2)
    if len(files) > MOST_SLOTS:
        raise Refused(TOO_MANY(count=len(files), most=MOST_SLOTS), exit_status=2)
    return [Group(str(slot), (file,)) for slot, file in enumerate(files, 1)]
