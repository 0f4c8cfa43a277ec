"""The scene: a program as its window has it, in the cell of its project, and its routes.

A source is loaded from the text in the editor where that differs from the disk, and shown as the
project states.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.base.source_text import SourceText, read_bytes
from assistant.checks import robot_rules
from assistant.compiler.arms import InCell, open_cell, robot_of
from assistant.compiler.loader import (
    Loaded,
    configured_beside,
    language_of,
    lift_texts,
    parse_pseudo,
    with_entry,
    with_process,
)
from assistant.compiler.program_files import load
from assistant.compiler.retarget import Solved, solve
from assistant.compiler.source_map import Places
from assistant.editing.workspace import source_of
from assistant.program import pseudo
from assistant.program.geometry import IDENTITY, Pose
from assistant.project.source_options import SourceOptions, completed_options
from assistant.sources import PROCESS_SUFFIX, READERS, process_of
from assistant.sources.process.file import parse_process
from assistant.sources.process.placement import (
    DRAWING_SUFFIXES,
    PLACED_BY_OPTIONS,
    DrawingPlacement,
)
from assistant.sources.tables.taught import read_taught
from assistant.studio import rules
from assistant.studio.process_files import common_robot
from assistant.studio.route_answers import Question, asks, finding_records, not_asked, view_page
from assistant.studio.stages import TAUGHT_SUFFIX, Stage, handles_of, stages_of
from assistant.studio.studio import Studio, file_stamps
from assistant.studio.texts import open_text, read_text
from assistant.view.page import page_record
from assistant.view.sheets import Sheet, shown_sheet

if TYPE_CHECKING:
    from assistant.report.contour_plot import DrawnLine
    from assistant.robots import Robot
    from assistant.studio.stages import Handle


_STATED_OPTIONS: Final = (
    "robot",
    "process",
    "unit",
    "cell",
    "from_language",
    "from_robot",
    "entry",
)
"""Options that a project states for showing a source."""


def _make_stage(studio: Studio, window: str, path: str) -> Stage:
    """Return the stage of a program, a table, a drawing or its process file; raise Refused.

    Unsaved text counts as it is in the window.
    """
    source = _drawing_of_process(studio, path)
    process = _process_of_drawing(studio, source)
    edited = process or source
    text = open_text(studio, window, edited)
    name = hashlib.sha256(f"{source}\0{text}\0{file_stamps(studio.folder)}".encode()).hexdigest()[
        :24
    ]
    known = stages_of(studio).known(name)
    if known is not None:
        return known
    stage = _load_and_place(studio, source, process, text, name)
    stage.handles = handles_of(studio, stage)
    stages_of(studio).keep(stage)
    return stage


def _drawing_of_process(studio: Studio, path: str) -> str:
    """The drawing of a process file; itself for anything else."""
    if not path.lower().endswith(PROCESS_SUFFIX):
        return path
    stem = path[: -len(PROCESS_SUFFIX)]
    for suffix in DRAWING_SUFFIXES:
        if studio.place(f"{stem}{suffix}").is_file():
            return f"{stem}{suffix}"
    raise Refused(rules.NOT_SHOWN(path=path, name=path), exit_status=2)


def _process_of_drawing(studio: Studio, source: str) -> str:
    """Return the process file that places a drawing, empty without one."""
    if FilePath(source).suffix.lower() not in DRAWING_SUFFIXES:
        return ""
    stated = completed_options(source, SourceOptions(), ("process",)).process
    file = studio.file(source).with_suffix(PROCESS_SUFFIX) if stated is None else stated.absolute()
    return studio.named(file) if file.is_file() else ""


def _load_and_place(studio: Studio, source: str, process: str, text: str, name: str) -> Stage:
    given = completed_options(source, SourceOptions(), _STATED_OPTIONS)
    stands = open_cell(given.cell, given.robot or common_robot(studio))
    try:
        loaded = _load_text_of(studio, source, process, text, given, stands)
    except Refused as refused:
        if not process:
            raise
        return _unplaced_stage(studio, source, process, text, name, refused)
    found: list[Diagnostic] = []
    solved: Solved | None = None
    try:
        solved = solve(loaded, stands, source, given.from_robot)
        found += solved.findings
    except Refused as refused:
        found += refused.findings
    if solved is not None and not has_errors(found):
        found += robot_rules.check(solved.solution)
    sheet = Sheet(
        FilePath(source).name,
        found,
        loaded.program if solved is None else solved.solution.program,
        Places(loaded.program, loaded.text),
        stands.robot if solved is None else solved.solution.robot,
        stands.scene if solved is None else solved.scene,
        _drawing_lines(source, given, process, text),
        solution=None if solved is None else solved.solution,
        plan=False,
    )
    shown = shown_sheet(sheet)
    placed = _drawing_placement(process, text) if process else None
    return Stage(name, source, process, text, shown, solved, loaded, placed, page_record(shown))


def _unplaced_stage(
    studio: Studio, source: str, process: str, text: str, name: str, refused: Refused
) -> Stage:
    """Return the stage of a drawing whose process file is not complete: its lines, and no arm.

    Raises the refusal for a drawing that cannot be read either.
    """
    from assistant.studio.process_files import unplaced_lines

    try:
        lines = unplaced_lines(studio.file(source))
    except Refused:
        raise refused from None
    if not lines:
        raise refused
    shown = shown_sheet(Sheet(FilePath(source).name, refused.findings, drawn=lines, plan=False))
    return Stage(name, source, process, text, shown, None, None, None, page_record(shown))


def _drawing_placement(process: str, text: str) -> tuple[Pose, Pose] | None:
    """The frame of a drawing, and its place there; None where something else carries that."""
    stated = parse_process(source_of(text, process))
    frame = stated.standing_frame()
    return None if frame is None else (frame, stated.placement or IDENTITY)


def _load_text_of(
    studio: Studio, source: str, process: str, text: str, given: SourceOptions, stands: InCell
) -> Loaded:
    """Load a source as `load` does, with the text in place of its file."""
    file = studio.file(source)
    suffix = file.suffix.lower()
    saved = text == read_text(read_bytes(studio.file(process or source)), source).text
    if saved or (suffix in READERS and suffix != TAUGHT_SUFFIX):
        loaded = load(
            source,
            process=given.process,
            robot=robot_of(given.from_robot) or stands.robot,
            language=given.from_language,
            unit=given.unit,
            around=stands.around,
            placement=None if saved else _typed_placement(process, text),
        )
        found = tuple(one for one in loaded.findings if one.code != PLACED_BY_OPTIONS.code)
        loaded = replace(loaded, findings=found)
    else:
        loaded = _unsaved_text(file, source_of(text, source), given, stands.robot)
    return replace(loaded, program=with_entry(loaded.program, given.entry))


def _unsaved_text(
    file: FilePath, text: SourceText, given: SourceOptions, reader: Robot | None
) -> Loaded:
    """Load text that is in an editor and not on the disk."""
    suffix = file.suffix.lower()
    if suffix == TAUGHT_SUFFIX:
        reading = read_taught(text, file.stem, process_of(file, given.process))
        return Loaded(reading.program, None, reading.findings, joint_percent=reading.joint_percent)
    if suffix == pseudo.SUFFIX:
        loaded = Loaded(parse_pseudo(text, file.parent), text=text)
    else:
        named = given.from_language
        language = languages.of_file(file, text.text.encode()) if named is None else None
        language = language_of(named) if named else language
        if language is None:
            raise Refused(rules.NOT_SHOWN(path=text.path, name=text.path), exit_status=2)
        loaded = lift_texts(language, [text], reader, beside=file.parent)
        loaded = configured_beside(loaded, language, file)
    return loaded if given.process is None else with_process(loaded, given.process)


def _typed_placement(process: str, text: str) -> DrawingPlacement | None:
    """Return the placement of a drawing in the text of a process file; None if it has no
    placement.
    """
    if not process:
        return None
    stated = parse_process(source_of(text, process))
    return None if stated.placement is None else DrawingPlacement(stated.placement)


def _drawing_lines(
    source: str, given: SourceOptions, process: str, text: str
) -> Sequence[DrawnLine]:
    """The lines of a drawing; none of another source, nor of one that cannot be read."""
    from assistant.report.contour_plot import drawn_lines

    try:
        return drawn_lines(source, given.process, given.unit, _typed_placement(process, text))
    except Refused:
        return ()


def _show_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """Prepare the scene of a file as it is in the window; its page is requested by name."""
    stage = _make_stage(studio, asked.window, asked.text("path"))
    return {
        "name": stage.name,
        "path": stage.path,
        "edits": stage.process or stage.path,
        "handles": [one.record() for one in stage.handles],
        "findings": finding_records(_shown_stage(stage)),
        "moves": stage.shown.simulation is not None,
        "alone": stage.loaded is None,
    }


def _drag_in_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the effect of moving an object; nothing is changed."""
    from assistant.studio.scene_edits import drag_record as told

    stage, handle = _held_handle(studio, asked)
    return told(stage, handle, handle.held_at(_asked_position(asked)))


def _edit_in_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """The edit that puts something elsewhere; the editor makes it, and can take it back."""
    from assistant.studio import scene_edits

    stage, handle = _held_handle(studio, asked)
    path, change = scene_edits.move_edit(
        studio, asked.window, stage, handle, handle.held_at(_asked_position(asked))
    )
    start, end = change.range.start, change.range.end
    one = {"from": [start.line, start.column], "to": [end.line, end.column], "text": change.text}
    return {"path": path, "edits": [one], "line": start.line + 1}


async def _scene_page(request: Request) -> Response:
    """The page of a scene that was worked out."""
    from assistant.studio.stages import stages_of

    studio: Studio = request.app.state.studio
    try:
        stage = stages_of(studio).get(request.path_params["name"])
    except Refused:
        return await view_page(request, None)
    return await view_page(request, partial(_scene_record, stage))


def _scene_record(stage: Stage) -> dict[str, Any]:
    return stage.record | {"handles": [one.record() for one in stage.handles]}


def _shown_stage(stage: Stage) -> list[Diagnostic]:
    placed = stage.shown.places.finding
    return [placed(one).within(stage.path) for one, _ in stage.shown.findings]


def _held_handle(studio: Studio, asked: Question) -> tuple[Stage, Handle]:
    from assistant.studio.stages import stages_of

    stage = stages_of(studio).get(asked.text("name"))
    at = asked.number("handle")
    if at != int(at) or not 0 <= at < len(stage.handles):
        raise not_asked("`handle` is no number of one")
    return stage, stage.handles[int(at)]


def _asked_position(asked: Question) -> tuple[float, float, float]:
    place = asked.values.get("position")
    if not isinstance(place, list) or len(place) != 3:
        raise not_asked("`position` is no place")
    x, y, z = (Question({"it": value}).number("it") for value in place)
    return x, y, z


SCENE_ROUTES: Final = (
    asks("/scene/show", _show_scene),
    asks("/scene/moved", _drag_in_scene),
    asks("/scene/edit", _edit_in_scene),
    Route("/scene/{name}/page", _scene_page),
)
