"""What became of a deployment."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path as FilePath

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.controllers import Address


class FileState(enum.StrEnum):
    """What a program on the controller is after a deployment."""

    SAME = "same"
    """It was already what was to be sent."""
    INSTALLED = "installed"
    """Sent, read back and found equal."""
    UNTOUCHED = "untouched"
    """Still what it was before."""
    PUT_BACK = "put back"
    """Was changed, and is again what it was before (or gone, if it was new)."""
    UNKNOWN = "unknown"
    """Could not be put back or not be read: somebody has to look."""


@dataclass(frozen=True, slots=True)
class Deployment:
    """What became of a plan.

    states: state of each planned program, by its name on the controller. folder: in the history,
    with what was there before; None if nothing was to be changed. back: whether it was asked to
    take a deployment back.
    """

    address: Address
    states: dict[str, FileState]
    findings: tuple[Diagnostic, ...] = ()
    folder: FilePath | None = None
    back: bool = False

    @property
    def ok(self) -> bool:
        forward = (FileState.SAME, FileState.INSTALLED)
        backward = (FileState.PUT_BACK, FileState.UNTOUCHED)
        done = backward if self.back else forward
        return not has_errors(self.findings) and all(s in done for s in self.states.values())

    @property
    def summary(self) -> str:
        """One sentence on the state of the controller."""
        states = list(self.states.values())
        unknown = [name for name, state in self.states.items() if state is FileState.UNKNOWN]
        if unknown:
            return f"{', '.join(unknown)} on {self.address}: not in a known state; do not start it"
        if self.back or not self.ok:
            return f"every program on {self.address} is what it was before"
        installed = states.count(FileState.INSTALLED)
        same = states.count(FileState.SAME)
        return f"{installed} installed and verified, {same} already there on {self.address}"
