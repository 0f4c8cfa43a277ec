"""Carrying out a plan: all programs are on the controller and verified, or none is changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.termination import Termination, raise_on_termination
from assistant.controllers.rules import Lost
from assistant.deploy import rules
from assistant.deploy.archive import pack_journal
from assistant.deploy.carrying import PUT_BACK_TIMEOUT, Progress, Tell, Transfer
from assistant.deploy.claiming import check_claim, claim, holder, lock_on_this_computer, unclaim
from assistant.deploy.held import Digests
from assistant.deploy.identifying import of_another
from assistant.deploy.journal import Entry, Journal, Step, create_journal, open_journal, place_of
from assistant.deploy.outcome import Deployment, FileState
from assistant.deploy.plan import Change, Plan
from assistant.deploy.record import Record, new_record
from assistant.deploy.remembering import last_record
from assistant.deploy.resting import check_not_running, pointers_lost, tasks
from assistant.deploy.site import RECORD, UNDER_WAY, Site


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
    """Brings the plan's changes to its controller, reads each back, and compares.

    What was there is kept in the history first, see `journal`. If any program fails, every one
    that was changed is put back (after Ctrl-C as well); the findings say what happened, nothing
    is raised for it. A plan with conflicts, or whose controller has changed meanwhile, changes
    nothing; neither does one that would replace a running program. Never starts motion.
    files_only: whether programs may be replaced whose taught points this session cannot see.
    patience: seconds for which what cannot be put back is tried again. tell: called with what a
    user has to know at once, as of a line that is lost. leave: asked while a lost line is tried
    again; True leaves the deployment open.
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
        """Raises Refused if somebody has to decide first."""
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
    """Brings programs to a controller, with a journal; what fails is put back.

    So is what is interrupted, from outside or by Ctrl-C: only once, what comes after that waits,
    unless the line is lost: then it leaves the deployment open, and so does `leave`. check: is
    asked once nobody else can deploy to it. The findings of what comes back say what failed. Raises
    Refused if nothing could be begun.
    """
    stood = tasks(site)
    with raise_on_termination(once=True) as ending:
        site.waiting = partial(_waiting, ending, leave or (lambda: False))
        journal = _begun(site, place, record, entries, check, patience, ending)
        carrying = Transfer(site, journal, patience)
        try:
            try:
                carrying.forward(journal.entries, progress)
                settle(carrying)
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
        claim(site, record, patience)
        check()
        earlier = site.controller.read(RECORD) if site.disk is not None else None
        journal = create_journal(place, record, entries, earlier)
        if site.disk is not None:
            site.controller.write(UNDER_WAY, pack_journal(journal))
        check_claim(site, record)
    except BaseException as caught:
        ending.hold()
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
