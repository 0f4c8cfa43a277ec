"""What is known of earlier deployments to a controller, there and here."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path as FilePath

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_file
from assistant.deploy.archive import archived_programs
from assistant.deploy.held import Held
from assistant.deploy.journal import RECORD_FILE as KEPT
from assistant.deploy.journal import (
    Entry,
    Step,
    journal_folders,
    last_step,
    place_of,
    read_journal,
    report_file_errors,
)
from assistant.deploy.record import Record, read_record
from assistant.deploy.site import RECORD, UNDER_WAY, Site


def last_record(
    site: Site, history: str | FilePath | None = None
) -> tuple[Record | None, tuple[Diagnostic, ...]]:
    """The record of the last deployment, with findings of one that cannot be trusted.

    That on the controller counts, if it has a disk: others deploy as well. Else the last of the
    history here.
    """
    if site.disk is not None:
        data = site.controller.read(RECORD)
        if data is None:
            return None, ()
        try:
            return read_record(data, RECORD), ()
        except Refused as refused:
            return None, refused.findings
    for folder in reversed(journal_folders(place_of(site.address, history))):
        if last_step(folder) is Step.DONE:
            with report_file_errors(folder):
                return read_record(read_file(folder / KEPT), str(folder / KEPT)), ()
    return None, ()


def what_was_left(
    site: Site, record: Record, name: str, history: str | FilePath | None = None
) -> Held | None:
    """What the deployments up to a record left of a program, None if nobody kept it.

    It is looked for in the history here, and in the archive that the last deployment left on a
    disk; what it holds is what the record says by its digests.
    """
    meant = {n.lower(): digests for n, digests in record.programs.items()}.get(name.lower())
    for entry in _earlier_programs(site, history):
        if entry.name.lower() != name.lower() or meant is None:
            continue
        for held in (entry.after, entry.before):
            if site.digests(held, meant.task) == meant:
                return held
    return None


def _earlier_programs(site: Site, history: str | FilePath | None) -> Iterator[Entry]:
    """Programs of earlier deployments, the newest first."""
    for folder in reversed(journal_folders(place_of(site.address, history))):
        with suppress(Refused):  # nor does one that is damaged
            yield from read_journal(folder).entries
    data = site.controller.read(UNDER_WAY) if site.disk is not None else None
    if data is not None:
        with suppress(Refused):  # an archive that is cut or changed tells nothing
            yield from archived_programs(data)
