"""What a project writes stays in its folder, also where its repository brought links along."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath

from assistant.base.diagnostics import Refused
from assistant.project import rules


def refuse_links(folder: FilePath, written: Sequence[FilePath]) -> None:
    """Raises Refused (exit status 2) if a link stands in one of these, from the folder.

    Only commands write there: a link was put there by somebody else, and leads anywhere.
    """
    for one in written:
        link = next(_links_below(folder / one), None)
        if link is not None:
            file = link.relative_to(folder).as_posix()
            raise Refused(rules.LINK(path=str(folder), file=file), exit_status=2)


def _links_below(folder: FilePath) -> Iterator[FilePath]:
    if folder.is_symlink():
        yield folder
        return
    for place, folders, files in os.walk(folder):
        paths = (FilePath(place, name) for name in (*folders, *files))
        yield from (path for path in paths if path.is_symlink())
