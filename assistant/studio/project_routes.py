"""The project: its tree, opening and creating, and what is dropped onto it."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.diagnostics import Refused
from assistant.studio.answering import Question, asks, changes, finding_records, looks
from assistant.studio.studio import Studio


def project(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """The tree, and what the project's file says: a project that is wrong has its findings."""
    from assistant.studio.tree import MOST_FILES, file_tree

    files = file_tree(studio.folder)
    return {
        "folder": str(studio.folder),
        "name": studio.folder.name or str(studio.folder),
        "files": files,
        "more": len(files) == MOST_FILES,
        **_project_record(studio),
    }


def _project_record(studio: Studio) -> dict[str, Any]:
    from assistant.project import project_of
    from assistant.project.rules import NO_PROJECT

    nothing: dict[str, Any] = {"there": False, "programs": [], "targets": [], "controllers": []}
    try:
        found = project_of(studio.folder)
    except Refused as refused:
        codes = {finding.code for finding in refused.findings}
        told = [] if codes == {NO_PROJECT.code} else finding_records(refused.findings)
        return nothing | {"there": codes != {NO_PROJECT.code}, "findings": told}
    return {
        "there": True,
        "programs": [
            {"name": one.name, "source": studio.named(one.source)}
            for one in found.programs.values()
        ],
        "targets": [
            {
                "name": place.name,
                "controller": place.controller.name,
                "programs": [one.name for one in place.recipes],
            }
            for place in found.places
        ],
        "controllers": _controller_records(studio),
        "findings": [],
    }


def _controller_records(studio: Studio) -> list[dict[str, Any]]:
    from assistant.controllers import controllers_of

    return [
        {
            "name": one.name,
            "address": str(one.address),
            "virtual": one.virtual,
            "robot": one.robot,
        }
        for one in controllers_of(studio.folder).values()
    ]


def create(studio: Studio, asked: Question) -> dict[str, Any]:
    """Starts a project in the folder: an example, or nothing but its file."""
    from assistant.project.starting import start_project
    from assistant.studio.dropping import start_empty

    done = start_empty(studio.folder) if asked.truth("empty") else start_project(studio.folder)
    return {
        "written": [studio.named(file) for file in done.written],
        "findings": finding_records(done.findings),
    }


def open_folder(studio: Studio, asked: Question) -> dict[str, Any]:
    """Works on another folder; what runs or is connected ends."""
    folder = FilePath(asked.text("folder")).expanduser()
    if not folder.is_absolute():
        folder = studio.folder / folder
    studio.folder_at(folder)  # for one that is not there nothing ends
    with studio.beginning:
        studio.end()
        studio.go_to(folder)
    studio.windows.tell({"kind": "project"})
    return {"folder": str(studio.folder)}


def drop(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.studio.dropping import drop_file

    return drop_file(studio, asked.text("name"), asked.data)


def drawing(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.studio.processes import drawing_layers

    return drawing_layers(studio, asked.text("path"))


def process(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.studio.processes import write_process

    return write_process(studio, asked.text("path"), asked.table("values"))


def check(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """What `check` finds in the project."""
    from assistant.project import project_of
    from assistant.project.checking import check as checked

    done = checked(project_of(studio.folder))
    return {"programs": done.programs, "findings": finding_records(done.findings)}


def build(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Compiles the programs of the project for its targets, as `build` does."""
    from assistant.project import build as built
    from assistant.project import project_of
    from assistant.project.building import build_record

    done = built(project_of(studio.folder))
    return build_record(done, studio.named) | {"findings": finding_records(done.findings)}


PROJECT_ROUTES: Final = (
    looks("/project", project),
    changes("/project/create", create),
    changes("/project/open", open_folder),
    changes("/project/drop", drop),
    changes("/project/build", build),
    asks("/project/check", check),
    looks("/drawing", drawing),
    changes("/drawing/process", process),
)
