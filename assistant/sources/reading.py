"""Result of reading a source."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Protocol

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.program import Program
from assistant.sources.seen_settings import NO_SEEN_SETTINGS, SeenSettings

if TYPE_CHECKING:
    from assistant.sources.process import Process, ProgramStyle


@dataclass(frozen=True, slots=True)
class Reading:
    """The pseudo-program of a source, and what was found on the way.

    joint_percent, seen: see `Process`. style: of the program, None if nothing states one.
    """

    program: Program
    findings: tuple[Diagnostic, ...] = ()
    joint_percent: float | None = None
    seen: SeenSettings = NO_SEEN_SETTINGS
    style: ProgramStyle | None = None


class Reader(Protocol):
    def __call__(self, path: FilePath, process: Process) -> Reading: ...
