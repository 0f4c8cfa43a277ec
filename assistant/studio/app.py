"""The routes of the studio, as one application."""

from __future__ import annotations

from typing import Final

from anyio import CapacityLimiter
from starlette.applications import Starlette
from starlette.routing import BaseRoute

from assistant.studio import (
    control_routes,
    controller_routes,
    page,
    project_routes,
    run_routes,
    scene_routes,
    text_routes,
    window_routes,
)
from assistant.studio.studio import Studio

ROUTES: Final[tuple[BaseRoute, ...]] = (
    *page.PAGE_ROUTES,
    *window_routes.WINDOW_ROUTES,
    *project_routes.PROJECT_ROUTES,
    *run_routes.RUN_ROUTES,
    *controller_routes.CONTROLLER_ROUTES,
    *control_routes.CONTROL_ROUTES,
    *scene_routes.SCENE_ROUTES,
    *text_routes.TEXT_ROUTES,
)

URGENT_THREADS: Final = 20
"""Threads for what stops an arm, or lets go of it: other requests cannot use them up."""


def app(studio: Studio) -> Starlette:
    """The application of one studio; a `Guard` stands before it."""
    made = Starlette(routes=list(ROUTES))
    made.state.studio = studio
    made.state.urgent = CapacityLimiter(URGENT_THREADS)
    return made
