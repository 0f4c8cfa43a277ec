"""`scene`: what stands in a cell by its file or drawing, as a table, a cell file or glTF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused, error, fold
from assistant.cli.compiling import keep_sources, working
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.cell.scene import Scene

NO_SCENE = error(
    "CL045",
    "a scene is not written as `{name}`",
    "end the name in .toml for a cell file, or in .glb for glTF",
)
SCENE_SUFFIXES, GLTF_SUFFIX = ".toml", ".glb"
WORLD_TABLES: Final = ("world", "robots", "bodies", "frames")
"""Tables of a cell file that a scene holds."""


def run_scene(cell: Path, unit: str | None, output: Path | None, format: Format) -> int:
    """0; unit: of a drawing, whatever that says."""
    from assistant.report import scenes as report

    if output is not None and (
        output.suffix.lower() not in (SCENE_SUFFIXES, GLTF_SUFFIX) or not output.stem
    ):
        raise Refused(NO_SCENE(name=output), exit_status=2)
    as_text = output is not None and output.suffix.lower() == SCENE_SUFFIXES
    with working(f"reading {cell}"):
        try:
            scene, found, others = _read_scene(cell, unit, as_text)
            told = report.record(scene)  # refuses what stands in nothing
        except Refused as refused:
            at = (finding.within(str(cell)) for finding in refused.findings)
            raise Refused(*at, exit_status=refused.exit_status) from None
        files = {} if output is None else _scene_files(scene, output)
        if as_text:
            found += _left_out_tables(others)
        written = _write_scene(cell, files)
    findings = [finding.within(str(cell)) for finding in found]
    if format is Format.JSON:
        from assistant.findings.formats import finding_record

        answer = {"cell": str(cell), **told}
        answer["findings"] = [finding_record(finding) for finding in findings]
        print_json(answer | {"written": [str(path) for path in written]})
        return 0
    print_findings(fold(findings), explained=True)
    for line in report.lines(scene) if output is None else ():
        say(line)
    for path in written:
        say(f"wrote {path}")
    return 0


def _read_scene(
    cell: Path, unit: str | None, as_text: bool
) -> tuple[Scene, tuple[Diagnostic, ...], tuple[str, ...]]:
    """The scene of a cell file or of a drawing, what is said of it, and its other tables.

    as_text: without what charts of explored space add, which the text names.
    """
    from assistant.base.budgets import SETTINGS_FILE
    from assistant.base.length_units import known_unit, unit_stated
    from assistant.base.source_text import decode, read_bytes
    from assistant.cell.cell_file import parse_scene
    from assistant.cell.drawing_bodies import read_drawing
    from assistant.cell.scene import Scene
    from assistant.sources.process.file import ENCODINGS, read_toml
    from assistant.sources.process.placement import DRAWING_SUFFIXES

    if unit is not None:
        known_unit(unit)
    if cell.suffix.lower() in DRAWING_SUFFIXES:
        drawn = read_drawing(cell, unit)
        return Scene(drawn.bodies), drawn.findings, ()
    source = decode(read_bytes(cell, most=SETTINGS_FILE), str(cell), ENCODINGS)
    found: tuple[Diagnostic, ...] = () if unit is None else (unit_stated(str(cell), unit),)
    scene, said = parse_scene(source, cell.parent, explored=not as_text)
    others = tuple(key for key in read_toml(source).content if key not in WORLD_TABLES)
    return scene, (*found, *said), others


def _scene_files(scene: Scene, output: Path) -> dict[Path, bytes]:
    from assistant.cell.scene_export import cell_files, gltf

    if output.suffix.lower() == GLTF_SUFFIX:
        return {output: gltf(scene)}
    files = cell_files(scene, output.stem, output.parent)
    text = files.pop(f"{output.stem}.toml")
    return {output: text, **{output.parent / name: data for name, data in files.items()}}


def _left_out_tables(others: tuple[str, ...]) -> tuple[Diagnostic, ...]:
    from assistant.cell.findings import TABLE_LEFT_OUT
    from assistant.program.settings_tables import shown

    return tuple(TABLE_LEFT_OUT(table=shown(name)) for name in others)


def _write_scene(cell: Path, files: dict[Path, bytes]) -> tuple[Path, ...]:
    from assistant.base.file_sets import write_all

    keep_sources([str(cell)], list(files))
    return write_all(files) if files else ()
