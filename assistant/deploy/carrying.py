"""Carries the programs of a journal to the controller, forward or back, and verifies each.

Every step may be done again: what is already there is only verified. So the same code deploys,
finishes what somebody else began, and takes it back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.deploy import rules
from assistant.deploy.clashing import in_the_way
from assistant.deploy.held import Held
from assistant.deploy.journal import Entry, Journal, Step
from assistant.deploy.outcome import FileState
from assistant.deploy.site import RECORD, Site

PUT_BACK_TIMEOUT: Final = 20.0
"""Seconds for which what cannot be put back is tried again: a controller keeps a dead session,
and the program that it had open, for a while."""
Progress = Callable[[Entry], None]
"""Is told each program before it is changed."""
Tell = Callable[[Diagnostic], None]
"""Is given what a user has to know before all is over."""


class Transfer:
    """A journal on its way. states: of its programs, by name."""

    def __init__(self, site: Site, journal: Journal, patience: float = PUT_BACK_TIMEOUT) -> None:
        self.site, self.journal, self.patience = site, journal, patience
        site.patience = min(site.patience, patience)
        self.states: dict[str, FileState] = {}
        self.findings: list[Diagnostic] = []

    def forward(self, entries: Iterable[Entry], progress: Progress | None = None) -> None:
        """Installs them one by one; raises Refused at the first that fails."""
        entries = tuple(entries)
        self._make_room([(entry.name, entry.after, entry.before) for entry in entries])
        for entry in entries:
            if progress is not None:
                progress(entry)
            self.journal.add(Step.WRITING, entry.name)
            self.states[entry.name] = FileState.UNKNOWN
            self.site.put(entry.name, entry.after, entry.before)
            self._verify(entry)
            self.journal.add(Step.VERIFIED, entry.name)
            self.states[entry.name] = FileState.INSTALLED

    def back(self, entries: Iterable[Entry], *, connected: bool) -> bool:
        """Every program becomes what it was; whether all could be seen to be that.

        connected: whether the session can be used as it is.
        """
        entries = tuple(entries)
        room = partial(self._make_room, [(e.name, e.before, e.after) for e in entries])
        whole, connected = self._insisted(self.clear_rests, connected)
        if whole:
            whole, connected = self._insisted(room, connected)
        for entry in entries:
            try:
                restore = partial(self._restore, entry)
                touched = self.site.insist(restore, self.patience, connected=connected)
            except Refused as refusal:
                whole = connected = False
                self.findings += refusal.findings
                self.findings.append(self._not_put_back(entry))
                self.states[entry.name] = FileState.UNKNOWN
            else:
                connected = True
                self.states[entry.name] = FileState.PUT_BACK if touched else FileState.UNTOUCHED
                if touched:
                    gone = entry.before.file is None
                    rule = rules.REMOVED if gone else rules.PUT_BACK
                    self.findings.append(rule(place=entry.name, name=entry.name))
        if whole:
            whole, _ = self._insisted(self._restore_record, connected)
        return whole

    def _make_room(self, steps: Sequence[tuple[str, Held, Held]]) -> None:
        """Takes modules out of memory whose names others of them get."""
        memory = self.site.memory
        for name, old in in_the_way(self.site, steps) if memory is not None else ():
            now = self.site.held(name, old.file)
            if memory is None or old.loaded is None or now.loaded is None:
                continue
            if self.site.forms(now).loaded == self.site.forms(old).loaded:
                self.journal.add(Step.WRITING, name)
                self.states[name] = FileState.UNKNOWN
                memory.put_out(old.loaded, self.site.task)

    def clear_rests(self) -> None:
        """Deletes what a step that was cut left beside the programs."""
        self.site.clear_rests(
            {
                entry.name: {
                    data
                    for held in (entry.before, entry.after)
                    for data in (held.file, held.loaded)
                    if data is not None
                }
                for entry in self.journal.entries
            }
        )

    def keep_record(self) -> None:
        """The controller gets the record of what it has now."""
        if self.site.disk is not None:
            self.site.controller.write(RECORD, self.journal.record.written())

    def _restore_record(self) -> None:
        """The record that was there before is there again."""
        earlier, controller = self.journal.earlier, self.site.controller
        if self.site.disk is None or controller.read(RECORD) == earlier:
            return
        if earlier is None:
            controller.remove(RECORD)
        else:
            controller.write(RECORD, earlier)

    def _insisted(self, act: Callable[[], None], connected: bool) -> tuple[bool, bool]:
        """Whether something could be done, and whether there is a session then."""
        try:
            self.site.insist(act, self.patience, connected=connected)
        except Refused as refusal:
            self.findings += refusal.findings
            return False, False
        return True, True

    def unknown(self, entries: Iterable[Entry]) -> list[Diagnostic]:
        """Programs that neither this deployment nor what was before left as they are now."""
        return [
            rules.CHANGED_BETWEEN(place=entry.name, name=entry.name)
            for entry in entries
            if not self._known(entry)
        ]

    def _known(self, entry: Entry) -> bool:
        """Whether what is there is of this deployment; between two steps it may be a mixture."""
        now = self.site.forms(self._now(entry))
        known = [self.site.forms(held) for held in (entry.before, entry.after)]
        # On its way into memory a file holds what is to be loaded.
        raw = [Held(held.loaded) for held in (entry.before, entry.after)]
        files = {None, *(held.file for held in known), *(self.site.forms(h).file for h in raw)}
        return now.file in files and now.loaded in {None, *(held.loaded for held in known)}

    def _now(self, entry: Entry) -> Held:
        return self.site.held(entry.name, entry.after.file or entry.before.file)

    def _verify(self, entry: Entry) -> None:
        wanted, now = self.site.forms(entry.after), self.site.forms(self._now(entry))
        pairs = ((wanted.file, now.file), (wanted.loaded, now.loaded))
        for sent, read in pairs:
            if sent != read:
                raise Refused(_altered_finding(entry.name, sent or b"", read or b""))

    def _restore(self, entry: Entry) -> bool:
        if self.site.same(self._now(entry), entry.before):
            return False
        self.site.put(entry.name, entry.before, entry.after)
        if not self.site.same(self._now(entry), entry.before):
            raise Refused()
        return True

    def _not_put_back(self, entry: Entry) -> Diagnostic:
        folder = self.journal.folder / "before"
        old = f"what it was is in `{folder}`" if entry.before.file is not None else "it was new"
        return rules.NOT_PUT_BACK(place=entry.name, name=entry.name, backup=old)


def _altered_finding(name: str, sent: bytes, read: bytes) -> Diagnostic:
    """The finding with the first line that differs."""
    left, right = (data.split(b"\r\n") for data in (sent, read))
    shorter = min(len(left), len(right))
    at = next((i for i in range(shorter) if left[i] != right[i]), shorter)
    shown = [
        repr(lines[at].decode("latin-1")[:60]) if at < len(lines) else "nothing"
        for lines in (left, right)
    ]
    return rules.ALTERED(place=name, row=at + 1, name=name, sent=shown[0], read=shown[1])
