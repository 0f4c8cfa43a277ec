"""Recovery of interrupted deployments, finished or taken back, and rollback of past ones."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import replace as changed
from pathlib import Path as FilePath

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_file
from assistant.base.termination import raise_on_termination
from assistant.controllers import Programs
from assistant.deploy import rules
from assistant.deploy import site as site_names
from assistant.deploy.deployment import (
    PUT_BACK_TIMEOUT,
    Deployment,
    FileState,
    Tell,
    Transfer,
    carry_out,
    settle,
    take_back,
)
from assistant.deploy.history import (
    ENDED,
    RECORD_FILE,
    Entry,
    Journal,
    Step,
    journal_folders,
    last_record,
    last_step,
    open_journal,
    place_of,
    read_journal,
    report_file_errors,
    unpack_journal,
)
from assistant.deploy.lock import claim, held_by, holder, lock_on_this_computer, unclaim
from assistant.deploy.plan import EVERY
from assistant.deploy.preconditions import check_clashes, check_not_running, pointers_lost, tasks
from assistant.deploy.record import Digests, Held, check_same, new_record, read_record
from assistant.deploy.site import UNDER_WAY, Site


def resume(
    controller: Programs,
    *,
    history: str | FilePath | None = None,
    replace: Collection[str] = (),
    patience: float = PUT_BACK_TIMEOUT,
) -> Deployment:
    """Finish the deployment that was interrupted, here or on another computer.

    replace: programs that get the content of the deployment although another user has changed them
    meanwhile, `EVERY` for all. Raises Refused if no deployment was interrupted.
    """
    place = place_of(controller.address, history)
    with lock_on_this_computer(place), Site(controller, patience=patience) as site:
        journal, freed = _open(site, place)
        if journal is not None:
            return _finish(site, journal, replace, patience, back=False)
        if freed is None:
            raise Refused(rules.NOTHING_OPEN(place=str(controller.address)))
        return Deployment(controller.address, {}, (freed.finding,))


def rollback(
    controller: Programs,
    number: int | None = None,
    *,
    history: str | FilePath | None = None,
    replace: Collection[str] = (),
    patience: float = PUT_BACK_TIMEOUT,
    tell: Tell | None = None,
) -> Deployment:
    """Roll a deployment back: every program of it gets its previous content again, byte for byte.

    number: of it in the history; later ones are rolled back as well. None for the one that was
    interrupted, or else the last. The rollback of a finished one is a deployment too, which can be
    resumed and rolled back. replace: see `resume`. tell: see `deploy`. Raises Refused if the
    deployment is missing.
    """
    place = place_of(controller.address, history)
    with lock_on_this_computer(place), Site(controller, patience=patience) as site:
        site.tell = tell or site.tell
        journal, freed = _open(site, place)
        if journal is not None:
            # An open deployment has to be ended before others are taken back.
            if number not in (None, journal.number):
                still = rules.STILL_OPEN(place=str(journal.folder), name=journal.record.name)
                raise Refused(still)
            return _finish(site, journal, replace, patience, back=True)
        # The deployment that held the controller was meant:
        # it is over, and changed nothing or is undone.
        if freed is not None and number is None and freed.how is not Step.DONE:
            return Deployment(controller.address, {}, (freed.finding,), None, back=True)
        done = _undo(site, _chosen(controller, place, number), place, history, replace, patience)
    earlier = (freed.finding,) if freed is not None else ()
    return changed(done, findings=(*earlier, *done.findings))


def _chosen(controller: Programs, place: FilePath, number: int | None) -> list[Journal]:
    """The deployments that are to be taken back, the oldest first; raises Refused for none."""
    done = [folder for folder in journal_folders(place) if last_step(folder) is Step.DONE]
    if number is None:  # some only wrote the record anew
        last = next((one for one in map(read_journal, reversed(done)) if one.entries), None)
        chosen = [] if last is None else [last]
    else:
        chosen = [read_journal(folder) for folder in done if int(folder.name) >= number]
    if not chosen or (number is not None and chosen[0].number != number):
        finding = rules.NO_DEPLOYMENT(place=str(controller.address), number=number or "")
        raise Refused(finding, exit_status=2)
    return chosen


def _finish(
    site: Site, journal: Journal, replace: Collection[str], patience: float, *, back: bool
) -> Deployment:
    site.task = journal.record.task
    carrying = _checked(site, journal, replace, patience)
    claim(site, journal.record, patience)
    carrying.states = dict.fromkeys((e.name for e in journal.entries), FileState.UNKNOWN)
    # All of them, also back: a step that was on its way when the line was cut may have been done.
    with raise_on_termination(once=True):
        try:
            if back:
                take_back(carrying, connected=True)
            else:
                carrying.clear_rests()
                carrying.forward(journal.entries)
                settle(carrying)
        except Refused as refusal:  # it stays open, to be resumed or taken back again
            carrying.findings += refusal.findings
        except KeyboardInterrupt:
            name = journal.record.name
            carrying.findings.append(rules.INTERRUPTED(place=name, name=name))
    if any(map(_loads, journal.entries)):
        with suppress(Refused):  # what became of a lost line is said already
            carrying.findings += pointers_lost(site, tasks(site), was_set=True)
    findings = tuple(carrying.findings)
    return Deployment(site.address, carrying.states, findings, journal.folder, back)


@dataclass(frozen=True, slots=True)
class _Freed:
    """A controller that was held by a deployment that does not need it.

    how: it ended; None if it died before it had changed anything.
    """

    finding: Diagnostic
    how: Step | None = None


def _open(site: Site, place: FilePath) -> tuple[Journal | None, _Freed | None]:
    """The deployment that is neither finished nor taken back, in the history or on the disk.

    Frees the controller if one holds it that has ended, or has changed nothing.
    """
    here = open_journal(place)
    if here is not None:
        # This history may be out of date: others can end
        # the deployment from the controller's archive.
        _check_not_ended_elsewhere(site, here)
        return here, None
    one = held_by(site)
    if one is None:
        return None, None
    steps = map(last_step, _named(place, one.name))
    how = next((step for step in steps if step in ENDED and step is not Step.NOTHING), None)
    if how is None and one.name:
        data = site.controller.read(UNDER_WAY)
        journal = None if data is None else unpack_journal(data, place, one.name)
        if journal is not None:
            journal.add(Step.BEGUN)
            return journal, None
    site.clear_rests({})
    unclaim(site, one.name)
    there = str(site.address)
    if how is None:  # its author died before a program was touched
        return None, _Freed(rules.FREED(place=there, who=one.who))
    words = {Step.DONE: "been finished", Step.TAKEN_BACK: "been taken back"}
    ended = words.get(how, str(how))
    return None, _Freed(rules.FREED_LATE(place=there, name=one.name, how=ended), how)


def _named(place: FilePath, name: str) -> Iterator[FilePath]:
    """The folder of a deployment in the history; those that cannot be read are passed over."""
    for folder in reversed(journal_folders(place)):
        try:
            with report_file_errors(folder):
                record = read_record(read_file(folder / RECORD_FILE), str(folder))
        except Refused:
            continue
        if record.name == name:
            yield folder


def _check_not_ended_elsewhere(site: Site, journal: Journal) -> None:
    """Raises Refused if another computer ended it, and has deployed since: its record is there."""
    record = journal.record
    if site.disk is None or holder(site).name == record.name:
        return
    data = site.controller.read(site_names.RECORD)
    if data in (None, journal.earlier, record.written()):
        return
    try:
        other = read_record(data, site_names.RECORD)
    except Refused:  # damaged: it says nothing
        return
    journal.add(Step.ELSEWHERE)
    place = str(journal.folder)
    raise Refused(rules.NOT_OURS_ANY_MORE(place=place, name=record.name, other=other.name))


def _checked(site: Site, journal: Journal, replace: Collection[str], patience: float) -> Transfer:
    """Return the transfer; raises Refused for another controller or programs changed meanwhile."""
    check_same(site.identity(), journal.record, str(site.address))
    check_not_running(site, journal.entries)
    carrying = Transfer(site, journal, patience)
    allowed = {name.lower() for name in replace}
    asked = (
        [] if EVERY in allowed else [e for e in journal.entries if e.name.lower() not in allowed]
    )
    unknown = carrying.unknown(asked)
    if unknown:
        raise Refused(*unknown)
    return carrying


def _loads(entry: Entry) -> bool:
    return entry.before.loaded is not None or entry.after.loaded is not None


def _undo(
    site: Site,
    past: list[Journal],
    place: FilePath,
    history: str | FilePath | None,
    replace: Collection[str],
    patience: float,
) -> Deployment:
    """Takes back deployments that are done, by one that brings what was before the first."""
    wanted: dict[str, Held] = {}
    left: dict[str, Held] = {}
    for journal in past:
        for entry in journal.entries:
            # The oldest deployment has what was before all of them, the latest what is there now.
            wanted.setdefault(entry.name, entry.before)
            left[entry.name] = entry.after
    memories = {one.record.task for one in past if any(map(_loads, one.entries))}
    if len(memories) > 1:
        raise Refused(rules.SEVERAL_MEMORIES(place=str(site.address), which=", ".join(memories)))
    site.task = next(iter(memories), site.task)
    identity = site.identity()
    for journal in past:
        check_same(identity, journal.record, str(site.address))
    before, _ = last_record(site, history)
    allowed = {name.lower() for name in replace}

    def there() -> dict[str, Held]:
        return {
            name: site.held(name, held.file or left[name].file) for name, held in wanted.items()
        }

    now = there()
    changes = [
        rules.CHANGED_BETWEEN(place=name, name=name)
        for name, held in now.items()
        # As it was left, or already as it is to be: an interrupted rollback is repeated.
        if not any(site.same(held, one) for one in (left[name], wanted[name]))
        and not {name.lower(), EVERY} & allowed
    ]
    if changes:
        raise Refused(*changes)
    begun = new_record(str(site.address), identity, site.task)
    programs: dict[str, Digests] = dict(before.programs) if before else {}
    for name, held in wanted.items():
        programs.pop(name, None)
        if held.file is not None:
            programs[name] = site.digests(held)
    entries = [Entry(name, now[name], held) for name, held in wanted.items()]
    check_not_running(site, entries)
    told = check_clashes(site, entries, sent=False)
    record = changed(begun, programs=programs)

    # Checked again under the claim: programs were read before it was taken.
    def check() -> None:
        since = [name for name, held in there().items() if not site.same(held, now[name])]
        if since:
            raise Refused(*(rules.CHANGED_SINCE(place=name, name=name) for name in since))

    done = carry_out(site, place, record, entries, check, patience)
    findings = (*told, *done.findings)
    back = done.journal.last is Step.DONE
    states = done.states
    if back:  # what a deployment calls installed is what was there before the other one
        states = dict.fromkeys(states, FileState.PUT_BACK)
    return Deployment(site.address, states, findings, done.journal.folder, back)
