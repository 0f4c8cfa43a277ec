"""Planning: local programs compared with what is on the controller; nothing is changed."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path as FilePath

from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import read_bytes
from assistant.controllers import Programs
from assistant.controllers.states import Identity
from assistant.deploy import rules
from assistant.deploy.clashing import check_clashes
from assistant.deploy.files import controller_names, file_findings
from assistant.deploy.identifying import check_meant, of_another
from assistant.deploy.judging import EVERY, Classifier
from assistant.deploy.planned import Change, Plan, PlannedFile
from assistant.deploy.remembering import last_record
from assistant.deploy.site import Site, of_deployments

__all__ = ["EVERY", "Change", "Plan", "PlannedFile", "plan"]


def plan(
    files: Sequence[str | FilePath],
    controller: Programs,
    *,
    task: str = "",
    load: bool = False,
    replace: Collection[str] = (),
    history: str | FilePath | None = None,
    meant: Identity | None = None,
) -> Plan:
    """Compares local programs with what is on the controller; changes nothing.

    Every file is parsed first: a program with errors is never sent. task: that modules are loaded
    in, "" for the first. load: whether modules that are not loaded yet are to be. replace: names
    of programs that may be replaced although no deployment left them there as they are, `EVERY`
    for all. history: see `journal.place_of`. meant: robot and serial number that the controller has
    to have, as far as they are stated; another one is refused. Raises Refused (Unreadable for files
    that cannot be read) with everything that keeps the files from being deployed.
    """
    if not files:
        raise Refused(rules.NO_FILES())
    data = {str(file): read_bytes(file) for file in files}
    ordered = sorted(data, key=lambda path: path.lower().endswith(controller.lists))
    names = controller_names(ordered, controller)
    site = Site(controller, task)
    with site:
        identity = site.identity()
        untold = check_meant(identity, meant, str(controller.address)) if meant else ()
        # Only a session knows which version of a language the controller takes.
        notes = file_findings({path: data[path] for path in ordered}, names, controller)
        errors = [finding for found in notes.values() if has_errors(found) for finding in found]
        if errors:
            raise Refused(*errors)
        there = [name for name in controller.names() if not of_deployments(name)]
        record, told = last_record(site, history)
        stranger = of_another(identity, record)
        if stranger is not None:
            record, told = None, (*told, stranger)
        look = Classifier(site, record, load, replace, history)
        planned = tuple(look.at(path, names[path], data[path], notes[path]) for path in ordered)
        told = (*told, *check_clashes(site, [file.entry for file in planned]))
    ours = {name.lower() for name in (record.programs if record else ())}
    planned_names = {name.lower() for name in names.values()}
    return Plan(
        controller.address,
        planned,
        site,
        identity,
        record,
        tuple(name for name in there if name.lower() not in ours | planned_names),
        tuple(name for name in there if name.lower() in ours - planned_names),
        (*untold, *told, *look.notes),
    )
