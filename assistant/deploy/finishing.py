"""Deployments that were interrupted, finished or taken back; and those of the past, taken back."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace as changed
from pathlib import Path as FilePath

from assistant.controllers import Programs
from assistant.deploy import rules
from assistant.deploy.carrying import PATIENCE, Carrying
from assistant.deploy.claiming import alone_here, claim, claimant
from assistant.deploy.deployment import carry_out, settle, take_back
from assistant.deploy.held import Digests, Held
from assistant.deploy.identifying import check_same
from assistant.deploy.journal import Entry, Journal, Step, journals, place_of, unpack
from assistant.deploy.outcome import Deployment, FileState
from assistant.deploy.plan import EVERY
from assistant.deploy.record import new_record
from assistant.deploy.remembering import last_record
from assistant.deploy.resting import check_at_rest
from assistant.deploy.site import UNDER_WAY, Site
from assistant.program.diagnostics import Diagnostic, Refused


def resume(
    controller: Programs,
    *,
    history: str | FilePath | None = None,
    replace: Collection[str] = (),
    patience: float = PATIENCE,
) -> Deployment:
    """Finishes the deployment that was interrupted, here or on another computer.

    replace: programs that are made what the deployment brought although somebody has changed them
    meanwhile, `EVERY` for all. Raises Refused if there is none.
    """
    return _finish(controller, history, replace, patience, back=False)


def rollback(
    controller: Programs,
    number: int | None = None,
    *,
    history: str | FilePath | None = None,
    replace: Collection[str] = (),
    patience: float = PATIENCE,
) -> Deployment:
    """Takes back a deployment: every program of it is again what it was before, byte for byte.

    number: of it in the history; those after it are taken back as well. None for the one that was
    interrupted, or else the last. To take back one that is done is a deployment too, which can be
    resumed and taken back. replace: see `resume`. Raises Refused if there is none.
    """
    place = place_of(controller.address, history)
    with alone_here(place):
        with Site(controller) as site:
            open_one = _open(site, place)
        past = [one for one in journals(place) if one.last is Step.DONE]
    if open_one is not None and number in (None, open_one.number):
        return _finish(controller, history, replace, patience, back=True)
    if open_one is not None:
        raise Refused(rules.STILL_OPEN(place=str(open_one.folder), name=open_one.record.name))
    chosen = [one for one in past if number is None or one.number >= number]
    if number is None:
        chosen = chosen[-1:]
    if not chosen or (number is not None and chosen[0].number != number):
        finding = rules.NO_DEPLOYMENT(place=str(controller.address), number=number or "")
        raise Refused(finding, exit_status=2)
    return _undo(controller, chosen, place, history, replace, patience)


def _finish(
    controller: Programs,
    history: str | FilePath | None,
    replace: Collection[str],
    patience: float,
    *,
    back: bool,
) -> Deployment:
    place = place_of(controller.address, history)
    findings: list[Diagnostic] = []
    with alone_here(place), Site(controller) as site:
        journal = _open(site, place)
        if journal is None:
            raise Refused(rules.NOTHING_OPEN(place=str(controller.address)))
        site.task = journal.record.task
        carrying = _checked(site, journal, replace, patience)
        claim(site, journal.record)
        if back:
            # All of them: a step that was on its way when the line was cut may have been done.
            carrying.states = dict.fromkeys((e.name for e in journal.entries), FileState.UNKNOWN)
            take_back(carrying, connected=True)
        else:
            _go_on(carrying, findings)
    findings += carrying.findings
    return Deployment(controller.address, carrying.states, tuple(findings), journal.folder, back)


def _go_on(carrying: Carrying, findings: list[Diagnostic]) -> None:
    """Installs what is left; what fails leaves the deployment open, to be resumed again."""
    journal = carrying.journal
    carrying.states = dict.fromkeys((e.name for e in journal.entries), FileState.UNKNOWN)
    try:
        carrying.forward(journal.entries)
        settle(carrying.site, journal)
    except Refused as refusal:
        findings += refusal.findings
    except KeyboardInterrupt:
        name = journal.record.name
        findings.append(rules.INTERRUPTED(place=name, name=name))


def _open(site: Site, place: FilePath) -> Journal | None:
    """The deployment that is neither finished nor taken back, in the history or on the disk."""
    here = next((one for one in journals(place) if one.open), None)
    if here is not None or site.disk is None:
        return here
    name, _, _ = claimant(site)
    data = site.controller.read(UNDER_WAY) if name else None
    if data is None:
        return None
    journal = unpack(data, place)
    if journal.record.name == name:
        journal.add(Step.BEGUN)
        return journal
    # Its author died before a program was touched: what is on the disk is of the one before.
    for file in sorted(journal.folder.rglob("*"), reverse=True):
        file.rmdir() if file.is_dir() else file.unlink()
    journal.folder.rmdir()
    return None


def _checked(site: Site, journal: Journal, replace: Collection[str], patience: float) -> Carrying:
    """Raises Refused if it is another controller, or somebody has changed programs meanwhile."""
    check_same(site.identity(), journal.record, str(site.address))
    check_at_rest(site, journal.entries)
    carrying = Carrying(site, journal, patience)
    allowed = {name.lower() for name in replace}
    asked = (
        [] if EVERY in allowed else [e for e in journal.entries if e.name.lower() not in allowed]
    )
    unknown = carrying.unknown(asked)
    if unknown:
        raise Refused(*unknown)
    return carrying


def _undo(
    controller: Programs,
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
            wanted.setdefault(entry.name, entry.before)
            left[entry.name] = entry.after
    with alone_here(place), Site(controller, past[-1].record.task) as site:
        identity = site.identity()
        for journal in past:
            check_same(identity, journal.record, str(controller.address))
        before, _ = last_record(site, history)
        allowed = {name.lower() for name in replace}
        now = {name: site.held(name, held.file or left[name].file) for name, held in wanted.items()}
        changes = [
            rules.CHANGED_BETWEEN(place=name, name=name)
            for name, held in now.items()
            if not any(site.same(held, one) for one in (left[name], wanted[name]))
            and not {name.lower(), EVERY} & allowed
        ]
        if changes:
            raise Refused(*changes)
        begun = new_record(str(controller.address), identity, site.task)
        programs: dict[str, Digests] = dict(before.programs) if before else {}
        for name, held in wanted.items():
            programs.pop(name, None)
            if held.file is not None:
                programs[name] = site.digests(held)
        entries = [Entry(name, now[name], held) for name, held in wanted.items()]
        check_at_rest(site, entries)
        record = changed(begun, programs=programs)
        done = carry_out(site, place, record, entries, patience)
    findings = tuple(done.findings)
    return Deployment(controller.address, done.states, findings, done.journal.folder)
