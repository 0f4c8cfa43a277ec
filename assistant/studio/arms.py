"""Which arm a program of a project is most likely for."""

from __future__ import annotations

from pathlib import PurePosixPath

from assistant.base.diagnostics import Refused
from assistant.studio.studio import Studio


def likely_arm(studio: Studio, path: str) -> str | None:
    """The robot of the recipe that makes a program or of the target it was built for, else of the
    first target; by its name, or by a file as the page names it. None where nothing tells.
    """
    from assistant.project import project_of

    try:
        project = project_of(studio.folder)
    except Refused:
        return None  # what is wrong with it stands beside its file
    file = studio.place(path)
    recipes = [(place, one) for place in project.places for one in place.recipes]
    own = [one.robot or place.controller.robot for place, one in recipes if one.source == file]
    folders = set(PurePosixPath(path).parts[:-1])
    built = [place.controller.robot for place in project.places if place.name in folders]
    first = [one.robot or place.controller.robot for place, one in recipes]
    return next((name for name in (*own, *built, *first) if name), None)
