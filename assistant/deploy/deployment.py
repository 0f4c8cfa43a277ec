"""Carrying out a plan: all files are on the controller and verified, or none is changed."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as FilePath

from assistant.controllers import Address, Programs
from assistant.controllers.rules import Lost
from assistant.deploy import rules
from assistant.deploy.backup import keep
from assistant.deploy.plan import Change, Plan, PlannedFile
from assistant.program.diagnostics import Diagnostic, Refused, has_errors


class FileState(enum.StrEnum):
    """What a file on the controller is after a deployment."""

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

    states: state of each planned file, by its name on the controller. backup: the folder with
    what was there before, None if nothing was to be changed.
    """

    address: Address
    states: dict[str, FileState]
    findings: tuple[Diagnostic, ...] = ()
    backup: FilePath | None = None

    @property
    def ok(self) -> bool:
        done = (FileState.SAME, FileState.INSTALLED)
        return not has_errors(self.findings) and all(s in done for s in self.states.values())

    @property
    def summary(self) -> str:
        """One sentence on the state of the controller."""
        states = list(self.states.values())
        unknown = [name for name, state in self.states.items() if state is FileState.UNKNOWN]
        if unknown:
            return f"{', '.join(unknown)} on {self.address}: not in a known state; do not start it"
        if not self.ok:
            return f"every program on {self.address} is what it was before"
        installed = states.count(FileState.INSTALLED)
        same = states.count(FileState.SAME)
        return f"{installed} installed and verified, {same} already there on {self.address}"


Progress = Callable[[PlannedFile], None]
"""Is told each file before it is sent."""


def deploy(
    plan: Plan, *, backup: str | FilePath | None = None, progress: Progress | None = None
) -> Deployment:
    """Writes the plan's changes to its controller, reads each back, and compares.

    What was there is kept in the backup folder first. If any file fails, every file that was
    changed is put back (after Ctrl-C as well); the findings say what happened, nothing is
    raised for it. A plan
    whose controller has changed meanwhile changes nothing. Never starts motion.
    backup: see `backup.keep`.
    """
    run = _Run(plan)
    if not plan.changes:
        return run.done()
    try:
        with plan.controller:
            run.check_unchanged()
            run.backup = keep(plan.address, plan.changes, backup)
            run.install(progress)
    except Refused as refusal:
        run.findings += refusal.findings
    return run.done()


class _Run:
    """One deployment under way."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.controller: Programs = plan.controller
        self.findings: list[Diagnostic] = []
        self.backup: FilePath | None = None
        self.states = {
            file.name: FileState.SAME if file.change is Change.SAME else FileState.UNTOUCHED
            for file in plan.files
        }

    def done(self) -> Deployment:
        return Deployment(self.plan.address, self.states, tuple(self.findings), self.backup)

    def check_unchanged(self) -> None:
        """Raises Refused if the controller is not what the plan saw."""
        changed = [
            rules.CHANGED_SINCE(place=file.name, name=file.name)
            for file in self.plan.files
            if not self._is_before(file)
        ]
        if changed:
            raise Refused(*changed)

    def install(self, progress: Progress | None) -> None:
        begun: list[PlannedFile] = []
        try:
            for file in self.plan.changes:
                if progress is not None:
                    progress(file)
                begun.append(file)
                self.states[file.name] = FileState.UNKNOWN
                self.controller.write(file.name, file.data)
                self._verify(file)
                self.states[file.name] = FileState.INSTALLED
        except Refused as refusal:
            self.findings += refusal.findings
            self._put_back(begun, connected=not isinstance(refusal, Lost))
        except KeyboardInterrupt:
            name = begun[-1].name if begun else ""
            self.findings.append(rules.INTERRUPTED(place=name, name=name))
            self._put_back(begun, connected=False)  # an answer may still be on its way
        except BaseException:
            self._put_back(begun, connected=False)
            raise

    def _verify(self, file: PlannedFile) -> None:
        back = self.controller.read(file.name)
        sent = self.controller.stored(file.data)
        read = self.controller.stored(back or b"")
        if sent != read:
            raise Refused(_altered(file.name, sent, read))

    def _put_back(self, begun: list[PlannedFile], *, connected: bool) -> None:
        """Every file that was begun becomes what it was, the last one first."""
        for file in reversed(begun):
            try:
                if not connected:
                    self._reconnect()
                    connected = True
                touched = self._restore(file)
            except Refused as refusal:
                connected = connected and not isinstance(refusal, Lost)
                self.findings += refusal.findings
                self.findings.append(self._not_put_back(file))
                self.states[file.name] = FileState.UNKNOWN
            else:
                self.states[file.name] = FileState.PUT_BACK if touched else FileState.UNTOUCHED
                if touched:
                    rule = rules.REMOVED if file.before is None else rules.PUT_BACK
                    self.findings.append(rule(place=file.name, name=file.name))

    def _reconnect(self) -> None:
        self.controller.__exit__(None, None, None)
        self.controller.__enter__()

    def _restore(self, file: PlannedFile) -> bool:
        """Whether there was anything to put back; raises Refused if it failed."""
        if self._is_before(file):
            return False
        if file.before is None:
            self.controller.remove(file.name)
        else:
            self.controller.write(file.name, file.before)
        if not self._is_before(file):
            raise Refused()
        return True

    def _is_before(self, file: PlannedFile) -> bool:
        now = self.controller.read(file.name)
        if now is None or file.before is None:
            return now is file.before
        return self.controller.stored(now) == self.controller.stored(file.before)

    def _not_put_back(self, file: PlannedFile) -> Diagnostic:
        old = f"what it was is in `{self.backup}`" if file.before is not None else "it was new"
        return rules.NOT_PUT_BACK(place=file.name, name=file.name, backup=old)


def _altered(name: str, sent: bytes, read: bytes) -> Diagnostic:
    """The finding with the first line that differs."""
    left, right = (data.split(b"\r\n") for data in (sent, read))
    shorter = min(len(left), len(right))
    at = next((i for i in range(shorter) if left[i] != right[i]), shorter)
    shown = [
        repr(lines[at].decode("latin-1")[:60]) if at < len(lines) else "nothing"
        for lines in (left, right)
    ]
    return rules.ALTERED(place=name, row=at + 1, name=name, sent=shown[0], read=shown[1])
