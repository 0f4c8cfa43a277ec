"""The scene: the page of `view` inside the studio, what a drag is told, and the edit of a drop."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.studio.answering import Question, asks, finding_records, not_asked, view_page
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.studio.stages import Handle, Stage


def show_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """Works a file out for the scene as it stands in the window; its page is asked for by name."""
    from assistant.studio.scenes import make_stage

    stage = make_stage(studio, asked.window, asked.text("path"))
    return {
        "name": stage.name,
        "path": stage.path,
        "edits": stage.process or stage.path,
        "handles": [one.record() for one in stage.handles],
        "findings": finding_records(_shown_stage(stage)),
        "moves": stage.shown.simulation is not None,
    }


def drag_in_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """What would be if something stood elsewhere; nothing is changed."""
    from assistant.studio.dragging import drag_record as told

    stage, handle = _held_handle(studio, asked)
    return told(stage, handle, handle.held_at(_asked_position(asked)))


def edit_in_scene(studio: Studio, asked: Question) -> dict[str, Any]:
    """The edit that puts something elsewhere; the editor makes it, and can take it back."""
    from assistant.studio import moving

    stage, handle = _held_handle(studio, asked)
    path, change = moving.move_edit(
        studio, asked.window, stage, handle, handle.held_at(_asked_position(asked))
    )
    start, end = change.range.start, change.range.end
    one = {"from": [start.line, start.column], "to": [end.line, end.column], "text": change.text}
    return {"path": path, "edits": [one], "line": start.line + 1}


async def scene_page(request: Request) -> Response:
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
    asks("/scene/show", show_scene),
    asks("/scene/moved", drag_in_scene),
    asks("/scene/edit", edit_in_scene),
    Route("/scene/{name}/page", scene_page),
)
