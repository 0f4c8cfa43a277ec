"""Drawings (DXF): locations from points and blocks, contours from lines and curves."""

from __future__ import annotations

from pathlib import Path as FilePath

from assistant.base.budgets import without_gc
from assistant.base.diagnostics import Refused, has_errors
from assistant.sources.drawing.contents import Contents, read_contents
from assistant.sources.drawing.program import drawing_program
from assistant.sources.process import Process
from assistant.sources.reading import Reading

__all__ = ["Contents", "read", "read_contents"]


@without_gc()
def read(path: FilePath, process: Process) -> Reading:
    """The pseudo-program of a drawing.

    Raises Unreadable for what is no drawing, Refused if an entity says something wrong or
    nothing in it can become motion.
    """
    contents = read_contents(path, process)
    if has_errors(contents.findings):
        raise Refused(*contents.findings)
    return drawing_program(contents, path, process)
