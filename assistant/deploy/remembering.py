"""What is known of earlier deployments to a controller, there and here."""

from __future__ import annotations

from pathlib import Path as FilePath

from assistant.deploy.journal import Step, journals, place_of
from assistant.deploy.record import Record, read_record
from assistant.deploy.site import RECORD, Site
from assistant.program.diagnostics import Diagnostic, Refused


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
    past = [one for one in journals(place_of(site.address, history)) if one.last is Step.DONE]
    return (past[-1].record if past else None), ()
