"""Execution of a plan: all programs are on the controller and verified, or none is changed.

`Transfer` carries the programs of a journal to the controller, forward or back, and verifies each.
Every step may be repeated: what is already there is only verified. So the same code deploys,
finishes an interrupted deployment, and takes one back.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.termination import Termination, raise_on_termination
from assistant.controllers import Address
from assistant.controllers.rules import Lost
from assistant.deploy import rules
from assistant.deploy.history import (
    Entry,
    Journal,
    Step,
    create_journal,
    last_record,
    open_journal,
    pack_journal,
    place_of,
)
from assistant.deploy.lock import check_claim, claim, holder, lock_on_this_computer, unclaim
from assistant.deploy.plan import Change, Plan
from assistant.deploy.preconditions import check_not_running, in_the_way, pointers_lost, tasks
from assistant.deploy.record import Digests, Held, Record, new_record, of_another
from assistant.deploy.site import RECORD, UNDER_WAY, Site


class FileState(enum.StrEnum):
    """State of a program on the controller after a deployment."""

    SAME = "same"
    """It was already what was to be sent."""
    INSTALLED = "installed"
    """Sent, read back and found equal."""
    UNTOUCHED = "untouched"
    """Still what it was before."""
    PUT_BACK = "put back"
    """Was changed, and is again what it was before (or gone, if it was new)."""
    UNKNOWN = "unknown"
    """Could not be put back or read: the user must check it."""


@dataclass(frozen=True, slots=True)
class Deployment:
    """Result of a plan.

    states: state of each planned program, by its name on the controller. folder: in the history,
    with the previous programs; None if nothing had to be changed. back: whether the request was to
    roll a deployment back.
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


PUT_BACK_TIMEOUT: Final = 20.0
"""Seconds for which what cannot be put back is tried again: a controller keeps a dead session,
and the program that it had open, for a while."""
Progress = Callable[[Entry], None]
"""Receives each program before it is changed."""
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
        # All at once, before the first is loaded: two modules may exchange a name.
        self._make_room([(entry.name, entry.after, entry.before) for entry in entries])
        for entry in entries:
            if progress is not None:
                progress(entry)
            # The line is on the disk before the controller is
            # touched: after a crash it tells what may differ.
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
        # Rests first: a file set aside could otherwise pass for another user's program later.
        whole, connected = self._insisted(self.clear_rests, connected)
        if whole:
            whole, connected = self._insisted(room, connected)
        for entry in entries:
            try:
                restore = partial(self._restore, entry)
                touched = self.site.insist(restore, self.patience, connected=connected)
            except Refused as refusal:
                # The others are still put back: each program
                # that is right again is one less to look after.
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
            # Only what is still the old module: a changed one is not this deployment's to remove.
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
        """Retry an action; return whether it succeeded, and whether a session exists then."""
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
        """True if the present content is of this deployment; between two steps it may be a
        mixture.
        """
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


def deploy(
    plan: Plan,
    *,
    history: str | FilePath | None = None,
    files_only: bool = False,
    progress: Progress | None = None,
    patience: float = PUT_BACK_TIMEOUT,
    tell: Tell | None = None,
    leave: Callable[[], bool] | None = None,
) -> Deployment:
    """Write the plan's changes to its controller, read each back, and compare.

    The previous programs are saved in the history first, see `history`. If any program fails, every
    changed one is put back (after Ctrl-C as well); the findings report this, without an exception.
    A plan with conflicts, or whose controller has changed meanwhile, changes nothing; neither does
    one that would replace a running program. Never starts motion. files_only: whether programs may
    be replaced whose taught points this session cannot see. patience: seconds for which a failed
    restoration is tried again. tell: receives urgent findings for the user at once, such as a lost
    line. leave: called while a lost line is tried again; True leaves the deployment open.
    """
    run = _Run(plan, history, patience)
    run.site.tell = tell or run.site.tell
    run.leave = leave
    return run.done(files_only, progress)


class _Run:
    """One deployment under way. place: of its controller in the history."""

    def __init__(self, plan: Plan, history: str | FilePath | None, patience: float) -> None:
        self.plan, self.history, self.patience = plan, history, patience
        self.place = place_of(plan.address, history)
        self.site = plan.site
        self.site.patience = min(self.site.patience, patience)
        self.leave: Callable[[], bool] | None = None
        self.findings: list[Diagnostic] = []
        self.journal: Journal | None = None
        self.states = {
            file.name: FileState.SAME if file.change is Change.SAME else FileState.UNTOUCHED
            for file in plan.files
        }

    def done(self, files_only: bool, progress: Progress | None) -> Deployment:
        plan = self.plan
        try:
            self._check_decided(files_only)
            if plan.changes or plan.unrecorded or open_journal(self.place) is not None:
                with lock_on_this_computer(self.place):
                    self._check_ended()
                    with self.site:
                        if self.site.identity() != plan.identity:
                            raise Refused(rules.ANOTHER(place=str(plan.address)))
                        self._install(progress)
        except Refused as refusal:
            self.findings += refusal.findings
        folder = self.journal.folder if self.journal else None
        return Deployment(plan.address, self.states, tuple(self.findings), folder)

    def _check_decided(self, files_only: bool) -> None:
        """Raise Refused if the user must decide first."""
        refused = [rules.UNDECIDED(place=f.name, name=f.name) for f in self.plan.conflicts]
        replaced = [f for f in self.plan.changes if f.change is Change.CHANGED]
        if self.site.blind and replaced and not files_only:
            refused.append(rules.BLIND(place=str(self.plan.address), name=replaced[0].name))
        if refused:
            raise Refused(*refused)

    def _check_ended(self) -> None:
        """Raises Refused if an earlier deployment from here is open."""
        one = open_journal(self.place)
        if one is not None:
            raise Refused(rules.STILL_OPEN(place=str(one.folder), name=one.record.name))

    def _check_unchanged(self) -> None:
        """Raises Refused if the controller is not what the plan saw, or a program runs."""
        changed = [
            rules.CHANGED_SINCE(place=file.name, name=file.name)
            for file in self.plan.files
            if not self.site.same(self.site.held(file.name, file.data), file.before)
        ]
        if changed:
            raise Refused(*changed)
        record, _ = last_record(self.site, self.history)
        if of_another(self.plan.identity, record) is None and record != self.plan.record:
            raise Refused(rules.DEPLOYED_SINCE(place=str(self.plan.address)))
        check_not_running(self.site, [file.entry for file in self.plan.changes])

    def _install(self, progress: Progress | None) -> None:
        entries = [file.entry for file in self.plan.changes]
        done = carry_out(
            self.site,
            self.place,
            self._record(),
            entries,
            self._check_unchanged,
            self.patience,
            progress,
            self.leave,
        )
        self.journal = done.journal
        self.states |= done.states
        self.findings += done.findings

    def _record(self) -> Record:
        plan = self.plan
        begun = new_record(str(plan.address), plan.identity, self.site.task)
        programs: Mapping[str, Digests] = plan.record.programs if plan.record else {}
        planned = {file.name: self.site.digests(file.after) for file in plan.files}
        return replace(begun, programs={**programs, **planned})


def carry_out(
    site: Site,
    place: FilePath,
    record: Record,
    entries: Sequence[Entry],
    check: Callable[[], None],
    patience: float,
    progress: Progress | None = None,
    leave: Callable[[], bool] | None = None,
) -> Transfer:
    """Write programs to a controller, with a journal; put back programs that fail.

    An interruption, from outside or by Ctrl-C, also puts them back: only once, later ones wait,
    unless the line is lost: then it leaves the deployment open, and so does `leave`. check: called
    once no other computer can deploy to the controller. The findings of the returned transfer
    describe the failures. Raises Refused if nothing could be begun.
    """
    # Before anything is touched: pointers that are lost are told by comparison.
    stood = tasks(site)
    with raise_on_termination(once=True) as ending:
        site.waiting = partial(_waiting, ending, leave or (lambda: False))
        journal = _begun(site, place, record, entries, check, patience, ending)
        carrying = Transfer(site, journal, patience)
        try:
            try:
                carrying.forward(journal.entries, progress)
                settle(carrying)
                # From here on all is done: an interruption must not take it back.
                ending.hold()
            except Refused as refusal:
                ending.hold()
                carrying.findings += refusal.findings
                if isinstance(refusal, Lost):
                    site.lost(refusal, patience)
                _take_back(carrying, connected=not isinstance(refusal, Lost))
        except KeyboardInterrupt:
            ending.hold()
            name = next(reversed(carrying.states), "")
            carrying.findings.append(rules.INTERRUPTED(place=name, name=name))
            _take_back(carrying, connected=False)  # an answer may still be on its way
        except BaseException:
            ending.hold()
            _take_back(carrying, connected=False)
            raise
    if site.reachable:
        with suppress(Refused):  # what became of a lost line is said already
            carrying.findings += pointers_lost(site, stood)
    return carrying


@contextmanager
def _waiting(ending: Termination, leave: Callable[[], bool]) -> Iterator[None]:
    """While a lost line is tried again, which may be interrupted."""
    if leave():
        raise KeyboardInterrupt
    with ending.released():
        yield


def _begun(
    site: Site,
    place: FilePath,
    record: Record,
    entries: Sequence[Entry],
    check: Callable[[], None],
    patience: float,
    ending: Termination,
) -> Journal:
    """Everything that is written down before a program is touched, here and there."""
    try:
        # First the claim, then the check: nobody can change anything between them.
        claim(site, record, patience)
        check()
        earlier = site.controller.read(RECORD) if site.disk is not None else None
        # The journal is on this disk before the first byte goes to the controller.
        journal = create_journal(place, record, entries, earlier)
        if site.disk is not None:
            # The archive lets another computer end the deployment if this one dies.
            site.controller.write(UNDER_WAY, pack_journal(journal))
        # Once more after the archive: another user may have taken this deployment for dead.
        check_claim(site, record)
    except BaseException as caught:
        ending.hold()
        # An exception other than a refusal leaves the session in the middle of a command.
        lost = not isinstance(caught, Refused) or isinstance(caught, Lost)
        held = _abandon(site, place, record, patience, connected=not lost)
        if held and isinstance(caught, Refused):
            raise Refused(*caught.findings, *held, exit_status=caught.exit_status) from None
        raise
    return journal


def _abandon(
    site: Site, place: FilePath, record: Record, patience: float, *, connected: bool
) -> list[Diagnostic]:
    """Ends a deployment before anything was changed; a finding if it may still hold the site."""
    # A journal that cannot be written leaves a deployment without steps, which counts as not begun.
    with suppress(Refused):
        journal = open_journal(place)
        if journal is not None and journal.record.name == record.name:
            journal.add(Step.TAKEN_BACK)

    def free() -> None:
        if holder(site).name == record.name:
            site.clear_rests({})
            unclaim(site, record.name)

    if site.disk is None:
        return []
    try:
        site.insist(free, patience, connected=connected)
    except (Refused, KeyboardInterrupt):
        there = str(site.address)
        reason = "it could not be reached"
        return [rules.STILL_HELD(place=there, name=record.name, reason=reason)]
    return []


def settle(carrying: Transfer) -> None:
    """Ends a deployment whose programs are all there."""
    carrying.keep_record()
    carrying.journal.add(Step.DONE)
    _let_go(carrying)


def take_back(carrying: Transfer, *, connected: bool) -> None:
    """Puts back what was begun; others stay off the controller if that could not be done."""
    journal = carrying.journal
    with suppress(Refused):  # a full disk here is no reason to leave the controller as it is
        journal.add(Step.TAKING_BACK)
    begun = [entry for entry in journal.entries if entry.name in carrying.states]
    # The claim stays if something could not be put back: nobody else may deploy over it.
    if carrying.back(reversed(begun), connected=connected):
        try:
            journal.add(Step.TAKEN_BACK)
        except Refused as refusal:
            carrying.findings += refusal.findings
        else:
            _let_go(carrying)


def _take_back(carrying: Transfer, *, connected: bool) -> None:
    """Take the deployment back; leave it open if the user interrupts the wait for a lost line."""
    try:
        take_back(carrying, connected=connected)
    except KeyboardInterrupt:
        place, name = str(carrying.site.address), carrying.journal.record.name
        carrying.findings.append(rules.LEFT_OPEN(place=place, name=name))


def _let_go(carrying: Transfer) -> None:
    """Lets others deploy again; that this fails changes nothing of what is done."""
    site, record = carrying.site, carrying.journal.record
    try:
        site.insist(partial(unclaim, site, record.name), carrying.patience)
    except Refused as refusal:
        reason = refusal.findings[0].message if refusal.findings else "it did not answer"
        there = str(site.address)
        carrying.findings.append(rules.STILL_HELD(place=there, name=record.name, reason=reason))
