"""Sources of programs: taught targets, waypoint tables, drawings; one reader a file kind."""

from __future__ import annotations

import contextlib
import importlib
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, cast

from assistant.base.budgets import TABLE, most_unpacked, within
from assistant.base.diagnostics import Unreadable, error
from assistant.base.length_units import known_unit, unit_stated
from assistant.base.source_text import is_file
from assistant.sources.reading import Reader, Reading
from assistant.sources.seen_settings import NO_SEEN_SETTINGS

if TYPE_CHECKING:
    from assistant.sources.process import Process, ProgramStyle, SurroundingsByRobot
    from assistant.sources.process.placement import DrawingPlacement

__all__ = ["READERS", "Reading", "process_of", "read"]

READERS: Final = {
    ".dxf": "assistant.sources.drawing",
    ".csv": "assistant.sources.tables.csv_tables",
    ".toml": "assistant.sources.tables.taught",
    ".npy": "assistant.sources.tables.waypoints",
    ".npz": "assistant.sources.tables.waypoints",
    ".json": "assistant.sources.tables.waypoints",
}
"""File suffix → module, whose `read(path, process)` gives the `Reading`."""

STATE_LENGTHS: Final = (".csv", ".toml")
"""Sources whose form leaves no unit open."""

PROCESS_SUFFIX: Final = ".process.toml"
"""A file of the source's name with this suffix, beside it, is its process file."""

UNKNOWN_KIND = error(
    "SR001",
    "`{name}` is of no kind that can be read",
    "give one of {kinds}, or a robot program, whose language --from names",
)


def read(
    path: str | FilePath,
    process: str | FilePath | None = None,
    unit: str | None = None,
    around: SurroundingsByRobot | None = None,
    placement: DrawingPlacement | None = None,
    *,
    merging: bool = False,
    style: ProgramStyle | None = None,
) -> Reading:
    """The pseudo-program of a drawing, table or list of targets.

    process: a process file; without one, the file beside the source that is named like it.
    unit: the short name of the unit that a drawing is in, instead of what the process file says.
    around: what stands around the work, by the robot that the process file names, if it names one.
    placement: of a drawing, instead of what the process file says. merging: rows of tables and
    waypoints that repeat the one before them are left out, with a note. style: of the program,
    where the process file states none.
    Raises Unreadable or Refused.
    """
    from assistant.program.analysis.uses import without_unused_equipment
    from assistant.sources.process.placement import PLACED_BY_OPTIONS, check_drawn

    source = FilePath(path)
    module = READERS.get(source.suffix.lower())
    if module is None:
        raise Unreadable(UNKNOWN_KIND(path=str(path), name=source.name, kinds=" ".join(READERS)))
    reader = cast(Reader, importlib.import_module(module).read)
    chosen = process_of(source, process)
    findings = chosen.findings
    if unit is not None:
        chosen = replace(chosen, unit=known_unit(unit))
        if source.suffix.lower() in STATE_LENGTHS:
            findings += (unit_stated(path, unit),)
    if placement is not None:
        told = () if chosen.placement is None else (PLACED_BY_OPTIONS(path=str(path)),)
        findings += (*(f.within(str(path)) for f in placement.findings), *told)
        chosen = replace(chosen, placement=placement.pose)
    if style is not None:
        chosen = replace(chosen, style=chosen.style.completed(style))
    if merging:
        chosen = replace(chosen, merges=True)
    if chosen.placement is not None:
        check_drawn(source)
    if around is not None:
        chosen = replace(chosen, around=around(chosen.robot))
    with _stage(source):
        reading = reader(source, chosen)
    program = without_unused_equipment(reading.program)
    if chosen.interface is not None:
        program = replace(program, interface=chosen.interface)
    seen = chosen.seen if reading.seen == NO_SEEN_SETTINGS else reading.seen
    found = (*findings, *reading.findings)
    percent = reading.joint_percent or chosen.joint_percent
    return Reading(program, found, percent, seen, chosen.style)


def _stage(source: FilePath) -> AbstractContextManager[None]:
    """Return the reading stage of a table; a drawing has separate stages, as it expands to more
    than its bytes.
    """
    if source.suffix.lower() == ".dxf":
        return contextlib.nullcontext()
    return within(TABLE, str(source), _size(source))


def _size(source: FilePath) -> int:
    """Bytes of a file, of an archive what it unpacks to; 0 of what cannot be read anyway."""
    if not is_file(source):
        return 0
    size = source.stat().st_size
    if source.suffix.lower() == ".npz":
        import zipfile

        from assistant.sources.tables.npy_files import BROKEN_ZIP

        with contextlib.suppress(*BROKEN_ZIP), zipfile.ZipFile(source) as archive:
            size = max(size, min(most_unpacked(), sum(one.file_size for one in archive.infolist())))
    return size


def process_of(source: FilePath, process: str | FilePath | None = None) -> Process:
    """The process file of a source, or none; raises Unreadable or Refused."""
    from assistant.sources.process import NO_PROCESS

    beside = source.with_suffix(PROCESS_SUFFIX)
    chosen = FilePath(process) if process else beside if is_file(beside) else None
    if chosen is None:
        return NO_PROCESS
    from assistant.sources.process.file import read_process

    return read_process(chosen)
