"""The scene: the page of `view` inside the studio, what a drag is told, and the edit of a drop."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.studio.answering import Asked, asks, findings, not_asked, view_page
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.studio.stages import Handle, Stage


def show(studio: Studio, asked: Asked) -> dict[str, Any]:
    """Works a file out for the scene as it stands in the window; its page is asked for by name."""
    from assistant.studio.scenes import stage_of

    stage = stage_of(studio, asked.window, asked.text("path"))
    return {
        "name": stage.name,
        "path": stage.path,
        "edits": stage.process or stage.path,
        "handles": [one.record() for one in stage.handles],
        "findings": findings(_found(stage)),
        "moves": stage.shown.simulation is not None,
    }


def moved(studio: Studio, asked: Asked) -> dict[str, Any]:
    """What would be if something stood elsewhere; nothing is changed."""
    from assistant.studio.dragging import moved as told

    stage, handle = _held(studio, asked)
    return told(stage, handle, handle.held_at(_place(asked)))


def edit(studio: Studio, asked: Asked) -> dict[str, Any]:
    """The edit that puts something elsewhere; the editor makes it, and can take it back."""
    from assistant.studio import moving

    stage, handle = _held(studio, asked)
    path, change = moving.edit(studio, asked.window, stage, handle, handle.held_at(_place(asked)))
    start, end = change.range.start, change.range.end
    one = {"from": [start.line, start.column], "to": [end.line, end.column], "text": change.text}
    return {"path": path, "edits": [one], "line": start.line + 1}


async def page(request: Request) -> Response:
    """The page of a scene that was worked out."""
    from assistant.studio.stages import stages

    studio: Studio = request.app.state.studio
    try:
        stage = stages(studio).get(request.path_params["name"])
    except Refused:
        return await view_page(request, None)
    return await view_page(request, partial(_record, stage))


def _record(stage: Stage) -> dict[str, Any]:
    return stage.record | {"handles": [one.record() for one in stage.handles]}


def _found(stage: Stage) -> list[Diagnostic]:
    placed = stage.shown.places.finding
    return [placed(one).within(stage.path) for one, _ in stage.shown.findings]


def _held(studio: Studio, asked: Asked) -> tuple[Stage, Handle]:
    from assistant.studio.stages import stages

    stage = stages(studio).get(asked.text("name"))
    at = asked.number("handle")
    if at != int(at) or not 0 <= at < len(stage.handles):
        raise not_asked("`handle` is no number of one")
    return stage, stage.handles[int(at)]


def _place(asked: Asked) -> tuple[float, float, float]:
    place = asked.values.get("position")
    if not isinstance(place, list) or len(place) != 3:
        raise not_asked("`position` is no place")
    x, y, z = (Asked({"it": value}).number("it") for value in place)
    return x, y, z


ROUTES: Final = (
    asks("/scene/show", show),
    asks("/scene/moved", moved),
    asks("/scene/edit", edit),
    Route("/scene/{name}/page", page),
)
