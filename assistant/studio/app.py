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
    *page.ROUTES,
    *window_routes.ROUTES,
    *project_routes.ROUTES,
    *run_routes.ROUTES,
    *controller_routes.ROUTES,
    *control_routes.ROUTES,
    *scene_routes.ROUTES,
    *text_routes.ROUTES,
)

URGENT: Final = 20
"""Threads for what stops an arm, or lets go of it: other requests cannot use them up."""


def app(studio: Studio) -> Starlette:
    """The application of one studio; a `Guard` stands before it."""
    made = Starlette(routes=list(ROUTES))
    made.state.studio = studio
    made.state.urgent = CapacityLimiter(URGENT)
    return made
